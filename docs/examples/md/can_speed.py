#!/usr/bin/env python3
"""Turns a motor by CAN and prints what it does.

The same PIDs as on RS-485 in extended CAN frames, through an SLCAN adapter. Needs Debian's python3-can
and nothing else; knows nothing of virtdrive, so it does the same with a controller on the desk.

    ./virtdrive run md400t --can-link /tmp/can &
    docs/examples/md/can_speed.py /tmp/can --rpm 600 --seconds 3
"""

import argparse
import struct
import time

import can

CONTROLLER, HOST, DEVICE = 183, 172, 1
REQ_PID_DATA, TQ_OFF, VEL_CMD, SPEED, CURRENT = 4, 5, 130, 138, 139


def send(bus, pid, data):
    identifier = CONTROLLER << 16 | HOST << 8 | DEVICE
    bus.send(can.Message(arbitration_id=identifier, data=[pid, *data], is_extended_id=True))


def read(bus, pid, layout):
    send(bus, REQ_PID_DATA, [pid])
    frame = bus.recv(1)
    if frame is None or frame.data[0] != pid:
        raise SystemExit(f"no answer, or another one: {frame}")
    return struct.unpack(layout, frame.data[1:])[0]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("port")
    parser.add_argument("--bitrate", type=int, default=50_000)
    parser.add_argument("--rpm", type=int, default=600)
    parser.add_argument("--seconds", type=float, default=3)
    options = parser.parse_args()

    bus = can.Bus(options.port, bustype="slcan", bitrate=options.bitrate, sleep_after_open=0)
    try:
        send(bus, VEL_CMD, struct.pack("<h", options.rpm))
        end = time.monotonic() + options.seconds
        while time.monotonic() < end:
            rpm, amperes = read(bus, SPEED, "<h"), read(bus, CURRENT, "<H") / 10
            time.sleep(0.1)
        print(f"{rpm} rpm, {amperes:.1f} A")
        send(bus, TQ_OFF, [0])
    finally:
        bus.shutdown()


if __name__ == "__main__":
    main()
