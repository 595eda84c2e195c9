"""A host for the MD controllers on RS-485.

Written from the maker's document alone ("Communication protocol on RS485, BLDC driver", V4.4,
2019-07-16), as a second opinion: it shares no table and no line with the program under test. The
functions of its sample program (2.5) bear their names here.
"""

import struct
from typing import NamedTuple

import serial

CONTROLLER, HOST, ALL = 183, 172, 254  # 2.1
BAUD = 19200  # p. 4, all but MDA200 and MDA400
WRITE_CHECK = 0xAA

# PIDs (2.4)
VERSION, REQ_PID_DATA, TQ_OFF, COMMAND, ALARM_RESET, POSI_RESET = 1, 4, 5, 10, 12, 13
INV_SIGN_CMD, USE_LIMIT_SW, INV_SIGN_CMD2 = 16, 17, 18
VEL_CMD, ID, BAUD_RATE, INT_RPM_DATA, RETURN_TYPE = 130, 133, 135, 138, 149
MAIN_DATA, IO_MONITOR, MONITOR, MAIN_DATA2, TYPE = 193, 194, 196, 200, 205
PNT_VEL_CMD, PNT_MAIN_DATA, POSI_VEL_CMD = 207, 210, 219
RETURN_MAIN_DATA = 2  # last byte of the PNT commands


def IsChkSumOK(data):
    return sum(data) & 0xFF == 0


def GetChecksum(data):
    return ~sum(data) + 1 & 0xFF


def Byte2Int(low, high):
    return (low | high << 8) - (0x10000 if high & 0x80 else 0)


def Byte2LInt(b1, b2, b3, b4):
    return (b1 | b2 << 8 | b3 << 16 | b4 << 24) - (1 << 32 if b4 & 0x80 else 0)


def Int2Byte(value):
    return bytes([value & 0xFF, value >> 8 & 0xFF])


class MainData(NamedTuple):
    rpm: int
    current: int
    type: int
    ref_vel: int
    out: int
    status: int
    posi: int
    brake_duty: int
    temp: int


def GetMainData(d):
    return MainData(
        Byte2Int(d[0], d[1]),
        Byte2Int(d[2], d[3]),
        d[4],
        Byte2Int(d[5], d[6]),
        Byte2Int(d[7], d[8]),
        d[9],
        Byte2LInt(*d[10:14]),
        d[14],
        d[15],
    )


class Wheel(NamedTuple):
    rpm: int
    current: int
    status: int
    posi: int


def two_wheels(d):
    """PID 210, 18 bytes (p. 22)."""
    return [Wheel(*struct.unpack("<hhBi", d[at : at + 9])) for at in (0, 9)]


def frame(pid, data=b"", device=1, host=HOST):
    body = bytes([CONTROLLER, host, device, pid, len(data), *data])
    return body + bytes([GetChecksum(body)])


class NoAnswer(Exception):
    pass


class Host:
    def __init__(self, path, baud=BAUD, device=1, host=HOST, patience_s=10.0):
        self.port = serial.Serial(path, baud, timeout=patience_s)
        self.device = device
        self.host = host

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.port.close()

    def send(self, pid, data=b"", device=None):
        self.port.write(frame(pid, data, self.device if device is None else device, self.host))

    def receive(self):
        """PID and data of the next frame; it must be one, to this host."""
        head = self.port.read(5)
        if len(head) < 5:
            raise NoAnswer(head.hex(" "))
        rest = self.port.read(head[4] + 1)
        if head[0] != self.host or head[1] != CONTROLLER or not IsChkSumOK(head + rest):
            raise NoAnswer((head + rest).hex(" "))
        return head[3], rest[:-1]

    def request(self, pid, device=None):
        self.send(REQ_PID_DATA, [pid], device)
        got, data = self.receive()
        if got != pid:
            raise NoAnswer(f"PID {got} instead of {pid}")
        return data

    def main_data(self, pid=MAIN_DATA, device=None):
        return GetMainData(self.request(pid, device))

    def two_speeds(self, left, right, return_type=0):
        self.send(PNT_VEL_CMD, b"\1" + Int2Byte(left) + b"\1" + Int2Byte(right) + bytes([return_type]))
