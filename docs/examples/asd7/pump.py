#!/usr/bin/python3
"""Runs a pump on a 7-Series drive and shows what it does; Ctrl-C or the time's end stops it.

usage: pump.py PORT [--hz 50] [--seconds 20]
"""

import argparse
import time

import serial


class Drive:
    def __init__(self, path):
        self.port = serial.Serial(path, 9600, parity=serial.PARITY_EVEN, timeout=3)

    def ask(self, text):
        """Adds the sum and the end; the answer without them."""
        frame = f"({text}&"
        frame += f"{sum(frame.encode()) & 0xFF:02X})\r"
        self.port.write(frame.encode())
        answer = self.port.read_until(b"\r").decode()
        if not answer:
            raise SystemExit(f"no answer to {frame.strip()}")
        return answer[1 : answer.index("&")]

    def read(self, number):
        answer = self.ask(f"R{number}")
        if answer[0] in "Nn":
            raise SystemExit(f"{number}: error {answer[1:]}")
        return int(answer[5:], 16)

    def write(self, number, value):
        answer = self.ask(f"P{number}{value:04X}")
        if answer[0] in "Nn":
            raise SystemExit(f"{number}: error {answer[1:]}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("port")
    parser.add_argument("--hz", type=float, default=50)
    parser.add_argument("--seconds", type=float, default=20)
    options = parser.parse_args()
    drive = Drive(options.port)
    drive.write("FA01", round(options.hz * 100))
    drive.write("FA00", 0xC400)  # command and frequency priority, run
    try:
        end = time.monotonic() + options.seconds
        while time.monotonic() < end:
            frequency, current = drive.read("FD00") / 100, drive.read("FD03") / 100
            trip = drive.read("FC90")
            print(f"{frequency:6.2f} Hz  {current:6.2f} %  status {drive.read('FD01'):04X}")
            if trip:
                raise SystemExit(f"trip {trip:02X}")
            time.sleep(0.5)
    finally:
        drive.write("FA00", 0xC000)


if __name__ == "__main__":
    main()
