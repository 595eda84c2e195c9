#!/usr/bin/env python3
"""Commissions a motor on Toshiba's MCU Motor Studio firmware 3.10.

Reads all parameters, starts the motor, takes an oscilloscope shot of the three phase currents and
draws it as SVG. Needs Debian's python3-serial and nothing else; knows nothing of virtdrive, so it
does the same with a board on the desk.

    ./virtdrive run toshiba-mcu --link /tmp/drive --load brake:15mNm,inertia:1e-5 &
    docs/examples/toshiba-mcu/commission.py /tmp/drive --svg phase-currents.svg
"""

import argparse
import struct
import sys
import time

import serial

BOT, EOT, ERROR = 0x11, 0x13, 0xEE
SYSTEM = 0xFF  # motor number -1
NOT_READY = -2

START, STOP, STATE = 0x00, 0x01, 0x02
ARM_SCOPE, SCOPE_DATA = 0x05, 0x06
GET, SET, VERSION = 0x09, 0x0A, 0x14
REPLY_BYTES = {START: 1, STOP: 1, STATE: 20, ARM_SCOPE: 2, SCOPE_DATA: 32, GET: 5, SET: 1,
               VERSION: 2, ERROR: 1}

SPEED, PWM_FREQUENCY, STAGE, ERRORS = 0xE5, 0x50, 0xE3, 0xE1
SENSITIVITY, GAIN = 0x72, 0x74
GAINS = (1, 2, 4, 5, 8, 10, 16, 32)
FOC = 6

PARAMETERS = {
    0x10: "PolePairs", 0x11: "Direction", 0x12: "MaxAngAcc", 0x13: "TorqueFactor",
    0x14: "Resistance", 0x15: "Inductance", 0x16: "SpeedLimit", 0x17: "SpeedChange",
    0x18: "PositionDelay", 0x19: "IqStart", 0x1A: "IdStart", 0x1B: "IqLimit", 0x1C: "IdLimit",
    0x30: "Encoder", 0x31: "EncoderUsage", 0x32: "EncoderResolution", 0x33: "EncoderMinPos",
    0x34: "EncoderStartPos", 0x35: "EncoderMaxPos", 0x36: "EncoderLMApproach",
    0x37: "EncoderGearFactor", 0x40: "PiIdKi", 0x41: "PiIdKp", 0x42: "PiIqKi", 0x43: "PiIqKp",
    0x44: "PositionKi", 0x45: "PositionKp", 0x46: "SpeedKi", 0x47: "SpeedKp",
    0x50: "PwmFrequency", 0x51: "ShutdownMode", 0x52: "Braketime", 0x53: "Brakepercentage",
    0x54: "RestartMode", 0x55: "StalldetectValue", 0x56: "Overtemperature", 0x57: "CanId",
    0x58: "ExternalSpeedControl", 0x59: "SwOvervoltage", 0x5A: "SwUndervoltage",
    0x5B: "SwOvercurrent", 0x5C: "SpeedReduction", 0x70: "Deadtime", 0x71: "BootstrapDelay",
    0x72: "SensitivityCurrentMeasure", 0x73: "SensitivityVoltageMeasure",
    0x74: "GainCurrentMeasure", 0x75: "MeasurementType", 0x76: "SensorDirection", 0x77: "PolL",
    0x78: "PolH",
}  # fmt: skip
MOTOR_ID = 0x1D

PHASES = ("Ia", "Ib", "Ic")
FIRST_PHASE_BIT = 20  # of selected_values
RISING = 1
COLOURS = ("#0969da", "#bf3989", "#1a7f37")


class DriveError(Exception):
    """The drive refused, or said nothing, or nonsense."""

    def __init__(self, text, code=None):
        super().__init__(text)
        self.code = code


class Drive:
    def __init__(self, path):
        self.port = serial.Serial(path, 115200, timeout=1.0)

    def ask(self, command, request, reply):
        """Sends a request packed by struct formats; the values of its reply."""
        payload = struct.pack("<" + request[0], *request[1:])
        self.port.write(bytes([BOT, command, *payload, crc8(command, payload), EOT]))
        head = self.port.read(2)
        if len(head) < 2 or head[0] != BOT or head[1] not in (command, ERROR):
            raise DriveError(f"no answer to command {command:02x}: {head.hex(' ') or 'silence'}")
        body = self.port.read(REPLY_BYTES[head[1]] + 2)
        payload = body[:-2]
        if len(body) < 3 or body[-2] != crc8(head[1], payload) or body[-1] != EOT:
            raise DriveError(f"the answer to command {command:02x} is damaged")
        if head[1] == ERROR:
            (code,) = struct.unpack("<b", payload)
            raise DriveError(f"command {command:02x} is refused with code {code}", code)
        return struct.unpack("<" + reply, payload)

    def get(self, motor, parameter, offset=0):
        """Value and unit code."""
        return self.ask(GET, ("BBB", motor, parameter, offset), "ib")

    def set(self, motor, parameter, value, unit=0):
        self.ask(SET, ("BBbi", motor, parameter, unit, value), "B")

    def name(self, motor):
        words = [self.get(motor, MOTOR_ID, offset)[0] for offset in range(0, 20, 4)]
        return struct.pack("<5i", *words).rstrip(b"\0").decode("ascii", "replace")

    def shot(self, motor, selected, count, trigger_on, level, spread):
        """Sets of `count` values each, as soon as the drive has them."""
        arm = ("BIIBHB", motor, selected, trigger_on, RISING, level & 0xFFFF, spread)
        (blocks,) = self.ask(ARM_SCOPE, arm, "H")
        values = []
        while len(values) < 16 * blocks:
            try:
                values += self.ask(SCOPE_DATA, ("B", 0), "16h")
            except DriveError as error:
                if error.code != NOT_READY:
                    raise
                time.sleep(0.02)
        # The last block goes on from the start of the ring: only whole sets count.
        depth = self.get(SYSTEM, 0x93)[0] // count
        return [values[i * count : (i + 1) * count] for i in range(depth)]


def crc8(command, payload):
    crc = command
    for byte in payload:
        crc ^= byte
        for _ in range(8):
            crc = (crc << 1 ^ 0x07) & 0xFF if crc & 0x80 else crc << 1
    return crc


def spin_up(drive, motor, rpm):
    """Starts the motor and waits for the speed; gives up after 30 s."""
    drive.set(motor, SPEED, rpm)
    drive.ask(START, ("B", motor), "B")
    until = time.monotonic() + 30
    while time.monotonic() < until:
        actual = drive.ask(STATE, ("B", motor), "iiIII")[0]
        stage, errors = drive.get(motor, STAGE)[0], drive.get(motor, ERRORS)[0]
        print(f"\r  stage {stage}, {actual:5d} rpm, errors {errors:#x} ", end="", flush=True)
        if stage == FOC and abs(actual - rpm) <= max(5, abs(rpm) // 200):
            print()
            return
        time.sleep(0.1)
    raise DriveError("the motor does not reach its speed")


def nice_step(span, parts):
    """A round step that divides a span into about so many parts."""
    rough = span / parts
    scale = 10 ** -6
    while scale * 10 <= rough:
        scale *= 10
    return next(scale * factor for factor in (1, 2, 5, 10) if scale * factor >= rough)


def svg(shot, period_s, title):
    """Phase currents in A over ms."""
    width, height, left, right, top, bottom = 860, 380, 64, 24, 46, 48
    span_ms = (len(shot) - 1) * period_s * 1e3
    peak = max(abs(value) for values in shot for value in values) * 1.15

    def x(ms):
        return left + ms / span_ms * (width - left - right)

    def y(ampere):
        return top + (peak - ampere) / (2 * peak) * (height - top - bottom)

    out = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" '
        'font-family="Helvetica, Arial, sans-serif" font-size="13">',
        f'<rect width="{width}" height="{height}" fill="#ffffff"/>',
        f'<text x="{left}" y="24" font-size="15" font-weight="bold" fill="#24292f">{title}</text>',
    ]
    step = nice_step(span_ms, 12)
    for i in range(int(span_ms / step) + 1):
        at = x(i * step)
        out.append(f'<path d="M{at:.1f} {top}V{height - bottom}" stroke="#d8dee4"/>')
        out.append(f'<text x="{at:.1f}" y="{height - bottom + 18}" text-anchor="middle" '
                   f'fill="#57606a">{i * step:g}</text>')
    step = nice_step(2 * peak, 10)
    for i in range(-int(peak / step), int(peak / step) + 1):
        at = y(i * step)
        out.append(f'<path d="M{left} {at:.1f}H{width - right}" stroke="#d8dee4"/>')
        out.append(f'<text x="{left - 8}" y="{at + 4:.1f}" text-anchor="end" '
                   f'fill="#57606a">{i * step:g}</text>')
    for phase, (name, colour) in enumerate(zip(PHASES, COLOURS)):
        points = " ".join(f"{x(i * period_s * 1e3):.1f},{y(values[phase]):.1f}"
                          for i, values in enumerate(shot))
        out.append(f'<polyline points="{points}" fill="none" stroke="{colour}" stroke-width="1.8"/>')
        out.append(f'<text x="{width - right - 40 * (3 - phase)}" y="24" font-weight="bold" '
                   f'fill="{colour}">{name}</text>')
    out.append(f'<text x="{(left + width - right) / 2}" y="{height - 10}" text-anchor="middle" '
               'fill="#24292f">ms</text>')
    out.append(f'<text x="18" y="{(top + height - bottom) / 2}" fill="#24292f">A</text>')
    out.append("</svg>")
    return "\n".join(out) + "\n"


def commission(drive, motor, rpm, path):
    major, minor = drive.ask(VERSION, ("B", 0), "BB")
    name = drive.name(motor)
    print(f"firmware {major}.{minor}, motor {motor}: {name}")
    settings = {}
    for parameter, label in PARAMETERS.items():
        settings[parameter] = drive.get(motor, parameter)
        print(f"  {parameter:02X} {label:<26} {settings[parameter][0]:>11} unit {settings[parameter][1]}")

    spin_up(drive, motor, rpm)
    # Full scale: 2.5 V at the converter. About two electrical turns shall fit the picture.
    sensitivity, unit = settings[SENSITIVITY]
    full_scale_a = 2.5 / (sensitivity * 10.0**unit * GAINS[settings[GAIN][0]])
    frequency = settings[PWM_FREQUENCY][0]
    depth = drive.get(SYSTEM, 0x93)[0] // len(PHASES)
    turn_s = 60 / (abs(rpm) * settings[0x10][0])
    spread = min(255, max(0, round(2 * turn_s * frequency / depth) - 1))
    first = 1 << FIRST_PHASE_BIT
    shot = drive.shot(motor, 7 * first, len(PHASES), trigger_on=first, level=0, spread=spread)
    amperes = [[value / 32768 * full_scale_a for value in values] for values in shot]
    current_ma = drive.ask(STATE, ("B", motor), "iiIII")[2]
    drive.ask(STOP, ("B", motor), "B")

    peak = max(abs(value) for values in amperes for value in values)
    print(f"  {len(shot)} sets, peak {peak:.2f} A, the drive reports {current_ma} mA")
    with open(path, "w", encoding="utf-8") as file:
        file.write(svg(amperes, (spread + 1) / frequency, f"{name} at {rpm} rpm: phase currents"))
    print(f"  {path}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("port", help="the drive's serial port")
    parser.add_argument("--motor", type=int, default=1, help="channel, 0 to 2")
    parser.add_argument("--rpm", type=int, default=2000)
    parser.add_argument("--svg", default="phase-currents.svg", help="where the picture goes")
    options = parser.parse_args()
    try:
        commission(Drive(options.port), options.motor, options.rpm, options.svg)
    except (DriveError, serial.SerialException) as error:
        sys.exit(f"commission: {error}")


if __name__ == "__main__":
    main()
