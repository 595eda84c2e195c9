"""A second opinion on the 7-Series' frames in all their formats, and on Modbus RTU, one by one.

usage: virtdrive_asd7_frames COUNT SEED | asd7_oracle.py COUNT

Each line holds a direction, a frame in hexadecimal, its format, and what the program under test made
of it. This decoder shares no table with that program: it is written from the "7-Series Serial
Communications User Manual", 53840-001 (p. 22-25), and from what VF-S11's, VF-AS1's and VF-S15's manuals
print, with the sums of tests/e2e/asd7.py. Which numbers exist is the table's to say: a number that the
program says it has not is taken as such. The first frame on which the two do not agree ends the run.
"""

import collections
import pathlib
import re
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "e2e"))

import asd7  # noqa: E402

# Positions rule: [NN] C, four digits of the number, data, [&SS], [)], CR.
NUMBER = r"(?P<asd>[0-9*]{2})?"
TAIL = r"(?P<sum>&[0-9A-Fa-f]{2})?(?P<close>\))?"
UNKNOWN = re.compile(r"\(" + NUMBER + r"(?P<command>[A-Za-z])[^&)]*" + TAIL + r"\r", re.DOTALL)
KNOWN = re.compile(
    r"\(" + NUMBER + r"(?P<command>[A-Za-z])(?P<number>[0-9A-Fa-f]{4})(?P<data>[0-9A-Fa-f]*)" + TAIL + r"\r"
)
ASCII_WITH_DATA = {"W": True, "P": True, "R": False}
BINARY_WITH_DATA = {**ASCII_WITH_DATA, "G": True, "S": True, "s": True}
WITHOUT_ANSWER = "Ss"
REPLY_SIZES = {"N": 0, "W": 1, "P": 1, "R": 1, "G": 1}  # data fields behind the first word


def ascii_verdict(frame, reply):
    if len(frame) > 32 and b"\r" not in frame[:32]:
        return "silence"
    if b"(" in frame[1:]:
        return "silence"  # another frame begins
    if b"\r" not in frame:
        return "incomplete"
    text = frame[: frame.index(b"\r") + 1].decode("latin-1")
    loose = UNKNOWN.fullmatch(text)
    if not loose and not KNOWN.fullmatch(text):
        return "silence"
    command = (loose or KNOWN.fullmatch(text))["command"]
    known = command.upper() in "NWPR" if reply else command in ASCII_WITH_DATA
    match = KNOWN.fullmatch(text) if known else loose
    if not match or (reply and not known):
        return "silence"
    data = match["data"] if known else ""
    if known and not reply and not ASCII_WITH_DATA[command] and data:
        return "silence"
    if known and reply and len(data) != (0 if command.upper() == "N" else 4):
        return "silence"
    digits = match["sum"]
    if digits and int(digits[1:], 16) != asd7.checksum(frame[: text.index("&") + 1]):
        return "bad_sum"
    if not known:
        return "no_command"
    if not reply and ASCII_WITH_DATA[command] and not 1 <= len(data) <= 4:
        return "too_many_digits"
    return " ".join(
        [
            "ok",
            match["asd"] or "-",
            command,
            match["number"].lower(),
            f"{int(data, 16):04x}" if data else "-",
            "sum" if digits else "bare",
            "closed" if match["close"] else "open",
        ]
    )


def binary_verdict(frame, reply):
    at, asd, wide = 1, "-", False
    if at < len(frame) and (frame[at] <= 0x3F or frame[at] == 0xFF):
        asd = "**" if frame[at] == 0xFF else f"{frame[at]:02d}"
        at += 1
    if at < len(frame) and frame[at] == ord("L"):
        wide = True
        at += 1
    if at == len(frame):
        return "incomplete"
    command = chr(frame[at])
    if reply:
        if command.upper() not in REPLY_SIZES:
            return "unknown_command"
        fields = REPLY_SIZES[command.upper()]
    elif command not in BINARY_WITH_DATA:
        return "unknown_command"
    else:
        fields = 1 if BINARY_WITH_DATA[command] else 0
    end = at + 3 + fields * (4 if wide else 2)
    if len(frame) <= end:
        return "incomplete"
    if asd7.checksum(frame[:end]) != frame[end]:
        return "bad_sum"
    data = frame[at + 3 : end].hex() or "-"
    return f"ok {asd} {command} {frame[at + 1 : at + 3].hex()} {data}"


# Function: sizes of the fields, of a request and of a reply.
FUNCTIONS = {3: ((2, 2), (1, 2)), 6: ((2, 2), (2, 2)), 16: ((2, 2, 1, 2), (2, 2))}


def modbus_verdict(frame, reply):
    if len(frame) < 4:
        return "too_short"
    body, crc = frame[:-2], int.from_bytes(frame[-2:], "little")
    if asd7.crc16(body) != crc:
        return "bad_crc"
    unit, function, data = body[0], body[1], body[2:]
    if reply and function & 0x80 and len(data) == 1:
        return f"exception {unit} {data[0]}"
    code = function & 0x7F if reply else function
    if code not in FUNCTIONS:
        return f"no_function {unit}"
    if reply and function & 0x80:
        return "other_length"  # an exception has one byte
    fields = FUNCTIONS[code][reply]
    if len(data) != sum(fields):
        return "other_length"
    numbers = []
    for size in fields:
        numbers.append(int.from_bytes(data[:size], "big"))
        data = data[size:]
    return " ".join(map(str, ["ok", unit, function, *numbers]))


VERDICTS = {"ascii": ascii_verdict, "binary": binary_verdict, "modbus": modbus_verdict}


def judge(line, seen):
    """None if we agree on the line, else what we say. Counts what was seen."""
    direction, digits, mode, *theirs = line.split()
    frame = bytes.fromhex(digits)
    if mode != "modbus":  # a frame that is spoilt in its first byte is another
        mode = {b"(": "ascii", b"/": "binary"}.get(frame[:1], "none")
    ours = "noise" if mode == "none" else VERDICTS[mode](frame, direction == "reply")
    if mode == "none" and frame[0] in b"\r\n":
        return None
    seen[direction, mode, ours.split()[0]] += 1
    said = " ".join(theirs)
    if said == "no_number" and ours.split()[0] in ("ok", "too_many_digits"):
        return None
    return None if said == ours else ours


def main(count):
    seen = collections.Counter()
    total = 0
    for line in sys.stdin:
        total += 1
        other = judge(line, seen)
        if other is not None:
            print(f"disagree on: {line.rstrip()}\nthe oracle says: {other}")
            return 1
    if total != count:
        print(f"{total} frames instead of {count}")
        return 1
    wanted = [(d, m, "ok") for d in ("request", "reply") for m in VERDICTS]
    wanted += [(d, m, "bad_sum") for d in ("request", "reply") for m in ("ascii", "binary")]
    wanted += [("request", "ascii", v) for v in ("silence", "no_command", "incomplete")]
    wanted += [("request", "binary", v) for v in ("unknown_command", "incomplete")]
    wanted += [("request", "modbus", "bad_crc"), ("reply", "modbus", "exception")]
    never = [what for what in wanted if not seen[what]]
    if never:
        print(f"never seen: {never}")
        return 1
    print(f"{total} frames agreed")
    return 0


if __name__ == "__main__":
    sys.exit(main(int(sys.argv[1])))
