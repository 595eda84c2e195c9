"""A second opinion on the RZ/T1 kit's requests and replies, one by one.

usage: virtdrive_rzt1_frames COUNT SEED | rzt1_oracle.py COUNT

Each line holds a kind, bytes in hexadecimal, and what the program under test made of them. This decoder
shares no table with that program: it is written from R11AN0086JJ0102, Rev.1.02 (Appendix A in
tests/e2e/rzt1.py). The first one on which the two do not agree ends the run.
"""

import collections
import pathlib
import re
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "e2e"))

import rzt1  # noqa: E402

BAD_CODE, BAD_INDEX, BAD_SIZE = 1, 2, 3
SIZES_OF_REQUESTS = {0: 0, 1: 2, 2: 1, 3: 1, 6: 1, 7: 1, 15: 1}  # data bytes (Appendix B)
CODES = set(SIZES_OF_REQUESTS) | {4, 5}
WIDTHS = (4, 2, 2, 2, 1, 1, 1, 1)  # of a report's fields (B.2)


def split(data, widths):
    """Numbers of these widths, LSB first, without their signs."""
    numbers = []
    for width in widths:
        numbers.append(int.from_bytes(data[:width], "little"))
        data = data[width:]
    return numbers


def packet(code, data):
    """Widths of the numbers that the data are, or the status to refuse them with."""
    if code not in CODES:
        return BAD_CODE
    if code in (2, 5, 6) and not data:
        return BAD_SIZE
    if code == 2:
        return [1] if data[0] in rzt1.COMMANDS and len(data) == 1 else (
            BAD_INDEX if data[0] not in rzt1.COMMANDS else BAD_SIZE)
    if code == 4:
        if len(data) < 8 or len(data) % 8 > 1 or (len(data) % 8 == 1 and data[0] != len(data) // 8):
            return BAD_SIZE
        return [1] * (len(data) % 8) + [4] * (len(data) // 4)
    if code in (5, 6):
        if code == 5 and data[0] == rzt1.IDS["SETUP"] and len(data) == 3:
            return [1, 2]
        if data[0] not in rzt1.VARIABLES:
            return BAD_INDEX
        widths = [1] + ([rzt1.VARIABLES[data[0]]] if code == 5 else [])
    elif code == 3 and len(data) == 2:
        widths = [1, 1]
    else:
        widths = [SIZES_OF_REQUESTS[code]] if SIZES_OF_REQUESTS[code] else []
    return widths if sum(widths) == len(data) else BAD_SIZE


def same(theirs, ours, widths):
    return len(theirs) == len(ours) and all(
        int(t) % (1 << 8 * w) == o for t, o, w in zip(theirs, ours, widths))


def judge_packet(frame, theirs, seen):
    if frame[0] != 0xAA:
        # A spoilt first byte: what follows is a line, or a packet further on.
        seen["packet", "start"] += 1
        return None
    if len(frame) < 3 or len(frame) < 5 + frame[2]:
        seen["packet", "incomplete"] += 1
        return None if theirs == ["incomplete"] else "incomplete"
    size = 5 + frame[2]
    if sum(frame[1 : size - 1]) & 0xFF != frame[size - 1]:
        seen["packet", "bad_sum"] += 1
        return None if theirs == ["bad_sum"] else "bad_sum"
    address, code, data = frame[1], frame[3], frame[4 : size - 1]
    if rzt1.packet(address, code, data) != frame[:size]:
        return "encoded again it is another one"
    widths = packet(code, data)
    if isinstance(widths, int):
        seen["packet", "refused", widths] += 1
        ours = ["refused", str(address), str(widths)]
        return None if theirs == ours else " ".join(ours)
    seen["packet", code] += 1
    if theirs[:3] != ["packet", str(address), str(code)]:
        return f"packet {address} {code}"
    numbers = split(data, widths)
    return None if same(theirs[3:], numbers, widths) else f"numbers {numbers}"


NUMBER = re.compile(r"[+-]?(0[xX][0-9a-fA-F]+|0[0-7]*|[1-9][0-9]*)\Z")


def number(text):
    """As C does with base 0; None if it is none, or beyond 32 bits."""
    if not NUMBER.match(text):
        return None
    digits = text.lstrip("+-")
    base = 16 if digits[:2].lower() == "0x" else 8 if digits[0] == "0" else 10
    value = int(digits, base)
    if value > 0xFFFFFFFF:
        return None
    return -value if text[0] == "-" else value


def judge_line(text, theirs, seen):
    text = text.replace("\n", "").rstrip("\r")
    match = re.match(r"[ \t]*([0-9]*)([^ \t=]*)[ \t=]*([^ \t]*)[ \t]*(.*)\Z", text)
    axis, name, argument, rest = match.groups()
    name = name.upper()
    known = not name or name in rzt1.IDS
    value = number(argument) if argument else None
    good = known and not rest and axis in ("", "1", "2") and (not argument or value is not None)
    seen["line", "good" if good else "refused"] += 1
    ours = "refused"
    if good:
        ours = f"line {axis or 0} {name or '-'} {'-' if value is None else value}"
    return None if " ".join(theirs) == ours else ours


def judge_reply(request, reply, theirs, seen):
    code, data = request[3], request[4:-1]
    if code == 0:
        widths = [1] * 4
    elif code == 1:
        mask = data[0]
        widths = [w for bit, w in enumerate(WIDTHS) if mask >> bit & 1]
    elif code == 6:
        widths = [rzt1.VARIABLES[data[0]]]
    else:
        widths = []
    if reply and reply[0] != 0:
        widths = []
    size = 2 + sum(widths)
    if len(reply) < size:
        seen["reply", "incomplete"] += 1
        return None if theirs == ["incomplete"] else "incomplete"
    if sum(reply[: size - 1]) & 0xFF != reply[size - 1]:
        seen["reply", "bad_sum"] += 1
        return None if theirs == ["bad_sum"] else "bad_sum"
    seen["reply", code, reply[0] == 0] += 1
    if theirs[:2] != ["reply", str(reply[0])]:
        return f"reply {reply[0]}"
    numbers = split(reply[1:-1], widths)
    return None if same(theirs[2:], numbers, widths) else f"numbers {numbers}"


def judge(line, seen):
    """None if we agree on the line, else what we say. Counts what was seen."""
    kind, digits, *theirs = line.split()
    frame = bytes.fromhex(digits)
    if kind == "packet":
        return judge_packet(frame, theirs, seen)
    if kind == "line":
        return judge_line(frame.decode(), theirs, seen)
    return judge_reply(frame, bytes.fromhex(theirs[0]), theirs[1:], seen)


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
    wanted = [("packet", code) for code in CODES]
    wanted += [("packet", "refused", status) for status in (BAD_CODE, BAD_INDEX, BAD_SIZE)]
    wanted += [(kind, v) for kind in ("packet", "reply") for v in ("incomplete", "bad_sum")]
    wanted += [("line", "good"), ("line", "refused"), ("reply", 6, True), ("reply", 1, False)]
    never = [what for what in wanted if not seen[what]]
    if never:
        print(f"never seen: {never}")
        return 1
    print(f"{total} frames agreed")
    return 0


if __name__ == "__main__":
    sys.exit(main(int(sys.argv[1])))
