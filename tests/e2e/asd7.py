"""A host for Toshiba's 7-Series drives, ASCII and binary, and what a Modbus host needs.

Written from the documents alone, as a second opinion: it shares no table and no line with the
program under test. "7-Series Serial Communications User Manual", 53840-001 (p. 22-25), has the 32-bit
frames and the broadcasts; the 16-bit frames, sums, commands and numbers are those that the manuals of
VF-S11, VF-AS1 and VF-S15 print.
"""

import serial

BAUD, PARITY = 9600, serial.PARITY_EVEN

# Communication numbers
ACC, DEC, FH, TIME_OUT, NUMBER = 0x0009, 0x0010, 0x0011, 0x0803, 0x0802
COMMAND, FREQUENCY = 0xFA00, 0xFA01
OUTPUT_FREQUENCY, STATUS, OUTPUT_CURRENT, TRIP = 0xFD00, 0xFD01, 0xFD03, 0xFC90
HELD_CURRENT = 0xFE03

# The command word, and the status word
RUN, REVERSE, EMERGENCY, RESET = 1 << 10, 1 << 9, 1 << 12, 1 << 13
FREQUENCY_PRIORITY, COMMAND_PRIORITY = 1 << 14, 1 << 15
PRIORITIES = COMMAND_PRIORITY | FREQUENCY_PRIORITY
TRIPPED, RUNNING, READY = 1 << 1, 1 << 10, 1 << 14


def checksum(data):
    return sum(data) & 0xFF


def ascii_frame(command, number, data=None, asd="", with_sum=True):
    """`(` [NN] C XXXX [DDDD] [& SS] `)` CR"""
    text = f"({asd}{command}{number:04X}" + ("" if data is None else f"{data:04X}")
    if with_sum:
        text += "&"
        text += f"{checksum(text.encode()):02X}"
    return (text + ")\r").encode()


def binary_frame(command, number, data=None, asd=None, wide=False):
    """`/` [no] [L] C hi lo [data] sum"""
    frame = b"/" + (b"" if asd is None else bytes([asd])) + (b"L" if wide else b"")
    frame += command.encode() + number.to_bytes(2, "big")
    if data is not None:
        size = 4 if wide else 2
        frame += (data & (1 << 8 * size) - 1).to_bytes(size, "big")
    return frame + bytes([checksum(frame)])


def crc16(data):
    """Of Modbus RTU; goes low byte first."""
    crc = 0xFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ 0xA001 if crc & 1 else crc >> 1
    return crc


class NoAnswer(Exception):
    pass


class Refused(Exception):
    """The drive's error code."""


class Host:
    """Speaks ASCII with sums. `asd` is a drive's two digits, or nothing."""

    def __init__(self, path, asd="", patience_s=10.0, baud=BAUD, parity=PARITY):
        self.port = serial.serial_for_url(path, baud, parity=parity, timeout=patience_s)
        self.asd = asd
        self.tripped = False

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.port.close()

    def ask(self, command, number, data=None, asd=None):
        """The data of the answer."""
        asd = self.asd if asd is None else asd
        self.port.write(ascii_frame(command, number, data, asd))
        return self.answer(command, number, asd.replace("*", "0"))

    def answer(self, command, number, asd):
        line = self.port.read_until(b"\r")
        if not line.endswith(b")\r") or not line.startswith(b"("):
            raise NoAnswer(line)
        body, _, digits = line[1:-2].partition(b"&")
        if digits != b"%02X" % checksum(b"(" + body + b"&"):
            raise NoAnswer(line)
        text = body.decode()
        if not text.startswith(asd):
            raise NoAnswer(line)
        text = text[len(asd) :]
        self.tripped = text[0].islower()
        if text[0].upper() == "N":
            raise Refused(int(text[1:], 16))
        if text[0].upper() != command or int(text[1:5], 16) != number or len(text) != 9:
            raise NoAnswer(line)
        return int(text[5:], 16)

    def read(self, number, asd=None):
        return self.ask("R", number, asd=asd)

    def write(self, number, value, asd=None):
        """Into RAM."""
        return self.ask("P", number, value, asd)

    def store(self, number, value, asd=None):
        """Into RAM and EEPROM."""
        return self.ask("W", number, value, asd)

    def run_at(self, hz, asd=None):
        self.write(FREQUENCY, round(hz * 100), asd)
        self.write(COMMAND, PRIORITIES | RUN, asd)

    def stop(self, asd=None):
        self.write(COMMAND, PRIORITIES, asd)
