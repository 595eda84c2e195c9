"""A second opinion on the MD series' frames, one by one.

usage: virtdrive_md485_frames COUNT SEED | md485_oracle.py COUNT

Each line holds a direction, a frame in hexadecimal, and what the program under test made of it. This
decoder shares no table with that program: it is written from "Communication protocol on RS485, BLDC
driver", V4.4, 2019-07-16, with the functions of its sample program (2.5, in tests/e2e/md.py). Sums
and lengths are judged for every frame; the numbers of a frame for the PIDs below, as the document
lays them out. The first frame on which the two do not agree ends the run.
"""

import collections
import pathlib
import struct
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "e2e"))

import md  # noqa: E402

BYTE, INT, WORD, LONG = "B", "h", "H", "i"

# Commands: the data that a host sends (2.4).
COMMANDS = {
    3: BYTE,
    4: BYTE,
    5: BYTE,
    6: BYTE,
    10: BYTE,
    12: BYTE,
    13: BYTE,
    14: BYTE,
    15: BYTE,
    30: BYTE,
    31: BYTE,
    100: BYTE,
    130: INT,
    131: INT,
    134: INT,
    140: INT,
    164: BYTE * 2,
    174: BYTE * 3,
    175: BYTE * 3,
    206: (BYTE + LONG + INT) * 2 + BYTE,
    207: (BYTE + INT) * 2 + BYTE,
    208: (BYTE + INT) * 2 + BYTE,
    209: (BYTE + INT) * 2 + BYTE,
    215: (BYTE + LONG) * 2 + BYTE,
    217: LONG,
    218: LONG,
    219: LONG + INT,
    220: LONG + INT,
    242: (BYTE + LONG + INT) * 2 + BYTE,
    243: LONG,
    244: LONG,
    246: (BYTE + LONG) * 2 + BYTE,
    251: LONG,
}
# Parameters, as they are read and written.
PARAMETERS = {
    **{pid: BYTE for pid in (1, 16, 17, 18, 19, 21, 24, 25, 34, 36, 37, 38, 40, 41, 44, 45)},
    **{pid: INT for pid in (138, 153, 154, 155, 156, 157, 158, 160, 162, 166, 167, 168, 169, 170)},
    **{pid: INT for pid in (171, 176, 177, 178, 179, 211, 221)},
    **{pid: LONG for pid in (230, 231, 232, 233)},
    203: INT * 3,
    210: (INT + WORD + BYTE + LONG) * 2,
    222: INT * 2,
    225: BYTE + INT,
    226: BYTE + INT * 2,
    239: INT * 2,
    250: INT * 2,
}
CHECKED = {pid: BYTE for pid in (133, 135, 137, 146, 147, 149, 152)}  # behind 0xaa when written


def layout(direction, pid):
    if direction == "request" and pid in COMMANDS:
        return COMMANDS[pid]
    if pid in CHECKED:
        return (BYTE if direction == "request" else "") + CHECKED[pid]
    return PARAMETERS.get(pid)


def judge(line, seen):
    """None if we agree on the line, else what we say. Counts what was seen."""
    direction, digits, *theirs = line.split()
    frame = bytes.fromhex(digits)
    size = 6 + frame[4] if len(frame) > 4 else None
    if size is None or len(frame) < size:
        seen[direction, "incomplete"] += 1
        return None if theirs == ["incomplete"] else "incomplete"
    if not md.IsChkSumOK(frame[:size]):
        seen[direction, "bad_sum"] += 1
        return None if theirs == ["bad_sum"] else "bad_sum"
    to, source, device, pid = frame[:4]
    host = source if direction == "request" else to
    if md.frame(pid, frame[5 : size - 1], device, host)[4:] != frame[4:size] and direction == "request":
        return "encoded again it is another one"
    if theirs[:4] != ["frame", str(host), str(device), str(pid)]:
        return f"frame {host} {device} {pid}"
    quoted = layout(direction, pid)
    seen[direction, pid if quoted else "unread"] += 1
    if quoted is None:
        return None
    numbers = struct.unpack("<" + quoted, frame[5 : size - 1])
    return None if [str(n) for n in numbers] == theirs[4:] else f"numbers {numbers}"


def main(count):
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
    wanted = [("request", pid) for pid in {**COMMANDS, **PARAMETERS, **CHECKED}]
    wanted += [("reply", pid) for pid in {**PARAMETERS, **CHECKED}]
    wanted += [(d, v) for d in ("request", "reply") for v in ("incomplete", "bad_sum")]
    never = [what for what in wanted if not seen[what]]
    if never:
        print(f"never seen: {never}")
        return 1
    print(f"{total} frames agreed")
    return 0


if __name__ == "__main__":
    sys.exit(main(int(sys.argv[1])))
