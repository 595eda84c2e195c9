"""Reads pcapng files: a second opinion on the recordings of the program under test.

Written from draft-ietf-opsawg-pcapng (sections 3, 4 and 10) alone; knows nothing of virtdrive. What
the draft forbids raises Malformed.
"""

import struct
from typing import NamedTuple

SECTION_HEADER, INTERFACE, ENHANCED_PACKET = 0x0A0D0D0A, 1, 6
BYTE_ORDER_MAGIC = 0x1A2B3C4D

# Options that this reader understands (3.5, 4.1, 4.2, 4.3).
END_OF_OPTIONS, COMMENT = 0, 1
APPLICATION = 4
IF_NAME, IF_DESCRIPTION, IF_SPEED, IF_TSRESOL = 2, 3, 8, 9
EPB_FLAGS = 2

INBOUND, OUTBOUND = 1, 2


class Malformed(Exception):
    pass


class Interface(NamedTuple):
    link_type: int
    name: str
    description: str
    speed: int
    ticks_per_second: int


class Packet(NamedTuple):
    interface: int
    ticks: int  # of the interface, since 1970
    data: bytes
    flags: int
    comment: str
    options: dict  # code: values, as bytes

    @property
    def direction(self):
        return self.flags & 3

    @property
    def errors(self):
        """The link-layer errors, bits 16 to 31 of the flags."""
        return self.flags >> 16


class Block(NamedTuple):
    """One that this reader does not know: the draft has it skipped."""

    type: int
    body: bytes


class File(NamedTuple):
    comment: str
    application: str
    interfaces: list
    packets: list
    others: list
    truncated: bool  # the last block is not whole


def read(path):
    with open(path, "rb") as file:
        return parse(file.read())


def parse(data):
    if len(data) < 12 or data[:4] != SECTION_HEADER.to_bytes(4, "big"):
        raise Malformed("does not begin with a section header")
    order = "<" if data[8:12] == BYTE_ORDER_MAGIC.to_bytes(4, "little") else ">"
    comment = application = ""
    interfaces, packets, others = [], [], []
    offset = 0
    while offset < len(data):
        if len(data) - offset < 12:
            return File(comment, application, interfaces, packets, others, True)
        kind, length = struct.unpack_from(order + "II", data, offset)
        if length < 12 or length % 4:
            raise Malformed(f"block of {length} bytes at {offset}")
        if offset + length > len(data):
            return File(comment, application, interfaces, packets, others, True)
        if struct.unpack_from(order + "I", data, offset + length - 4)[0] != length:
            raise Malformed(f"two lengths at {offset}")
        body = data[offset + 8 : offset + length - 4]
        if kind == SECTION_HEADER:
            comment, application = section(order, body, offset)
        elif kind == INTERFACE:
            interfaces.append(interface(order, body))
        elif kind == ENHANCED_PACKET:
            packets.append(packet(order, body, interfaces))
        else:
            others.append(Block(kind, body))
        offset += length
    return File(comment, application, interfaces, packets, others, False)


def options(order, data):
    """code: [value, ...]; each value padded to 32 bits (3.5)."""
    found = {}
    offset = 0
    while offset < len(data):
        code, length = struct.unpack_from(order + "HH", data, offset)
        value = data[offset + 4 : offset + 4 + length]
        if len(value) != length:
            raise Malformed(f"option {code} is cut short")
        if code == END_OF_OPTIONS:
            if length or offset + 4 != len(data):
                raise Malformed("something behind the last option")
            return found
        found.setdefault(code, []).append(value)
        offset += 4 + (length + 3) // 4 * 4
        if any(data[offset - (-length % 4) : offset]):
            raise Malformed("an option's padding is not zero")
    if found:
        raise Malformed("options without an end")
    return found


def text(found, code):
    return found.get(code, [b""])[0].decode("utf-8")


def section(order, body, offset):
    magic, major, _, length = struct.unpack_from(order + "IHHq", body)
    if magic != BYTE_ORDER_MAGIC or major != 1 or length != -1 or offset:
        raise Malformed("section header")
    found = options(order, body[16:])
    return text(found, COMMENT), text(found, APPLICATION)


def interface(order, body):
    link_type, _, snap_length = struct.unpack_from(order + "HHI", body)
    if snap_length:
        raise Malformed("packets are cut short")
    found = options(order, body[8:])
    resolution = found.get(IF_TSRESOL, [b"\x06"])[0][0]
    base = 2 if resolution & 0x80 else 10
    return Interface(
        link_type,
        text(found, IF_NAME),
        text(found, IF_DESCRIPTION),
        struct.unpack(order + "Q", found.get(IF_SPEED, [bytes(8)])[0])[0],
        base ** (resolution & 0x7F),
    )


def packet(order, body, interfaces):
    number, high, low, captured, original = struct.unpack_from(order + "IIIII", body)
    if number >= len(interfaces) or captured != original:
        raise Malformed("packet")
    data = body[20 : 20 + captured]
    found = options(order, body[20 + (captured + 3) // 4 * 4 :])
    flags = struct.unpack(order + "I", found.get(EPB_FLAGS, [bytes(4)])[0])[0]
    return Packet(number, high << 32 | low, data, flags, text(found, COMMENT), found)
