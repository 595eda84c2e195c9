"""A second opinion on MCU Motor Studio's telegrams, frame by frame.

usage: virtdrive_toshiba_mcu_frames COUNT SEED | toshiba_mcu_oracle.py COUNT

Each line holds a direction, a frame in hexadecimal, and what the program under test made of it.
This decoder shares no table with that program: it is written from the maker's document ("Serial
Communication - Protocol Specification", Rev 1.1.0, 2022-10-21), whose sections are named below. It
must agree on every frame, and must encode what it decoded to the same bytes; the first frame on
which it does not ends the run.
"""

import collections
import pathlib
import struct
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "e2e"))

import toshiba_mcu as host  # noqa: E402  (the same document's constants and CRC)

GET_SLOT, VALUE_SLOT, SET_SLOT = "BB", "ib", "Bbi"  # 4.2.10, 4.2.11

# Command byte: payload of the request, payload of the answer (4.2.1 to 4.2.24). B, b: uint8_t,
# int8_t; H, h: uint16_t, int16_t; I, i: uint32_t, int32_t; without gaps.
PAYLOADS = {
    host.START_MOTOR: ("B", "B"),
    host.STOP_MOTOR: ("B", "B"),
    host.GET_MOTOR_STATE: ("B", "iiIII"),
    host.STORE_PARAMETERS: ("B", "B"),
    host.CLEAR_PARAMETERS: ("B", "B"),
    host.CONFIG_DSO_LOG: ("BIIBHB", "H"),
    host.GET_DSO_LOG_DATA: ("B", "16h"),
    host.CONFIGURE_HS_DSO: ("BBIB", "B"),
    host.DO_TURN: ("BhH", "B"),
    host.GET_ONE: ("B" + GET_SLOT, VALUE_SLOT),
    host.SET_ONE: ("B" + SET_SLOT, "B"),
    host.GET_MANY: ("BB" + host.SLOTS * GET_SLOT, "BB" + host.SLOTS * VALUE_SLOT),
    host.SET_MANY: ("BB" + host.SLOTS * SET_SLOT, "BB"),
    host.DO_LINEAR_MOTION: ("BIH", "B"),
    host.GET_ABSOLUTE_POSITION: ("B", "I"),
    host.ABORT_LINEAR_MOTION: ("B", "B"),
    host.START_TORQUE: ("B", "B"),
    host.GET_CONTROL_METHOD: ("B", "B"),
    host.SET_CONTROL_METHOD: ("BB", "B"),
    host.GET_ENCODER_COUNTER: ("B", "i"),
    host.GET_VERSION: ("B", "BB"),
    host.SET_DEMO_STATE: ("B", "B"),
    host.GET_DEMO_STATE: ("B", "B"),
    host.GET_EXTENDED_STATE: ("B", "iiIIIB"),
}
# The order of bytes is that of a Cortex-M3's memory (3): little-endian.
LAYOUTS = {
    "request": {command: struct.Struct("<" + q) for command, (q, _) in PAYLOADS.items()},
    "reply": {command: struct.Struct("<" + a) for command, (_, a) in PAYLOADS.items()},
}
LAYOUTS["reply"][host.ERROR] = struct.Struct("<b")  # 3; sign as in 4.2.7

# Section 6 is table-driven; a table is also what makes this fast.
CRC_TABLE = [host.crc8(byte, b"\0") for byte in range(256)]


def crc8(command, payload):
    crc = command
    for byte in payload:
        crc = CRC_TABLE[crc ^ byte]
    return crc


def encode(direction, command, values):
    payload = LAYOUTS[direction][command].pack(*values)
    return bytes([host.BOT, command]) + payload + bytes([crc8(command, payload), host.EOT])


def decode(direction, frame):
    """The verdict, and the values of a good telegram: [verdict] or ["telegram", command, ...]."""
    if frame[0] != host.BOT:
        return ["noise"]
    if len(frame) < 2:
        return ["incomplete"]
    layout = LAYOUTS[direction].get(frame[1])
    if layout is None:
        return ["unknown_command"]
    end = 2 + layout.size
    if len(frame) < end + 2:
        return ["incomplete"]
    if frame[end + 1] != host.EOT:
        return ["bad_end"]
    payload = frame[2:end]
    if frame[end] != crc8(frame[1], payload):
        return ["bad_crc"]
    return ["telegram", frame[1], *layout.unpack(payload)]


def judge(line, seen):
    """None if we agree on the line, else what we say. Counts what was seen."""
    direction, digits, *theirs = line.split()
    frame = bytes.fromhex(digits)
    ours = decode(direction, frame)
    seen[direction, ours[0], ours[1] if len(ours) > 1 else None] += 1
    if [str(word) for word in ours] != theirs:
        return " ".join(map(str, ours))
    if ours[0] == "telegram":
        again = encode(direction, ours[1], ours[2:])
        if again != frame[: len(again)]:
            return "encoded again: " + again.hex()
    return None


def missing(seen):
    """Telegrams and verdicts that did not occur at all: then the run proves too little."""
    telegrams = [(d, "telegram", command) for d, layouts in LAYOUTS.items() for command in layouts]
    verdicts = ("bad_crc", "bad_end", "unknown_command", "incomplete")
    spoilt = [(d, verdict, None) for d in LAYOUTS for verdict in verdicts]
    return [what for what in telegrams + spoilt if not seen[what]]


def main(count):
    for command, size in host.REPLY_SIZE.items():
        assert LAYOUTS["reply"][command].size == size, f"answer to {command:02x}: not {size} bytes"
    seen = collections.Counter()
    for line in sys.stdin:
        other = judge(line, seen)
        if other is not None:
            print(f"disagree on: {line.rstrip()}\nthe oracle says: {other}")
            return 1
    total = sum(seen.values())
    if total != count:
        print(f"{total} frames instead of {count}")
        return 1
    if missing(seen):
        print(f"never seen: {missing(seen)}")
        return 1
    good = sum(n for (_, verdict, _), n in seen.items() if verdict == "telegram")
    print(f"{total} frames agreed: {good} telegrams, {total - good} spoilt")
    return 0


if __name__ == "__main__":
    sys.exit(main(int(sys.argv[1])))
