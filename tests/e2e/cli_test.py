"""The program as a person or a script runs it: options, files, signals, other people's tools."""

import json
import os
import pathlib
import pty
import select
import signal
import socket
import subprocess
import sys
import tty
import unittest

import serial

sys.dont_write_bytecode = True

from program import DRIVE, PROGRAM, ProgramTest
from toshiba_mcu import Host

VERSION_REQUEST = bytes.fromhex("11 14 00 6c 13")
VERSION_ANSWER = bytes.fromhex("11 14 03 0a 0a 13")

DONE, FAILED, UNUSABLE = 0, 1, 2
UNWRITABLE = "/sys/virtdrive"  # not even root can make a file there


class CliTest(ProgramTest):
    def assert_unusable(self, arguments, *words):
        """One line on standard error with all of these words, exit code 2, and no trace left."""
        before = self.snapshot()
        result = self.run_program(*arguments)
        self.assertEqual((result.returncode, result.stdout), (UNUSABLE, ""), result.stderr)
        self.assertEqual(result.stderr.count("\n"), 1, result.stderr)
        self.assertTrue(result.stderr.startswith("virtdrive: "), result.stderr)
        for word in words:
            self.assertIn(word, result.stderr)
        self.assertEqual(self.snapshot(), before)

    def assert_all_unusable(self, cases):
        for arguments, *words in cases:
            with self.subTest(" ".join(arguments)):
                self.assert_unusable(arguments, *words)

    def snapshot(self):
        """Everything in the test's folder: where links point, and what is in files."""

        def content(path):
            if path.is_symlink():
                return os.readlink(path)
            return path.read_bytes() if path.is_file() else None

        return {str(path): content(path) for path in self.folder.rglob("*")}


def run(*arguments):
    # If it is not refused after all, it ends by itself.
    return ["run", DRIVE, "--rate", "max", "--duration", "0.01", *arguments]


class Unusable(CliTest):
    """What cannot be used is refused: one line that says what, what is expected, and the remedy."""

    def test_unknown_names_are_refused_with_the_nearest_ones(self):
        recording = ["--record", "x.csv"]
        self.assert_all_unusable(
            [
                (["run", "toshiba-mco"], "'toshiba-mco'", "did you mean toshiba-mcu?"),
                (["run", "nonsense"], "'nonsense'", "virtdrive list drives"),
                (["list", "signals", "toshiba"], "'toshiba'", "toshiba-mcu"),
                (["list", "parameters", "toshiba"], "'toshiba'", "toshiba-mcu"),
                (["document", "toshiba"], "'toshiba'", "toshiba-mcu"),
                (run("--motor", "db42s3"), "motor 'db42s3'", "did you mean db42s03"),
                (run(*recording, "--signals", "motor1.spede"), "signal 'motor1.spede'",
                 "did you mean motor1.speed"),
                (run(*recording, "--signals", "motor1.speed,motor9.speed"), "'motor9.speed'"),
                (run("--set", "MaxAngAc=300"), "parameter 'MaxAngAc'", "did you mean MaxAngAcc?"),
            ]
        )

    def test_parameters_that_cannot_be_set_are_refused(self):
        self.assert_all_unusable(
            [
                (run("--set", "MaxAngAcc=10001"), "--set MaxAngAcc=10001", "1 ... 10000"),
                (run("--set", "MaxAngAcc=0"), "--set MaxAngAcc=0", "1 ... 10000"),
                (run("--set", "2.PolePairs=101"), "--set 2.PolePairs=101", "1 ... 100"),
                (run("--set", "MaxAngAcc=300m"), "--set", "MaxAngAcc", "'m'", "rad/s2", "rpm/min"),
                (run("--set", "MaxAngAcc=fast"), "--set MaxAngAcc=fast", "number"),
                (run("--set", "MaxAngAcc=99999999999"), "--set MaxAngAcc=99999999999"),
                (run("--set", "MaxAngAcc"), "--set MaxAngAcc", "NAME=VALUE"),
                (run("--set", "3.MaxAngAcc=300"), "--set 3.MaxAngAcc=300", "0 ... 2"),
                (run("--set", "BoardRevision=2"), "--set BoardRevision=2", "cannot be written"),
                (run("--set", "SpeedChange=352"), "--set SpeedChange=352", "SpeedLimit"),
            ]
        )

    def test_a_memory_that_is_not_the_drives_is_refused_and_not_touched(self):
        pathlib.Path(self.path("notes.txt")).write_text("mine\n")
        pathlib.Path(self.path("other.nvm")).write_text("virtdrive-nvm 1 md400\ncrc32 00000000\n")
        self.assert_all_unusable(
            [
                (run("--nvm", self.path("notes.txt")), "--nvm", "notes.txt", "not a memory"),
                (run("--nvm", self.path("other.nvm")), "--nvm", "'md400'", "toshiba-mcu"),
                (run("--nvm", self.path("nowhere/drive.nvm")), "--nvm", "nowhere", "not there"),
                (run("--nvm", self.path("")), "--nvm", "is not a file"),
            ]
        )

    def test_rates_loads_and_starts_that_mean_nothing_are_refused(self):
        for rate in ("0", "-1", "0.0001", "1001", "fast", "1x", "nan", "inf", ""):
            with self.subTest(rate):
                self.assert_unusable(
                    ["run", DRIVE, "--rate", rate, "--duration", "0"], f"--rate {rate}", "0.001"
                )
        self.assert_all_unusable(
            [
                (run("--load", "heavy"), "--load heavy", "KIND:VALUE[UNIT][@TIME]"),
                (run("--load", "bake:20mNm"), "--load bake:20mNm", "did you mean brake?"),
                (run("--load", "brake:much"), "--load brake:much", "'much' is not a number"),
                (run("--load", "brake:20kg"), "--load brake:20kg", "Nm or mNm"),
                (run("--load", "brake:-5mNm"), "--load brake:-5mNm", "negative"),
                (run("--load", "brake:5mNm@-1s"), "--load brake:5mNm@-1s", "time"),
                (run("--load", "brake:5mNm@1h"), "--load brake:5mNm@1h", "s or ms"),
                (run("--load", "brake:5mNm,fan:1"), "--load fan:1"),
                (run("--start", "fast"), "--start fast", "[CHANNEL:]RPM"),
                (run("--start", "1:"), "--start 1:", "[CHANNEL:]RPM"),
                (run("--start", "1:2000rpm"), "--start 1:2000rpm", "[CHANNEL:]RPM"),
                (run("--start", "3:2000"), "--start 3:2000", "0 ... 2"),
                (run("--start", "-1:2000"), "--start -1:2000", "0 ... 2"),
            ]
        )

    def test_options_that_do_not_parse_are_refused_in_one_line_too(self):
        self.assert_all_unusable(
            [
                ([], "--help"),
                (["run"], "DRIVE"),
                (["dance"], "dance"),
                (run("--dance"), "--dance"),
                (run("--line", "perfect"), "--line", "perfect", "real", "ideal"),
                (run("--integrator", "best"), "--integrator", "best", "default", "fast"),
                (run("--baud", "10"), "--baud", "10", "50", "12000000"),
                (run("--duration", "-1"), "--duration", "-1"),
                (run("--duration", "long"), "--duration", "long"),
                (run("--interval", "0"), "--interval", "0"),
                (run("--seed", "x"), "--seed", "x"),
                (run("--seed", "-1"), "--seed", "-1"),
            ]
        )

    def test_a_link_that_would_replace_what_is_not_ours_is_refused(self):
        (self.folder / "file").write_text("mine")
        (self.folder / "folder").mkdir()
        (self.folder / "link").symlink_to("/etc/hostname")
        (self.folder / "dangling").symlink_to("/dev/pts/nobody")
        for name, kind in (("file", "a file"), ("folder", "a folder"), ("link", "a link"),
                           ("dangling", "a link")):
            with self.subTest(name):
                self.assert_unusable(run("--link", name), self.path(name), kind, "another name")

    def test_a_link_in_a_folder_that_cannot_hold_it_is_refused(self):
        (self.folder / "file").write_text("mine")
        self.assert_all_unusable(
            [
                (run("--link", "missing/drive"), self.path("missing"), "mkdir -p"),
                (run("--link", "file/drive"), self.path("file"), "not a folder"),
                (run("--link", UNWRITABLE), UNWRITABLE, "not writable", "choose"),
                (run("--link", "./"), self.path(""), "names a folder"),
            ]
        )

    def test_a_link_of_a_running_bench_is_refused_and_that_bench_is_not_disturbed(self):
        bench = self.bench()
        self.assert_unusable(
            run("--link", bench.link), bench.link, f"process {bench.process.pid}", "another name"
        )
        with Host(bench.link) as host:
            self.assertEqual(host.version(), (3, 10))

    def test_a_recording_that_cannot_be_written_is_refused(self):
        (self.folder / "folder.csv").mkdir()
        signals = ["--signals", "motor1.speed"]
        self.assert_all_unusable(
            [
                (run("--record", "missing/a.csv", *signals), "--record missing/a.csv", "No such"),
                (run("--record", "folder.csv", *signals), "--record folder.csv", "directory"),
                (run("--record", f"{UNWRITABLE}.csv", *signals), f"--record {UNWRITABLE}.csv", "cannot be written"),
                (run("--record", "a.xls", *signals), "--record a.xls", ".csv, .vcd, .mat"),
                (run("--record", "a.csv"), "--record", "--signals"),
                (run(*signals), "--record", "--signals"),
            ]
        )

    def test_a_bench_that_cannot_start_leaves_recordings_as_they_were(self):
        (self.folder / "old.csv").write_text("precious\n")
        (self.folder / "taken").write_text("mine")
        for record in ("old.csv", "new.csv"):
            recording = ["--record", record, "--signals", "motor1.speed"]
            self.assert_all_unusable(
                [
                    (run(*recording, "--link", "taken"), "taken"),
                    (run(*recording, "--start", "fast"), "--start fast"),
                ]
            )

    def test_a_full_disk_is_told(self):
        for name in ("full.csv", "full.vcd", "full.mat"):
            (self.folder / name).symlink_to("/dev/full")
            result = self.run_program(*run("--record", name, "--signals", "motor1.speed"))
            self.assertEqual(result.returncode, UNUSABLE)
            self.assertIn(f"--record {name}: not all of it", result.stderr)


class Lifetime(CliTest):
    """How a run begins and ends."""

    def assert_nothing_left(self):
        self.assertEqual(self.files(), [])

    def test_interrupt_and_terminate_end_a_run_cleanly(self):
        for number in (signal.SIGINT, signal.SIGTERM):
            with self.subTest(number.name):
                bench = self.bench()
                self.assertEqual(self.files(), ["drive", "drive.lock"])
                self.assertEqual(os.readlink(bench.link), bench.ready["terminal"])
                self.assertEqual(bench.stop(number)["signal"], number)
                self.assert_nothing_left()

    def test_a_signal_ends_a_free_run_and_a_slow_one(self):
        for rate in ("max", "0.001"):
            with self.subTest(rate):
                bench = self.bench("--rate", rate, "--duration", 1e6, "--start", 2000)
                bench.stop()
                self.assert_nothing_left()

    def test_a_hang_up_removes_the_link(self):
        # The terminal's window was closed.
        bench = self.bench()
        bench.process.send_signal(signal.SIGHUP)
        bench.process.wait()
        self.assert_nothing_left()

    def test_a_reader_that_went_away_does_not_keep_the_link_from_being_removed(self):
        # virtdrive run ... --json | head -1
        process = subprocess.Popen(
            [PROGRAM, "run", DRIVE, "--json", "--link", self.path("drive")],
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
        )
        self.processes.append(process)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        process.stdout.readline()
        process.stdout.close()
        process.send_signal(signal.SIGTERM)
        process.wait()
        self.assert_nothing_left()

    def test_the_link_of_a_killed_bench_is_taken_over(self):
        first = self.bench()
        first.kill()
        self.assertEqual(self.files(), ["drive", "drive.lock"])
        second = self.bench()
        with Host(second.link) as host:
            self.assertEqual(host.version(), (3, 10))
        second.stop()
        self.assert_nothing_left()

    def test_two_benches_run_side_by_side(self):
        benches = [self.bench(link=name) for name in ("left", "right")]
        hosts = [Host(bench.link) for bench in benches]
        for host in hosts:
            self.addCleanup(host.close)
        hosts[0].set(1, 0x10, 7)
        self.assertEqual([host.get(1, 0x10).value for host in hosts], [7, 4])

    def test_a_duration_ends_the_run(self):
        for rate, seconds in (("max", 100), ("10", 2), ("1", 0.2), ("1", 0)):
            with self.subTest(f"{seconds} s at {rate}"):
                report = self.bench("--rate", rate, "--duration", seconds).report()
                self.assertEqual((report["simulated_s"], report["signal"]), (seconds, 0))
                self.assert_nothing_left()

    def test_the_ready_line_tells_what_runs_and_the_report_what_happened(self):
        bench = self.bench("--seed", 7, "--motor", "db42s01", "--baud", 57600)
        self.assertEqual(
            bench.ready,
            {
                "event": "ready",
                "drive": DRIVE,
                "port": bench.link,
                "terminal": os.readlink(bench.link),
                "baud": 57600,
                "motor": "db42s01",
                "seed": 7,
                "pid": bench.process.pid,
            },
        )
        with Host(bench.link, 57600) as host:
            host.version()
            host.state(1)
        report = bench.stop()
        self.assertEqual((report["event"], report["seed"]), ("end", 7))
        self.assertEqual((report["requests"], report["replies"]), (2, 2))
        for count in ("bad_frames", "bytes_lost_busy", "bytes_lost_unread", "bytes_garbled"):
            self.assertEqual(report[count], 0, count)
        self.assertGreater(report["simulated_s"], 0)

    def test_without_json_standard_output_has_the_ready_line_only(self):
        result = self.run_program(*run("--link", "drive"))
        self.assertEqual(result.returncode, DONE)
        self.assertRegex(
            result.stdout,
            rf"\Aready: {DRIVE} on {self.path('drive')} at 115200 baud, .* seed 1\n\Z"
        )
        self.assertRegex(result.stderr, r"\A0\.010 s simulated in .*\n\Z")

    def test_a_status_line_is_rewritten_in_place_on_a_terminal(self):
        master, slave = pty.openpty()
        self.addCleanup(os.close, master)
        process = subprocess.Popen(
            [PROGRAM, "run", DRIVE, "--start", "1000", "--duration", "1"],
            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=slave,
        )
        self.processes.append(process)
        os.close(slave)
        text = b""
        while select.select([master], [], [], self.deadline_s)[0]:
            try:
                text += os.read(master, 4096)
            except OSError:  # EIO: the program has ended
                break
        self.assertEqual(process.wait(), DONE)
        self.assertGreater(text.count(b"\r\x1b[K"), 2)
        self.assertIn(b"motor1 Force", text)
        self.assertEqual(text.count(b"\n"), 2, text)  # the last status, and the report

    def test_frames_are_traced_on_standard_error(self):
        bench = self.bench("--trace")
        with Host(bench.link) as host:
            host.version()
        bench.process.terminate()
        trace = bench.errors().splitlines()
        self.assertEqual(len(trace), 2, trace)
        self.assertRegex(trace[0], r"^\[ *\d+\.\d{6}\] > 11 14 00 6c 13  GetFWVersion")
        self.assertRegex(trace[1], r"^\[ *\d+\.\d{6}\] < 11 14 03 0a 0a 13  GetFWVersion")


class Information(CliTest):
    def test_help_is_everywhere(self):
        for words in ("", "run", "demo", "list", "list drives", "list motors", "list signals",
                      "list parameters", "document", "motor"):
            with self.subTest(words):
                result = self.run_program(*words.split(), "--help")
                self.assertEqual((result.returncode, result.stderr), (DONE, ""))
                self.assertIn("Usage:", result.stdout)

    def test_the_version_is_a_number(self):
        result = self.run_program("--version")
        self.assertEqual(result.returncode, DONE)
        self.assertRegex(result.stdout, r"\A\d+\.\d+\.\d+\n\Z")

    def test_a_motor_is_shown_checked_and_drawn(self):
        self.assertIn("5.667 mWb", self.run_program("motor", "db42s03").stdout)
        shown = json.loads(self.run_program("motor", "ec60-flat-24v", "--json").stdout)
        self.assertEqual(shown["kind"], "bldc")
        result = self.run_program("motor", "servo-400w", "--plot", "servo.svg")
        self.assertEqual((result.returncode, result.stdout), (DONE, ""), result.stderr)
        self.assertTrue((self.folder / "servo.svg").read_text().startswith("<svg "))
        schema = json.loads(self.run_program("motor", "--schema").stdout)
        self.assertIn("pole_pairs", schema["properties"])

    def test_a_motor_of_ones_own_runs_like_one_of_the_library(self):
        library = pathlib.Path(__file__).parents[2] / "data" / "motors"
        mine = self.folder / "mine.yaml"
        mine.write_text((library / "dr38312.yaml").read_text().replace("1.35", "1.5"))
        self.assertEqual(self.run_program("motor", str(mine), "--check").returncode, DONE)
        self.assertEqual(self.run_program(*run("--motor", str(mine))).returncode, DONE)
        mine.write_text(mine.read_text() + "pole_pairs: 7\n")
        lines = mine.read_text().count("\n")
        for arguments in (["motor", str(mine), "--check"], run("--motor", str(mine))):
            self.assert_unusable(arguments, f"{mine}:{lines}:1: key 'pole_pairs' is given twice")
        self.assert_unusable(["motor"], "expected a name")
        self.assert_unusable(["motor", "md10"], "motor 'md10'", "did you mean md100")
        self.assert_unusable(["motor", "md100", "--plot", UNWRITABLE], "--plot")

    def test_the_lists_name_what_run_takes(self):
        drives = self.run_program("list", "drives", "--names").stdout.split()
        self.assertIn(DRIVE, drives)
        self.assertIn("db42s03", self.run_program("list", "motors").stdout)
        for drive in drives:
            with self.subTest(drive):
                signals = self.run_program("list", "signals", drive).stdout.splitlines()
                names = ",".join(line.split()[0] for line in signals)
                result = self.run_program("run", drive, "--rate", "max", "--duration", "0.01",
                                          "--record", "all.csv", "--signals", names)
                self.assertEqual(result.returncode, DONE, result.stderr)
                header = (self.folder / "all.csv").read_text().splitlines()[0]
                self.assertEqual(header.count(","), len(signals))
                self.assertEqual(self.run_program("list", "parameters", drive).returncode, DONE)
                self.assertTrue(self.run_program("document", drive).stdout.startswith("# "))


class Repeatability(CliTest):
    def record(self, seed):
        name = f"{len(self.files())}.csv"
        result = self.run_program(
            "run", DRIVE, "--seed", str(seed), "--start", "2000", "--rate", "max",
            "--duration", "3", "--record", name,
            "--signals", "motor1.speed,motor1.current_q,drive1.stage",
        )
        self.assertEqual(result.returncode, DONE, result.stderr)
        return pathlib.Path(self.folder, name).read_bytes()

    def test_the_same_seed_gives_the_same_bits_and_another_one_others(self):
        first, again, other = self.record(42), self.record(42), self.record(43)
        self.assertEqual(first, again)
        self.assertNotEqual(first, other)
        rows = first.decode().splitlines()
        self.assertEqual(rows[0], "time_s,motor1.speed[rpm],motor1.current_q[A],drive1.stage")
        self.assertEqual(len(rows), 1 + 3001)
        time, speed, _, stage = rows[-1].split(",")
        self.assertEqual((time, stage), ("3.000000000", "6"))
        self.assertGreater(float(speed), 1000)


class Demo(CliTest):
    def test_the_demo_turns_a_motor_and_ends_well(self):
        result = self.run_program("demo", "--link", "drive", "--report", "demo.html")
        self.assertEqual((result.returncode, result.stderr), (DONE, ""))
        for word in ("Initposition", "Force", "FOC", "load 20 mNm", "stopping", "Stop",
                     "0 bad frames", "0 bytes lost"):
            self.assertIn(word, result.stdout)
        self.assertEqual(self.files(), ["demo.html"])
        report = pathlib.Path(self.path("demo.html")).read_text()
        self.assertGreater(report.count("<svg"), 4)
        self.assertNotIn("http", report.replace("http://www.w3.org/2000/svg", ""))

    def test_an_interrupted_demo_does_not_blame_the_drive(self):
        process = subprocess.Popen(
            [PROGRAM, "demo", "--link", self.path("drive"), "--report", ""],
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        )
        self.processes.append(process)
        process.stdout.readline()
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate()
        self.assertNotIn("does not answer", errors)
        self.assertEqual(self.files(), [])


class Network(CliTest):
    """Hosts that come over a network, or at the end of a wire."""

    def serve(self, *arguments):
        process = subprocess.Popen(
            [PROGRAM, "run", DRIVE, "--json", *arguments],
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True,
        )
        self.processes.append(process)
        self.addCleanup(process.stdout.close)
        self.addCleanup(process.kill)
        return process, json.loads(process.stdout.readline())["port"]

    def assert_answers(self, url):
        with serial.serial_for_url(url, baudrate=115200, timeout=10) as port:
            port.write(VERSION_REQUEST)
            self.assertEqual(port.read(len(VERSION_ANSWER)), VERSION_ANSWER)

    def end(self, process):
        process.send_signal(signal.SIGTERM)
        rest, _ = process.communicate()
        self.assertEqual(process.returncode, DONE)
        return json.loads(rest.splitlines()[-1])

    def test_a_host_may_come_over_tcp(self):
        process, address = self.serve("--tcp", "0")
        self.assertTrue(address.startswith("tcp://127.0.0.1:"), address)
        for _ in range(3):
            self.assert_answers(address.replace("tcp://", "socket://"))
        self.assertEqual(self.end(process)["requests"], 3)

    def test_a_host_may_come_over_rfc2217(self):
        process, address = self.serve("--rfc2217", "0")
        self.assert_answers(address)
        self.assertEqual(self.end(process)["requests"], 1)

    def test_the_drive_may_sit_at_the_end_of_a_real_port(self):
        master, slave = pty.openpty()  # stands for a serial device with a host at its other end
        tty.setraw(slave)
        process, address = self.serve("--port", os.ttyname(slave))
        self.assertEqual(address, os.ttyname(slave))
        os.write(master, VERSION_REQUEST)
        answer = b""
        while len(answer) < len(VERSION_ANSWER):
            answer += os.read(master, 64)
        self.assertEqual(answer, VERSION_ANSWER)
        self.end(process)
        os.close(slave)
        os.close(master)

    def test_ports_that_cannot_be_had_are_refused(self):
        with socket.create_server(("127.0.0.1", 0)) as taken:
            self.assert_all_unusable(
                [
                    (run("--tcp", str(taken.getsockname()[1])), str(taken.getsockname()[1])),
                    (run("--tcp", "nowhere:x"), "nowhere:x"),
                    (run("--tcp", "0", "--link", "drive"), "--tcp", "--link"),
                    (["run", DRIVE, "--port", "/dev/null"], "/dev/null"),
                    (["run", DRIVE, "--port", "nowhere"], "nowhere"),
                    (["run", DRIVE, "--port", "/dev/null", "--rate", "2"], "--port", "--rate"),
                ]
            )


class Tools(CliTest):
    """Programs that nobody wrote for us open the port."""

    def assert_answered(self, command):
        result = self.run_command(command, VERSION_REQUEST)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(result.stdout.encode("latin-1"), VERSION_ANSWER, result.stderr)

    def test_socat_sends_a_request_and_prints_the_answer(self):
        bench = self.bench()
        for address in (bench.link, f"{bench.link},raw,echo=0,b115200"):
            with self.subTest(address):
                self.assert_answered(["socat", "-t", "0.5", "-", address])
        self.assertEqual(bench.stop()["requests"], 2)

    def test_picocom_sends_a_request_and_prints_the_answer(self):
        bench = self.bench()
        self.assert_answered(
            ["picocom", "--quiet", "--baud", "115200", "--exit-after", "500", bench.link]
        )
        self.assertEqual(bench.stop()["requests"], 1)

    def test_a_shell_that_sets_nothing_speaks_with_the_drive(self):
        bench = self.bench()
        script = 'exec 3<>"$0"; printf "\\021\\024\\000\\154\\023" >&3; head -c 6 <&3'
        self.assert_answered(["bash", "-c", script, bench.link])

    def test_stty_in_between_does_no_harm(self):
        bench = self.bench()
        with Host(bench.link) as host:
            result = self.run_command(["stty", "-F", bench.link])
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertIn("115200", result.stdout)
            self.assertEqual(host.version(), (3, 10))


if __name__ == "__main__":
    unittest.main()
