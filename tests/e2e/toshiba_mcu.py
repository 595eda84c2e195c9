"""A host for Toshiba's MCU Motor Studio serial protocol, firmware 3.10.

Written from the maker's document alone ("Serial Communication - Protocol Specification", Rev 1.1.0,
2022-10-21), as a second opinion: it shares no table and no line with the program under test. Sizes,
ids and units stand here as the document prints them; section numbers are its own.
"""

import enum
import struct
from typing import NamedTuple

import serial

BAUD = 115200  # table 2-2, 8N1
BOT, EOT = 0x11, 0x13  # table 3-1
ERROR = 0xEE  # section 3
ALL_MOTORS = 0xFF  # 5.1: MotorID -1

# Section 4.1, with the command bytes of the frames in 4.2.
START_MOTOR = 0x00
STOP_MOTOR = 0x01
GET_MOTOR_STATE = 0x02
STORE_PARAMETERS = 0x03
CLEAR_PARAMETERS = 0x04
CONFIG_DSO_LOG = 0x05
GET_DSO_LOG_DATA = 0x06
CONFIGURE_HS_DSO = 0x07
DO_TURN = 0x08
GET_ONE = 0x09
SET_ONE = 0x0A
GET_MANY = 0x0B
SET_MANY = 0x0C
DO_LINEAR_MOTION = 0x0D
GET_ABSOLUTE_POSITION = 0x0E
ABORT_LINEAR_MOTION = 0x0F
START_TORQUE = 0x10
GET_CONTROL_METHOD = 0x11
SET_CONTROL_METHOD = 0x12
GET_ENCODER_COUNTER = 0x13  # 4.2.20; table 4-1 says 0x12
GET_VERSION = 0x14
SET_DEMO_STATE = 0x21
GET_DEMO_STATE = 0x22
GET_EXTENDED_STATE = 0x23

# Payload of the answer to each, in bytes.
REPLY_SIZE = {
    START_MOTOR: 1,
    STOP_MOTOR: 1,
    GET_MOTOR_STATE: 20,
    STORE_PARAMETERS: 1,
    CLEAR_PARAMETERS: 1,
    CONFIG_DSO_LOG: 2,
    GET_DSO_LOG_DATA: 32,
    CONFIGURE_HS_DSO: 1,
    DO_TURN: 1,
    GET_ONE: 5,
    SET_ONE: 1,
    GET_MANY: 42,
    SET_MANY: 2,
    DO_LINEAR_MOTION: 1,
    GET_ABSOLUTE_POSITION: 4,
    ABORT_LINEAR_MOTION: 1,
    START_TORQUE: 1,
    GET_CONTROL_METHOD: 1,
    SET_CONTROL_METHOD: 1,
    GET_ENCODER_COUNTER: 4,
    GET_VERSION: 2,
    SET_DEMO_STATE: 1,
    GET_DEMO_STATE: 1,
    GET_EXTENDED_STATE: 21,
    ERROR: 1,
}
SLOTS = 8  # 4.2.12: "At the moment the count is set to 8"

# Parameters (5.1).
POLE_PAIRS = 0x10
DIRECTION = 0x11
MAX_ANG_ACC = 0x12
IQ_START = 0x19
ENCODER = 0x30
ENCODER_START_POS = 0x34
SHUTDOWN_MODE = 0x51
BRAKETIME = 0x52
RESTART_MODE = 0x54
SW_UNDERVOLTAGE = 0x5A
BOOTSTRAP_DELAY = 0x71
ERROR_STATE = 0xE1
MOTOR_STAGE = 0xE3
TURN_NUMBER = 0xE4
SPEED = 0xE5
TORQUE = 0xE6

# Units of MaxAngAcc (5.1.3) and of currents (5.1.10).
RAD_BY_S2, HZ_BY_S, RPM_BY_S, RPM_BY_MIN = range(4)
MAMPERE = -3

# ShutdownMode (5.1.32).
DISABLE_OUTPUT, SHORT_BRAKE, GENTLE = range(3)

# Encoder (5.1.15).
ENCODER_INCENC_ABZ = 3

# Bits of selected_values (4.2.6); TriggerMode as in the maker's published firmware.
DSO = {name: 1 << bit for bit, name in enumerate(
    "Va Vb Vc Valpha Vbeta Id Id_Ref Iq Iq_Ref Vd Vq Vdi Vqi Theta Omega Omega_Calc SIN_Theta "
    "COS_Theta Sector VDC Ia Ib Ic Ialpha Ibeta VE_Stage User1 User2 User3 User4 User5 User6".split()
)}
RISING, CENTRED = 1, 2
DSO_NOT_READY, DSO_EMPTY = -2, -1  # 4.2.7

# Bits of ErrorState (5.1.66).
SW_UNDERVOLTAGE_ERROR = 1 << 4
WRONG_DIRECTION_ERROR = 1 << 7
STALL_ERROR = 1 << 9


class Stage(enum.IntEnum):  # 5.1.68
    STOP = 0
    BOOTSTRAP = 1
    BRAKE = 2
    ZERO_CURRENT_MEASURE = 3
    INITPOSITION = 4
    FORCE = 5
    FOC = 6
    EMERGENCY = 7


class MotorState(NamedTuple):  # 4.2.3
    actual_rpm: int
    target_rpm: int
    current_ma: int
    torque: int
    tick: int


class ExtendedMotorState(NamedTuple):  # 4.2.24
    actual: int
    target: int
    current_ma: int
    non_control: int
    tick: int
    method: int


class Value(NamedTuple):
    value: int
    unit: int


class NoAnswer(Exception):
    """The drive did not answer in time, or not with a whole telegram."""


class BadAnswer(Exception):
    """Something came that is no telegram, or not the one asked for."""


class ErrorAnswer(Exception):
    """The drive answered with the error telegram; `code` is signed."""

    def __init__(self, code):
        super().__init__(f"error telegram, code {code}")
        self.code = code


def crc8(command, payload):
    """Section 6: polynomial 0x07, no reflection; the command is the start value."""
    crc = command
    for byte in payload:
        crc ^= byte
        for _ in range(8):
            crc = (crc << 1) ^ 0x07 if crc & 0x80 else crc << 1
            crc &= 0xFF
    return crc


def telegram(command, payload):
    return bytes([BOT, command, *payload, crc8(command, payload), EOT])


class Host:
    """The host program's end of a port. An answer that must come has `patience_s` to do so."""

    def __init__(self, path, baud=BAUD, parity="N", patience_s=10.0):
        self.port = serial.Serial(path, baud, parity=parity, timeout=patience_s)
        self.patience_s = patience_s

    def close(self):
        self.port.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    # --- Bytes ---

    def send(self, data):
        self.port.write(data)

    def read(self, count):
        """Exactly so many bytes."""
        data = self.port.read(count)
        if len(data) < count:
            raise NoAnswer(f"{len(data)} of {count} bytes: {data.hex(' ')}")
        return data

    def listen(self, seconds, last=None):
        """Whatever comes within a time, or until it ends with `last`; b"" if nothing does."""
        self.port.timeout = seconds
        try:
            return self.port.read_until(last) if last else self.port.read(4096)
        finally:
            self.port.timeout = self.patience_s

    def exchange(self, request, size):
        """Sends bytes as they are and reads so many back."""
        self.send(request)
        return self.read(size)

    # --- Telegrams ---

    def answer(self, command):
        """The payload of the answer to `command`, which was sent."""
        head = self.read(2)
        if head[0] != BOT or head[1] not in (command, ERROR):
            raise BadAnswer(f"answer to {command:02x} begins with {head.hex(' ')}")
        body = self.read(REPLY_SIZE[head[1]] + 2)
        payload, crc, eot = body[:-2], body[-2], body[-1]
        if crc != crc8(head[1], payload) or eot != EOT:
            raise BadAnswer(f"no telegram: {(head + body).hex(' ')}")
        if head[1] == ERROR:
            raise ErrorAnswer(struct.unpack("<b", payload)[0])
        return payload

    def request(self, command, payload):
        self.send(telegram(command, payload))
        return self.answer(command)

    # --- Commands (4.2) ---

    def version(self):
        return tuple(self.request(GET_VERSION, [0]))

    def start(self, motor):
        self.request(START_MOTOR, [motor])

    def stop(self, motor):
        self.request(STOP_MOTOR, [motor])

    def start_torque(self, motor):
        self.request(START_TORQUE, [motor])

    def store(self, motor):
        self.request(STORE_PARAMETERS, [motor])

    def clear(self):
        self.request(CLEAR_PARAMETERS, [0])

    # --- Oscilloscope (4.2.6, 4.2.7, 4.2.8) ---

    def arm(self, motor, selected, trigger_on=0, mode=0, level=0, spread=0):
        """The number of blocks that will have to be fetched."""
        payload = struct.pack("<BIIBHB", motor, selected, trigger_on, mode, level & 0xFFFF, spread)
        return struct.unpack("<H", self.request(CONFIG_DSO_LOG, payload))[0]

    def dso_block(self):
        return struct.unpack("<16h", self.request(GET_DSO_LOG_DATA, [0]))

    def configure_stream(self, motor, enable, selected, spread=0):
        self.request(CONFIGURE_HS_DSO, struct.pack("<BBIB", motor, enable, selected, spread))

    # --- Motion (4.2.9, 4.2.14 to 4.2.16, 4.2.20) ---

    def do_turn(self, motor, turns, max_rpm):
        self.request(DO_TURN, struct.pack("<BhH", motor, turns, max_rpm))

    def do_linear_motion(self, motor, position, max_rpm):
        """The error byte: 0 if the drive goes there."""
        return self.request(DO_LINEAR_MOTION, struct.pack("<BIH", motor, position, max_rpm))[0]

    def absolute_position(self, motor):
        return struct.unpack("<I", self.request(GET_ABSOLUTE_POSITION, [motor]))[0]

    def abort_linear_motion(self, motor):
        return self.request(ABORT_LINEAR_MOTION, [motor])[0]

    def encoder_counter(self, encoder):
        return struct.unpack("<i", self.request(GET_ENCODER_COUNTER, [encoder]))[0]

    # --- Demo (4.2.22, 4.2.23) ---

    def set_demo_state(self, state):
        return self.request(SET_DEMO_STATE, [state])[0]

    def demo_state(self):
        return self.request(GET_DEMO_STATE, [0xAB])[0]

    def set_control_method(self, motor, method):
        """The error byte: 0 or 1."""
        return self.request(SET_CONTROL_METHOD, [motor, method])[0]

    def state(self, motor):
        return MotorState(*struct.unpack("<iiIII", self.request(GET_MOTOR_STATE, [motor])))

    def extended_state(self, motor):
        payload = self.request(GET_EXTENDED_STATE, [motor])
        return ExtendedMotorState(*struct.unpack("<iiIIIB", payload))

    def control_method(self, motor):
        return self.request(GET_CONTROL_METHOD, [motor])[0]

    def get(self, motor, parameter, offset=0):
        return Value(*struct.unpack("<ib", self.request(GET_ONE, [motor, parameter, offset])))

    def set(self, motor, parameter, value, unit=0):
        self.request(SET_ONE, struct.pack("<BBbi", motor, parameter, unit, value))

    def get_many(self, motor, parameters):
        """error, offset, and a Value for each of the eight slots."""
        entries = [byte for parameter in parameters for byte in (parameter, 0)]
        payload = bytes([motor, len(parameters), *entries]).ljust(2 + 2 * SLOTS, b"\0")
        reply = self.request(GET_MANY, payload)
        return reply[0], reply[1], [Value(*slot) for slot in struct.iter_unpack("<ib", reply[2:])]

    def set_many(self, motor, entries):
        """`entries` of (parameter, value, unit); error and offset."""
        body = b"".join(struct.pack("<Bbi", *(p, unit, value)) for p, value, unit in entries)
        reply = self.request(
            SET_MANY, (bytes([motor, len(entries)]) + body).ljust(2 + 6 * SLOTS, b"\0")
        )
        return reply[0], reply[1]

    def stage(self, motor):
        return Stage(self.get(motor, MOTOR_STAGE).value)

    def errors(self, motor):
        return self.get(motor, ERROR_STATE).value
