#!/usr/bin/env python3
"""Drives the two wheels of a small robot on a dual MD controller and counts where it went.

Begins as vendors' hosts do (signs, limit switches, positions), then sends both speeds and reads both
wheels in one frame, 20 times a second. Needs Debian's python3-serial and nothing else; knows nothing
of virtdrive, so it does the same with a controller on the desk.

    ./virtdrive run md200t --link /tmp/robot &
    docs/examples/md/two_wheels.py /tmp/robot --left 120 --right 80 --seconds 5
"""

import argparse
import math
import struct
import time

import serial

CONTROLLER, HOST, DEVICE = 183, 172, 1
COMMAND, POSI_RESET, INV_SIGN, USE_LIMIT_SW, INV_SIGN2 = 10, 13, 16, 17, 18
PNT_VEL_CMD, PNT_MAIN_DATA = 207, 210
ALARM_RESET, RETURN_MAIN_DATA = 8, 2
COUNTS_PER_TURN = 60  # 20 poles x 3


def send(port, pid, data=b""):
    body = bytes([CONTROLLER, HOST, DEVICE, pid, len(data), *data])
    port.write(body + bytes([-sum(body) & 0xFF]))


def receive(port, pid):
    head = port.read(5)
    rest = port.read(head[4] + 1) if len(head) == 5 else b""
    if not rest or sum(head + rest) & 0xFF or head[3] != pid:
        raise SystemExit(f"no answer, or another one: {(head + rest).hex(' ')}")
    return rest[:-1]


def drive(port, left, right):
    """Sends both speeds; rpm and counts of both wheels."""
    data = struct.pack("<BhBhB", 1, left, 1, right, RETURN_MAIN_DATA)
    send(port, PNT_VEL_CMD, data)
    wheels = struct.iter_unpack("<hHBi", receive(port, PNT_MAIN_DATA))
    return [(rpm, counts) for rpm, _, _, counts in wheels]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("port")
    parser.add_argument("--baud", type=int, default=19200)
    parser.add_argument("--left", type=int, default=120, help="rpm")
    parser.add_argument("--right", type=int, default=80, help="rpm")
    parser.add_argument("--seconds", type=float, default=5)
    parser.add_argument("--wheel", type=float, default=0.17, help="diameter, m")
    parser.add_argument("--track", type=float, default=0.40, help="distance of the wheels, m")
    options = parser.parse_args()

    with serial.Serial(options.port, options.baud, timeout=1) as port:
        send(port, INV_SIGN, [1])  # the left motor looks the other way
        send(port, INV_SIGN2, [0])
        send(port, USE_LIMIT_SW, [0])
        send(port, COMMAND, [ALARM_RESET])
        send(port, POSI_RESET)
        end = time.monotonic() + options.seconds
        while time.monotonic() < end:
            (left_rpm, left), (right_rpm, right) = drive(port, options.left, options.right)
            time.sleep(0.05)
        drive(port, 0, 0)
    metres = math.pi * options.wheel / COUNTS_PER_TURN
    print(f"left {left_rpm} rpm {left} counts, right {right_rpm} rpm {right} counts")
    print(f"way {metres * (left + right) / 2:.2f} m, "
          f"turned {math.degrees(metres * (right - left) / options.track):.0f} degrees")


if __name__ == "__main__":
    main()
