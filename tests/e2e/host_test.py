"""virtdrive host and virtdrive monitor: talking to a drive, and listening in between."""

import json
import signal
import subprocess
import sys
import unittest

sys.dont_write_bytecode = True

from cli_test import CliTest
from program import PROGRAM
from toshiba_mcu import Host

DONE, FAILED, UNUSABLE = 0, 1, 2


class HostTool(CliTest):
    def host(self, port, *words, protocol="toshiba-mcu", code=DONE):
        result = self.run_program("host", port, "--protocol", protocol, *map(str, words))
        self.assertEqual(result.returncode, code, result.stderr)
        return result.stderr if code == UNUSABLE else result.stdout

    def test_parameters_and_commands_by_name_with_their_units(self):
        bench = self.bench()
        self.host(bench.link, "set", "MaxAngAcc=411", "1.IqStart=900mA")
        self.assertEqual(
            self.host(bench.link, "get", "MaxAngAcc", "IqStart"),
            "MaxAngAcc = 411 rad/s2\nIqStart = 900 mA\n",
        )
        self.assertEqual(
            self.host(bench.link, "call", "GetFWVersion"), "major = 3 \nminor = 10 \n"
        )
        reading = json.loads(self.host(bench.link, "get", "MaxAngAcc", "--json"))
        self.assertEqual(reading, {"name": "MaxAngAcc", "value": 411.0, "unit": "rad/s2"})
        watched = self.host(
            bench.link, "watch", "DcLinkVoltage", "--count", 3, "--every", 0.01
        )
        self.assertEqual(watched, "DcLinkVoltage = 24 V\n" * 3)

    def test_a_motor_turns_and_stops(self):
        bench = self.bench("--control", self.path("ctl"))
        speed = lambda: float(
            self.run_program("ctl", self.path("ctl"), "read", "motor1.speed").stdout.split()[0]
        )
        self.host(bench.link, "start", 800)
        self.wait_for("the motor", lambda: speed() > 700)
        self.host(bench.link, "stop")
        self.wait_for("the stop", lambda: abs(speed()) < 50)

    def test_a_dump_is_compared_and_written_back_on_another_drive(self):
        file = self.path("dump.yaml")
        bench = self.bench(link="first")
        self.host(bench.link, "set", "MaxAngAcc=411")
        self.host(bench.link, "dump", file, "--channel", "1,2")
        self.assertEqual(self.host(bench.link, "diff", file), "")
        other = self.bench(link="other")
        self.assertEqual(
            self.host(other.link, "diff", file, code=FAILED),
            "1.MaxAngAcc: 411rad/s2 -> 300rad/s2\n",
        )
        self.assertIn("1.MaxAngAcc=411rad/s2\n1 written", self.host(other.link, "restore", file))
        self.assertEqual(self.host(other.link, "diff", file), "")

    def test_it_talks_over_tcp_and_to_another_protocol(self):
        bench = self.bench("--tcp", "0", link=None, drive="md200t")
        address = bench.ready["port"]
        self.assertTrue(address.startswith("tcp://"), bench.ready)
        self.host(address, "set", "MAX_RPM=350", protocol="md200t")
        self.assertEqual(
            self.host(address, "get", "MAX_RPM", protocol="md200t").split()[:3],
            ["MAX_RPM", "=", "350"],
        )

    def test_what_cannot_be_done_is_told_in_one_line(self):
        bench = self.bench()
        for words, told in [
            (["get", "MaxAngAc"], "did you mean MaxAngAcc"),
            (["got", "MaxAngAcc"], "did you mean get"),
            (["get"], "expected the names of parameters"),
            (["call", "GetFWVersion", "x=1"], "unknown field 'x'"),
            (["start", "fast"], "'fast' is not a whole number"),
            (["restore", self.path("nothing.yaml")], "nothing.yaml"),
        ]:
            self.assertIn(told, self.host(bench.link, *words, code=UNUSABLE))
        self.assertIn("/nowhere", self.host("/nowhere", "stop", code=UNUSABLE))
        self.assertIn("cannot connect", self.host("tcp://127.0.0.1:1", "stop", code=UNUSABLE))
        refused = self.run_program(
            "host", bench.link, "--protocol", "toshiba-mcu", "set", "PolePairs=200"
        )
        self.assertEqual(refused.returncode, FAILED)
        self.assertIn("refused", refused.stderr)
        silent = self.run_program(
            "host", bench.link, "--protocol", "toshiba-mcu", "--baud", 9600, "get", "MaxAngAcc"
        )
        self.assertEqual(silent.returncode, FAILED)
        self.assertIn("does not answer", silent.stderr)


class Check(CliTest):
    def results(self, *arguments):
        file = self.path("check.json")
        checked = self.run_program("check", "drive", *arguments, "--json", file)
        self.assertEqual(checked.returncode, DONE, checked.stdout + checked.stderr)
        with open(file) as stream:
            return [(r["row"], r["what"], r["passed"]) for r in json.load(stream)["results"]]

    def test_a_drive_over_a_terminal_gets_the_verdicts_that_it_gets_in_virtual_time(self):
        bench = self.bench()
        over_terminal = self.results(
            "--port", bench.link, "--protocol", "toshiba-mcu", "--silence", "0.01"
        )
        self.assertGreater(len(over_terminal), 400)
        self.assertEqual(over_terminal, self.results("--drive", "toshiba-mcu"))

    def test_another_device_fails_and_says_how(self):
        bench = self.bench(drive="md400t")
        junit = self.path("junit.xml")
        result = self.run_program(
            *["check", "drive", "--port", bench.link, "--protocol", "toshiba-mcu"],
            *["--patience", "0.02", "--most-failures", 5, "--junit", junit],
        )
        self.assertEqual(result.returncode, FAILED, result.stderr)
        self.assertIn("expected an answer, heard nothing", result.stdout)
        with open(junit) as stream:
            self.assertIn("<failure", stream.read())

    def test_what_cannot_be_checked_is_told(self):
        for arguments, told in [
            ([], "either --port PORT or --drive DRIVE"),
            (["--port", "/nowhere"], "--protocol is missing"),
            (["--drive", "md40t"], "did you mean md400 or md400t"),
            (["--drive", "md400t", "--allow", "all"], "all not in"),
        ]:
            result = self.run_program("check", "drive", *arguments)
            self.assertEqual(result.returncode, UNUSABLE, result.stdout)
            self.assertIn(told, result.stderr)


class Monitor(CliTest):
    def monitor(self, *arguments):
        process = subprocess.Popen(
            [PROGRAM, "monitor", *arguments],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        self.processes.append(process)
        self.addCleanup(process.stdout.close)
        self.addCleanup(process.stderr.close)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        return process

    def test_a_tap_passes_everything_on_decodes_it_and_records_what_a_replay_repeats(self):
        bench = self.bench()
        host_port, file = self.path("host"), self.path("tap.pcapng")
        tap = self.monitor(
            "--tap", bench.link, host_port, "--protocol", "toshiba-mcu", "--json", "--wire", file
        )
        self.wait_for("the tap", lambda: "host" in self.files())
        with Host(host_port) as host:
            self.assertEqual(host.version(), (3, 10))
        packets = [json.loads(tap.stdout.readline()) for _ in range(2)]
        tap.send_signal(signal.SIGINT)
        self.assertEqual(tap.wait(), DONE)
        self.assertEqual([p["from"] for p in packets], ["host", "drive"])
        self.assertEqual({p["verdict"] for p in packets}, {"frame"})
        self.assertEqual(packets[0]["bytes"], "11 14 00 6c 13")
        self.assertEqual(packets[1]["text"], "GetFWVersion major=3 minor=10")

        shown = self.run_program("monitor", file)
        self.assertEqual(shown.returncode, DONE, shown.stderr)
        self.assertEqual(len(shown.stdout.splitlines()), 2)
        self.assertIn("> 11 14 00 6c 13  GetFWVersion", shown.stdout)
        replayed = self.run_program("replay", file, "--tolerance", "1000")
        self.assertEqual(replayed.returncode, DONE, replayed.stdout)

    def test_a_tap_follows_the_baud_rate_of_the_host(self):
        drive = self.bench("--baud", 9600, link="slow")
        tap = self.monitor(
            "--tap", drive.link, self.path("host"), "--protocol", "toshiba-mcu", "--color", "always"
        )
        self.wait_for("the tap", lambda: "host" in self.files())
        with Host(self.path("host"), baud=9600) as host:
            self.assertEqual(host.version(), (3, 10))
        self.assertIn("\x1b[36m> 11 14 00 6c 13", tap.stdout.readline())
        tap.send_signal(signal.SIGTERM)
        tap.wait()

    def test_what_is_no_recording_is_refused(self):
        for arguments, told in [
            ([], "expected a recording, or --tap"),
            ([__file__], "is no pcapng file"),
            ([self.path("nothing")], "nothing"),
            (["--tap", "/nowhere", self.path("x")], "--protocol is missing"),
            (["--tap", "/nowhere", self.path("x"), "--protocol", "md"], "unknown drive 'md'"),
            (["--tap", "/nowhere", self.path("x"), "--protocol", "md400t"], "/nowhere"),
        ]:
            result = self.run_program("monitor", *arguments)
            self.assertEqual(result.returncode, UNUSABLE, arguments)
            self.assertIn(told, result.stderr)


if __name__ == "__main__":
    unittest.main()
