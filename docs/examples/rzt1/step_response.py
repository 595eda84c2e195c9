#!/usr/bin/env python3
"""Takes a recorder shot of a step response on the RZ/T1 motion-control kit and draws it.

Switches the servo on, records position error, quadrature current and command velocity while the axis
moves a short way, reads the buffers with packet 7 and writes an SVG. Needs Debian's python3-serial and
nothing else; knows nothing of virtdrive, so it does the same with a kit on the desk.

    ./virtdrive run rzt1 --link /tmp/kit &
    docs/examples/rzt1/step_response.py /tmp/kit --svg step-response.svg
"""

import argparse
import struct
import sys
import time

import serial

CALL, SET, GET, TRACE, REPORT = 2, 5, 6, 7, 1
GO, ON, OFF = 85, 89, 90
# Variables: number and size (Appendix A).
ACC, DEC, VEL, REL, POS = (9, 4), (10, 4), (8, 4), (81, 4), (82, 4)
CH1, CH2, CH3, TRACE_TRIGGER, TRATE, TMODE = (103, 2), (104, 2), (105, 2), (107, 2), (74, 2), (73, 2)
COMMAND_VELOCITY, POSITION_ERROR, QUADRATURE_CURRENT = 1, 8, 12
UNTIL_FULL = 2
PHASED, BUSY = 0x80, 0x100
AMPERE_PER_COUNT = 20 / 2048  # of the kit's converter
CYCLE_S, SLOT_S = 100e-6, 50e-6


class Kit:
    def __init__(self, path, address):
        self.port = serial.Serial(path, 115200, timeout=2)
        self.address = address

    def ask(self, code, data, head=0):
        """So many bytes of the answer; its sum is read by more()."""
        body = bytes([self.address, len(data), code]) + bytes(data)
        self.port.write(b"\xaa" + body + bytes([sum(body) & 0xFF]))
        status = self.port.read(1)
        if status != b"\0":
            sys.exit(f"packet {code}: {'status %d' % status[0] if status else 'no answer'}")
        return self.port.read(head)

    def get(self, variable):
        data = self.ask(GET, [variable[0]], variable[1] + 1)[:-1]
        return int.from_bytes(data, "little", signed=True)

    def set(self, variable, value):
        number, size = variable
        self.ask(SET, bytes([number]) + (value & (1 << 8 * size) - 1).to_bytes(size, "little"), 1)

    def call(self, function):
        self.ask(CALL, [function], 1)

    def status(self):
        return struct.unpack("<H", self.ask(REPORT, struct.pack("<H", 2), 3)[:2])[0]

    def trace(self, buffer, four_bytes=False):
        count, size = struct.unpack("<HB", self.ask(TRACE, [buffer | 0x80 * four_bytes], 3))
        data = self.port.read(count * size + 1)[:-1]
        return struct.unpack(f"<{count}{'i' if size == 4 else 'h'}", data)


def shoot(kit, distance):
    kit.call(ON)
    while kit.status() & (PHASED | BUSY) != PHASED:
        time.sleep(0.02)
    time.sleep(0.2)
    kit.set(VEL, 30_000_000)
    kit.set(ACC, 150_000)
    kit.set(DEC, 150_000)
    for channel, source in ((CH1, COMMAND_VELOCITY), (CH2, POSITION_ERROR), (CH3, QUADRATURE_CURRENT)):
        kit.set(channel, source)
    kit.set(TRATE, 4)
    kit.set(TRACE_TRIGGER, 7)  # from the motion's start until the buffers are full
    kit.set(REL, distance)
    kit.call(GO)
    while kit.get(TMODE) != 0:
        time.sleep(0.02)
    velocity, error, current = kit.trace(0, True), kit.trace(1), kit.trace(2)
    kit.call(OFF)
    step_s = 4 * SLOT_S
    return (
        ("command velocity, counts/ms", [v / 65536 / CYCLE_S / 1000 for v in velocity], "#0969da"),
        ("position error, counts", list(error), "#bf3989"),
        ("quadrature current, A", [c * AMPERE_PER_COUNT for c in current], "#1a7f37"),
    ), step_s


def draw(rows, step_s):
    """Three plots above each other."""
    width, height, left, gap = 720, 150, 60, 46
    text = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {3 * (height + gap)}" '
        'font-family="sans-serif" font-size="12">',
        '<rect width="100%" height="100%" fill="#fff"/>',
    ]
    for i, (name, values, colour) in enumerate(rows):
        top = 24 + i * (height + gap)
        low, high = min(0, *values), max(0, *values)
        scale = (height - 10) / ((high - low) or 1)
        span = len(values) - 1

        def at(n, value):
            return f"{left + n * (width - left - 16) / span:.1f},{top + (high - value) * scale:.1f}"

        zero = top + high * scale
        text.append(f'<text x="{left}" y="{top - 8}" fill="{colour}">{name}</text>')
        text.append(f'<line x1="{left}" y1="{zero:.1f}" x2="{width - 16}" y2="{zero:.1f}" stroke="#ccc"/>')
        for value in sorted({low, high}):
            text.append(f'<text x="{left - 6}" y="{top + (high - value) * scale + 4:.1f}" '
                        f'text-anchor="end">{value:.{0 if abs(value) >= 100 else 2}f}</text>')
        points = " ".join(at(n, value) for n, value in enumerate(values))
        text.append(f'<polyline points="{points}" fill="none" stroke="{colour}" stroke-width="1.5"/>')
    text.append(f'<text x="{width - 16}" y="{3 * (height + gap) - 8}" text-anchor="end">'
                f'{(len(rows[0][1]) - 1) * step_s * 1000:.0f} ms</text>')
    return "\n".join(text) + "\n</svg>\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("port")
    parser.add_argument("--address", type=int, default=1)
    parser.add_argument("--distance", type=int, default=20000, help="counts (default 20000)")
    parser.add_argument("--svg", required=True)
    arguments = parser.parse_args()
    rows, step_s = shoot(Kit(arguments.port, arguments.address), arguments.distance)
    with open(arguments.svg, "w", encoding="utf-8") as file:
        file.write(draw(rows, step_s))
    for name, values, _ in rows:
        print(f"{name}: {min(values):.4g} ... {max(values):.4g}")


if __name__ == "__main__":
    main()
