"""A host of the RZ/T1 solution kit's two protocols, written from R11AN0086JJ0102, Rev.1.02, 2019-07-31:
lines (8.1), packets (8.2, Appendix B), names and sizes (Appendix A)."""

import struct
import time

import serial

BAUD = 115200
# Appendix A: every name in the order of its number, with its size in bytes; without one it is a Cmd.
# ACC has no size there; it is one of the 16.16 numbers, all of which have 4.
APPENDIX_A = """
    STA:4 ERR:2 ADC1:2 ADC2:2 TC:2 CV:2 PVT:2 ITIME:2 VEL:4 ACC:4 DEC:4 AJERK:4 DJERK:4 PRO:2
    KP:2 KI:2 KD:2 IL:2 VFF:2 AFF:2 MAX:2 ETIME:2 DS:2 MLIMIT:2 BIAS:4 ASTOP:2 PIMODE:2 PITIME:2
    PIOUT:2 PMAP:2 PORIGIN:4 PCMODE:2 PVECTOR:4 PPAIRS:2 PCOUNTS:4 ECPR:4 PIOFFS:4 PANGLE:4
    PADV:4 VCOMP:4 CLIMIT:2 CTIME:2 IDM:4 IQM:4 IQERR:4 QKP:2 QKI:2 PCT:2 HMASK:2 INVERT:2
    HINVERT:4 HSHIFT:4 HPOS:4 EMASK:2 ECP:4 ECV:4 EPO:4 U:4 V:4 W:4 TYPE:2 HTYPE:2 HOFFS:4
    DATA0:4 DATA1:4 DATA2:4 DATA3:4 DATA4:4 DATA5:4 DATA6:4 DATA7:4 PHASES:2 BRAKE:2 TMODE:2
    TRATE:2 TLEVEL:4 SIM:2 TIMER:2 ADDP:4 ADDV:4 ABS:4 REL:4 POS:4 INP:2 IND:4 GO FWD REV RESET
    ON OFF ENABLE DISABLE STOP ABORT HOME ALIGN VER:4 OUT1:2 OUT2:2 PWM:2 IQPKT:2 IDPKT:2 CH1:2
    CH2:2 CH3:2 CH4:2 TRACE:2 PLAY:2 PLIMIT:2 PTIME:2 GEARIN:2 GEAROUT:2 SETUP:2 PINVERT:2 SAVE
    RESTORE ETYPE:2 EID:4 EADDR:2 EDATA:2 EBAUDRATE:2 ESTATUS:2 ADDR:2 GROUP:2 TBSIZE:2 WMARK:2
    QKD:2 VKP:2 VKI:2 VKD:2 ELVOLT:4 EHVOLT:4 EWPOSMIN:4 EWPOSMAX:4 EOVS:4 EWOVS:4 EEMP:4
    EOVTEMP:4 ERRMASK:4 EVOLT:4 EQUERY:4 ERESET EOVC:4 ETEMP:4
""".split()
NAMES = [entry.split(":")[0] for entry in APPENDIX_A]
IDS = {name: number for number, name in enumerate(NAMES)}
SIZES = {IDS[e.split(":")[0]]: int(e.split(":")[1]) for e in APPENDIX_A if ":" in e}
# Typed R/W there, but they start something and have no value.
STARTERS = {IDS["PLAY"], IDS["SETUP"]}
COMMANDS = {number for number in range(len(NAMES)) if number not in SIZES} | STARTERS
VARIABLES = {number: size for number, size in SIZES.items() if number not in STARTERS}

MODULE_DATA, REPORT, CALL, INIT_PVT, STREAM_PVT, SET, GET, TRACE, BAUD_RATE = 0, 1, 2, 3, 4, 5, 6, 7, 15
BAUD_CODES = {115200: 0, 230400: 1, 250000: 2, 460800: 3, 500000: 4, 921600: 5, 1000000: 6}
REPORT_FIELDS = "iHhHBBBB"  # by the mask's bits (B.2)
COMPLETE, SERVO_ON, PVT_LOW, PHASED, BUSY, STARVED = 1, 2, 0x40, 0x80, 0x100, 0x800


def packet(address, code, data=b""):
    """AA, then what is summed, then the sum (8.2.3; the length is that of the data, as all drawings of
    Appendix B have it)."""
    body = bytes([address, len(data), code]) + bytes(data)
    return b"\xaa" + body + bytes([sum(body) & 0xFF])


class Refused(Exception):
    def __init__(self, status):
        super().__init__(f"status {status}")
        self.status = status


class Host:
    def __init__(self, path, baud=BAUD, timeout=2):
        self.port = serial.Serial(path, baud, timeout=timeout)

    def close(self):
        self.port.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def read(self, size):
        got = self.port.read(size)
        if len(got) != size:
            raise TimeoutError(f"{len(got)} of {size} bytes: {got.hex()}")
        return got

    # --- Packets ---

    def send(self, address, code, data=b"", reply=0):
        """The data of the reply, which has so many bytes of them; Refused for a status."""
        self.port.write(packet(address, code, data))
        status = self.read(1)
        rest = self.read(reply + 1 if status == b"\x00" else 1)
        if (sum(status + rest[:-1]) & 0xFF) != rest[-1]:
            raise ValueError(f"wrong sum: {(status + rest).hex()}")
        if status != b"\x00":
            raise Refused(status[0])
        return rest[:-1]

    def get(self, name, address=1):
        number = IDS[name]
        data = self.send(address, GET, bytes([number]), SIZES[number])
        return int.from_bytes(data, "little", signed=True)

    def set(self, name, value, address=1):
        number = IDS[name]
        size = SIZES[number]
        data = (value & ((1 << 8 * size) - 1)).to_bytes(size, "little")
        self.send(address, SET, bytes([number]) + data)

    def call(self, name, address=1):
        self.send(address, CALL, bytes([IDS[name]]))

    def report(self, mask, address=1):
        quoted = "<" + "".join(f for bit, f in enumerate(REPORT_FIELDS) if mask >> bit & 1)
        data = self.send(address, REPORT, struct.pack("<H", mask), struct.calcsize(quoted))
        return struct.unpack(quoted, data)

    def stream(self, points, address=1):
        data = b"".join(struct.pack("<ii", *point) for point in points)
        self.send(address, STREAM_PVT, bytes([len(points)]) + data)

    def change_baud(self, baud):
        self.send(1, BAUD_RATE, bytes([BAUD_CODES[baud]]))
        time.sleep(0.01)
        self.port.baudrate = baud

    def switch_on(self, address=1):
        """Servo on and phased."""
        self.call("ON", address)
        while self.report(2, address)[0] & (PHASED | BUSY) != PHASED:
            time.sleep(0.01)

    # --- Lines ---

    def line(self, text):
        """What comes back, up to and with the prompt."""
        self.port.write(text.encode() + b"\r")
        said = b""
        while not said.endswith((b"\r\n>", b"\r\n?")):
            said += self.read(1)
        return said.decode()
