"""Recordings of the wire: what other tools find in them, and that a replay says the same again."""

import json
import os
import pathlib
import signal
import struct
import sys
import unittest

import serial

sys.dont_write_bytecode = True

import pcapng
import toshiba_mcu as mcu
from program import DRIVE, SOURCE, ProgramTest
from toshiba_mcu import Host

MOTOR = 1
DONE, FAILED, UNUSABLE = 0, 1, 2
VERSION_REQUEST = bytes.fromhex("11 14 00 6c 13")
VERSION_ANSWER = bytes.fromhex("11 14 03 0a 0a 13")
CRC_ERROR = bytes.fromhex("11 ee 01 83 13")

# docs/recordings.md
LINKTYPE_USER0 = 147
FILE, HOST_SETTINGS, HOST_WRITE, END = 0x80766401, 0x80766402, 0x80766403, 0x80766404
BYTE_TIMES = 0x8001
CRC, TOO_SHORT, UNALIGNED, START = 1 << 8, 1 << 10, 1 << 12, 1 << 13  # of the error bits


def byte_times(packet):
    """Of each byte's last bit, in ns."""
    (value,) = packet.options[BYTE_TIMES]
    times, now, number, shift = [], packet.ticks, 0, 0
    for byte in value[8:]:
        number |= (byte & 0x7F) << shift
        shift += 7
        if byte < 0x80:
            now += number
            times.append(now)
            number = shift = 0
    assert len(times) == len(packet.data)
    assert times[-1] == struct.unpack("<Q", value[:8])[0]
    return times


def host_writes(file):
    """(time in ns, bytes), as the host's program wrote them."""
    for block in file.others:
        if block.type == HOST_WRITE:
            _, _, time, size = struct.unpack_from("<IIQI", block.body)
            yield time, block.body[20 : 20 + size]


def said(file, direction):
    return b"".join(p.data for p in file.packets if p.direction == direction)


class WireTest(ProgramTest):
    deadline_s = 120

    def record(self, name, talk, *arguments, end=signal.SIGTERM, baud=mcu.BAUD):
        """A recorded bench, a host's talk with it, and the recording."""
        bench = self.bench("--wire", self.path(name), *arguments)
        with Host(bench.link, baud) as host:
            talk(host)
        bench.stop(end)
        return pcapng.read(self.path(name))

    def replay(self, name, *arguments, code=DONE):
        result = self.run_program("replay", self.path(name), "--json", *arguments)
        self.assertEqual(result.returncode, code, result.stderr + result.stdout)
        return json.loads(result.stdout)

    def assert_replays(self, name):
        """The same bytes at the same instants, and the same file."""
        again = self.path("again-" + name)
        result = self.replay(name, "--wire", again)
        self.assertEqual((result["identical"], result["complete"]), (True, True))
        file = pcapng.read(self.path(name))
        self.assertEqual(result["host_bytes"], sum(len(data) for _, data in host_writes(file)))
        self.assertEqual(result["drive_bytes"], len(said(file, pcapng.OUTBOUND)))
        self.assertEqual(pathlib.Path(again).read_bytes(), pathlib.Path(self.path(name)).read_bytes())
        return result


def turn_a_motor(host):
    host.version()
    host.set(MOTOR, mcu.SPEED, 1500)
    host.start(MOTOR)
    for _ in range(100):
        host.state(MOTOR)
        host.get(MOTOR, mcu.MOTOR_STAGE)
    host.stop(MOTOR)


class Recording(WireTest):
    """What a reader written from the pcapng draft finds."""

    def test_each_frame_is_a_packet_with_times_and_direction(self):
        file = self.record("a.pcapng", turn_a_motor)
        self.assertFalse(file.truncated)
        self.assertEqual(file.application, "virtdrive")
        (line,) = file.interfaces
        self.assertEqual((line.link_type, line.description), (LINKTYPE_USER0, DRIVE))
        self.assertEqual((line.speed, line.ticks_per_second), (115200, 10**9))

        requests = [p for p in file.packets if p.direction == pcapng.INBOUND]
        answers = [p for p in file.packets if p.direction == pcapng.OUTBOUND]
        self.assertEqual((len(requests), len(answers)), (204, 204))
        self.assertEqual(requests[0].data, VERSION_REQUEST)
        self.assertEqual(answers[0].data, VERSION_ANSWER)
        self.assertTrue(answers[0].comment.startswith("GetFWVersion major=3 minor=10 ("))
        for packet in file.packets:
            command, payload = packet.data[1], packet.data[2:-2]
            self.assertEqual(packet.data, mcu.telegram(command, payload))
            self.assertEqual(packet.errors, 0)

        # 115200 8N1: ten bits a byte, without gaps; an answer starts 1 ms after its request.
        for packet in file.packets:
            length_ns = byte_times(packet)[-1] - packet.ticks
            self.assertAlmostEqual(length_ns, len(packet.data) * 10e9 / 115200, delta=len(packet.data))
        for request, answer in zip(requests, answers):
            self.assertAlmostEqual(answer.ticks - byte_times(request)[-1], 1e6, delta=2)

    def test_what_is_no_frame_is_in_packets_of_its_own_with_errors(self):
        def talk(host):
            host.send(b"garbage")
            self.assertEqual(host.exchange(bytes.fromhex("11 00 01 06 13"), 5), CRC_ERROR)
            self.assertEqual(host.exchange(VERSION_REQUEST, 6), VERSION_ANSWER)
            host.send(b"\x11\x14\x00")
            host.listen(0.05)

        file = self.record("a.pcapng", talk)
        found = [(p.direction, p.data, p.errors) for p in file.packets]
        self.assertEqual(
            found,
            [
                (pcapng.INBOUND, b"garbage", START),
                (pcapng.INBOUND, bytes.fromhex("11 00 01 06 13"), CRC),
                (pcapng.OUTBOUND, CRC_ERROR, 0),
                (pcapng.INBOUND, VERSION_REQUEST, 0),
                (pcapng.OUTBOUND, VERSION_ANSWER, 0),
                (pcapng.INBOUND, b"\x11\x14\x00", TOO_SHORT),
            ],
        )
        self.assertEqual(b"".join(data for _, data in host_writes(file)), said(file, pcapng.INBOUND))

    def test_it_tells_what_bench_it_is_of(self):
        file = self.record(
            "a.pcapng", Host.version, "--seed", 7, "--load", "brake:5mNm", "--set", "PolePairs=4",
            "--motor", "db42s01", "--baud", 57600, baud=57600,
        )
        bench = json.loads(file.comment)
        self.assertEqual((bench["virtdrive"], bench["seed"]), (1, 7))
        (line,) = bench["lines"]
        self.assertEqual((line["name"], line["timing"], line["baud"]), ("line", "real", 57600))
        (drive,) = bench["drives"]
        self.assertEqual((drive["kind"], drive["motors"]), (DRIVE, ["db42s01"]))
        self.assertEqual((drive["load"], drive["set"]), ("brake:5mNm", ["PolePairs=4"]))
        self.assertNotIn(str(self.folder), file.comment)

    def test_equal_runs_give_equal_files(self):
        for name in ("a.pcapng", "b.pcapng"):
            self.run_program(
                "run", DRIVE, "--rate", "max", "--duration", "0.5", "--start", "2000", "--wire", name
            )
        first, second = (self.folder / name for name in ("a.pcapng", "b.pcapng"))
        self.assertGreater(first.stat().st_size, 0)
        self.assertEqual(first.read_bytes(), second.read_bytes())

    def test_a_kill_leaves_whole_blocks_up_to_the_last_frame(self):
        bench = self.bench("--wire", self.path("a.pcapng"))
        with Host(bench.link) as host:
            for _ in range(20):
                host.version()
            bench.kill()
        file = pcapng.read(self.path("a.pcapng"))
        self.assertEqual(len([p for p in file.packets if p.data == VERSION_ANSWER]), 20)
        self.assertNotIn(END, [block.type for block in file.others])
        result = self.run_program("replay", self.path("a.pcapng"))
        self.assertEqual(result.returncode, DONE, result.stderr)
        self.assertIn("identical: 100 host bytes, 120 drive bytes", result.stdout)
        self.assertIn("has no end: the program was killed", result.stderr)

    def test_a_file_that_cannot_be_written_is_reported(self):
        run = ["run", DRIVE, "--rate", "max", "--duration", "0.1", "--start", "2000", "--wire"]
        for path, reason in (("/nonexistent/a.pcapng", "cannot be written"),
                             ("/dev/full", "not all of it could be written")):
            with self.subTest(path):
                result = self.run_program(*run, path)
                self.assertEqual(result.returncode, UNUSABLE)
                self.assertIn(f"--wire {path}: {reason}", result.stderr)


class Replay(WireTest):
    """A recorded host, played again without a terminal, hears the same."""

    def test_a_session_with_a_turning_motor(self):
        for end in (signal.SIGTERM, signal.SIGINT):
            with self.subTest(end.name):
                self.record("a.pcapng", turn_a_motor, end=end)
                self.assert_replays("a.pcapng")

    def test_signals_recorded_beside_change_nothing(self):
        # To look at the plant is to bring it to the present: the replay must look as often.
        self.record(
            "a.pcapng", turn_a_motor, "--record", self.path("a.csv"), "--interval", "0.000333",
            "--signals", "motor1.speed,motor1.current_a",
        )
        self.assert_replays("a.pcapng")
        signals = ["--signals", self.path("a.csv")]
        self.assertGreater(self.replay("a.pcapng", *signals)["rows"], 100)
        other = self.replay("a.pcapng", *signals, "--load", "brake:1mNm", code=FAILED)
        self.assertTrue(other["signal_divergence"]["signal"].startswith("motor1."))

    def test_an_ideal_line_a_load_settings_and_the_fast_integrator(self):
        self.record(
            "a.pcapng", turn_a_motor, "--line", "ideal", "--load", "brake:10mNm@0.1s", "--seed", 9,
            "--set", "MaxAngAcc=800", "--integrator", "fast", "--lenient", "--start", "0:800",
        )
        self.assert_replays("a.pcapng")

    def test_hosts_that_change_the_baud_rate_talk_garbage_and_stop_in_the_middle(self):
        def talk(host):
            host.version()
            host.port.baudrate = 9600
            host.send(VERSION_REQUEST * 3)
            host.listen(0.1)
            host.port.baudrate = 115200
            host.send(bytes(range(256)))
            host.listen(0.1)
            host.port.stopbits = serial.STOPBITS_TWO
            # A frame in two halves, then one cut short that swallows the next.
            host.send(VERSION_REQUEST[:2])
            host.listen(0.15)
            host.send(VERSION_REQUEST[2:])
            host.listen(0.1)
            host.send(b"\x11\x0a\x01")
            host.listen(0.05)
            for _ in range(4):
                host.send(VERSION_REQUEST)
                host.listen(0.02)
            host.port.baudrate = 57600
            host.send(VERSION_REQUEST)
            host.port.baudrate = 115200  # while the answer is on its way
            host.listen(0.1)

        file = self.record("a.pcapng", talk)
        self.assertGreater(len([p for p in file.packets if p.errors]), 2)
        self.assertIn(HOST_SETTINGS, [block.type for block in file.others])
        self.assert_replays("a.pcapng")

    def test_a_host_that_writes_in_the_middle_of_an_answer(self):
        def talk(host):
            for i in range(30):
                host.send(mcu.telegram(mcu.GET_MOTOR_STATE, [MOTOR]))
                host.port.timeout = 0.02
                host.port.read(1 + i % 5)
                host.send(VERSION_REQUEST[i % 2 :])
                host.listen(0.01)
            host.send(VERSION_REQUEST * 60)

        self.record("a.pcapng", talk)
        self.assert_replays("a.pcapng")

    def test_hosts_that_come_and_go(self):
        bench = self.bench("--wire", self.path("a.pcapng"))
        for parity in ("N", "E", "O"):
            with Host(bench.link, parity=parity) as host:
                host.version()
                host.send(VERSION_REQUEST)
        bench.stop()
        self.assert_replays("a.pcapng")

    def test_what_was_stored_before_is_part_of_the_recording(self):
        memory = self.path("drive.nvm")
        with Host(self.bench("--nvm", memory, link="first").link) as host:
            host.set(MOTOR, mcu.MAX_ANG_ACC, 777)
            host.store(MOTOR)

        def talk(host):
            self.assertEqual(host.get(MOTOR, mcu.MAX_ANG_ACC).value, 777)
            host.set(MOTOR, mcu.MAX_ANG_ACC, 555)
            host.store(MOTOR)

        file = self.record("a.pcapng", talk, "--nvm", memory)
        self.assertIn(FILE, [block.type for block in file.others])
        stored = pathlib.Path(memory).read_bytes()
        os.remove(memory)
        result = self.replay("a.pcapng")
        self.assertTrue(result["identical"])
        self.assertFalse(os.path.exists(memory), "a replay touches no file of the run")
        self.assertIn(b"virtdrive-nvm", stored)

    def test_a_motor_of_ones_own_is_part_of_the_recording(self):
        motor = pathlib.Path(self.path("mine.yaml"))
        library = SOURCE / "data/motors/db42s01.yaml"
        motor.write_text(library.read_text().replace("name: db42s01", "name: mine"))
        file = self.record("a.pcapng", turn_a_motor, "--motor", motor)
        self.assertEqual(json.loads(file.comment)["drives"][0]["motors"], ["mine.yaml"])
        motor.unlink()
        self.assert_replays("a.pcapng")

    def test_over_a_network_with_parity(self):
        name = self.path("a.pcapng")
        bench = self.bench("--wire", name, "--rfc2217", "0", link=None)
        port = serial.serial_for_url(bench.ready["port"], 115200, timeout=5)
        self.addCleanup(port.close)
        port.write(VERSION_REQUEST)
        self.assertEqual(port.read(6), VERSION_ANSWER)
        port.parity = serial.PARITY_EVEN
        port.write(VERSION_REQUEST)
        port.timeout = 0.1
        port.read(6)
        port.close()
        bench.stop()
        self.assert_replays("a.pcapng")


class Divergence(WireTest):
    """What is not the same is named: which byte, when, in which frame."""

    def test_another_bench_diverges_at_the_first_byte_that_differs(self):
        def talk(host):
            host.version()
            host.get(MOTOR, mcu.MAX_ANG_ACC)
            host.version()

        file = self.record("a.pcapng", talk)
        result = self.replay("a.pcapng", "--set", "MaxAngAcc=777", code=FAILED)
        self.assertFalse(result["identical"])
        divergence = result["divergence"]
        answer = file.packets[3]
        # 300 is 2c 01, 777 is 09 03; the value begins behind start byte and command.
        self.assertEqual((divergence["line"], divergence["drive_byte"]), ("line", 6 + 2))
        self.assertEqual((divergence["recorded"]["byte"], divergence["replayed"]["byte"]), (0x2C, 0x09))
        self.assertEqual(divergence["recorded"]["packet"], answer.data.hex(" "))
        self.assertEqual(divergence["recorded"]["time_ns"], byte_times(answer)[2])
        self.assertEqual(divergence["replayed"]["time_ns"], byte_times(answer)[2])
        text = self.run_program("replay", self.path("a.pcapng"), "--set", "MaxAngAcc=777")
        self.assertEqual(text.returncode, FAILED)
        self.assertRegex(text.stdout, r"^diverged: drive byte 8 on line, after 8 that are the same\n")
        self.assertIn("value=777", text.stdout)

    def test_a_byte_changed_in_the_file_is_found(self):
        self.record("a.pcapng", turn_a_motor)
        data = bytearray(pathlib.Path(self.path("a.pcapng")).read_bytes())
        at = data.find(VERSION_ANSWER)
        data[at + 3] ^= 1
        pathlib.Path(self.path("b.pcapng")).write_bytes(data)
        divergence = self.replay("b.pcapng", code=FAILED)["divergence"]
        self.assertEqual(divergence["drive_byte"], 3)
        self.assertEqual((divergence["recorded"]["byte"], divergence["replayed"]["byte"]), (0x0B, 0x0A))

    def test_an_answer_that_comes_later_is_a_divergence_too(self):
        def talk(host):
            host.version()
            host.listen(0.05)
            host.version()

        file = self.record("a.pcapng", talk, "--line", "ideal")
        data = pathlib.Path(self.path("a.pcapng")).read_bytes()
        real = data.replace(b'"timing":"ideal"', b'"timing":"real" ')
        pathlib.Path(self.path("b.pcapng")).write_bytes(real)
        divergence = self.replay("b.pcapng", code=FAILED)["divergence"]
        self.assertEqual(divergence["drive_byte"], 0)
        self.assertEqual(divergence["recorded"]["byte"], divergence["replayed"]["byte"])
        self.assertEqual(divergence["recorded"]["time_ns"], file.packets[1].ticks)
        late = divergence["replayed"]["time_ns"] - divergence["recorded"]["time_ns"]
        self.assertAlmostEqual(late, 6 * 10e9 / 115200 + 1e6, delta=10)


class Damaged(WireTest):
    """Files that are no whole recording: one line that says where, or what is there."""

    def assert_unusable(self, data, *words):
        pathlib.Path(self.path("bad.pcapng")).write_bytes(data)
        result = self.run_program("replay", self.path("bad.pcapng"))
        self.assertEqual((result.returncode, result.stdout), (UNUSABLE, ""))
        self.assertEqual(result.stderr.count("\n"), 1, result.stderr)
        for word in words:
            self.assertIn(word, result.stderr)

    def test_what_is_no_recording_is_refused(self):
        self.assert_unusable(b"", "bad.pcapng: is no pcapng file")
        self.assert_unusable(b"time_s,motor1.speed[rpm]\n0.0,0\n", "is no pcapng file")
        header = struct.pack("<IIIHHqI", pcapng.SECTION_HEADER, 28, pcapng.BYTE_ORDER_MAGIC, 1, 0, -1, 28)
        self.assert_unusable(header, "does not say what bench it is of")
        self.assert_unusable(header[:8] + header[8:12][::-1] + header[12:], "byte order")
        result = self.run_program("replay", self.path("nowhere.pcapng"))
        self.assertEqual(result.returncode, UNUSABLE)
        self.assertIn("nowhere.pcapng: cannot be read: No such file", result.stderr)
        result = self.run_program("replay", self.folder)
        self.assertIn("is a folder", result.stderr)

    def test_damage_is_named_with_its_offset(self):
        file = self.record("a.pcapng", Host.version)
        data = pathlib.Path(self.path("a.pcapng")).read_bytes()
        section = struct.unpack_from("<I", data, 4)[0]
        lengths = bytearray(data)
        lengths[section + 4] ^= 1
        self.assert_unusable(bytes(lengths), f"damaged at offset {section}: a block of")
        for old, new, words in (
            (b'{"virtdrive":1,', b'{"virtdrive":2,', ("'virtdrive' is no number 1 ... 1",)),
            (b'"timing":"real"', b'"timing":"rael"', ("neither real nor ideal",)),
            (b'"kind":"toshiba-mcu"', b'"kind":"toshiba-mco"', ("did you mean toshiba-mcu",)),
            (b'"lenient"', b'"lenieft"', ("lacks 'lenient'",)),
            (b'"baud":115200', b'"baud":49', ("'baud' is no number 50 ... 12000000",)),
        ):
            with self.subTest(old):
                self.assertEqual(data.count(old), 1)
                self.assert_unusable(data.replace(old, new.ljust(len(old))), *words)
        self.assertEqual(len(file.packets), 2)

    def test_a_file_cut_anywhere_is_refused_or_replayed_up_to_there(self):
        self.record("a.pcapng", Host.version)
        data = pathlib.Path(self.path("a.pcapng")).read_bytes()
        for size in range(0, len(data), 37):
            pathlib.Path(self.path("cut.pcapng")).write_bytes(data[:size])
            result = self.run_program("replay", self.path("cut.pcapng"))
            self.assertIn(result.returncode, (DONE, UNUSABLE), f"{size}: {result.stdout}")
            self.assertEqual(result.stderr.count("\n"), 1, result.stderr)


if __name__ == "__main__":
    unittest.main()
