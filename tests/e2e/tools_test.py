"""Host programs and libraries that nobody wrote for us, over a real pseudo-terminal or RFC 2217."""

import sys
import unittest

import serial

sys.dont_write_bytecode = True

from program import Bench, ProgramTest
from toshiba_mcu import Host

VERSION_REQUEST = bytes.fromhex("11 14 00 6c 13")
VERSION_ANSWER = bytes.fromhex("11 14 03 0a 0a 13")

RECONNECTS = 10
PATIENCE_S = 10.0
SILENCE_S = 0.3  # an answer takes 2 ms


class ToolTest(ProgramTest):
    def assert_still_served(self, bench):
        with Host(bench.link) as host:
            self.assertEqual(host.version(), (3, 10))


class Pyserial(ToolTest):
    """The drive speaks 8N1. The kernel's pseudo-terminals take a host's parity and character size
    without a word and pass 8 bits all the same; over RFC 2217 they count, as on a wire."""

    def connect_and_ask(self, address, patience_s, **settings):
        with serial.serial_for_url(address, 115200, timeout=patience_s, **settings) as port:
            port.write(VERSION_REQUEST)
            return port.read(len(VERSION_ANSWER))

    def assert_served_each_time(self, address, times=RECONNECTS, **settings):
        for attempt in range(times):
            with self.subTest(attempt=attempt, **settings):
                answer = self.connect_and_ask(address, PATIENCE_S, **settings)
                self.assertEqual(answer, VERSION_ANSWER)

    def test_hosts_with_8e1_7o1_and_8n2_are_served_each_time_they_connect(self):
        bench = self.bench()
        settings = [
            {"bytesize": 8, "parity": "E", "stopbits": 1},
            {"bytesize": 7, "parity": "O", "stopbits": 1},
            {"bytesize": 8, "parity": "N", "stopbits": 2},
        ]
        for one in settings:
            self.assert_served_each_time(bench.link, **one)
        for _ in range(RECONNECTS):  # one after another on the same port
            for one in settings:
                self.assertEqual(
                    self.connect_and_ask(bench.link, PATIENCE_S, **one), VERSION_ANSWER
                )
        report = bench.stop()
        self.assertEqual(report["requests"], 2 * RECONNECTS * len(settings))
        self.assertEqual(report["bad_frames"], 0)

    def test_over_rfc_2217_two_stop_bits_are_understood_and_7o1_is_not(self):
        bench = Bench(self, ["--rfc2217", "0"], link=None)
        address = bench.ready["port"]
        self.assert_served_each_time(address, 3, bytesize=8, parity="N", stopbits=2)
        answer = self.connect_and_ask(address, SILENCE_S, bytesize=7, parity="O", stopbits=1)
        self.assertNotEqual(answer, VERSION_ANSWER)
        self.assert_served_each_time(address, 1, bytesize=8, parity="N", stopbits=1)
        self.assertGreater(bench.stop()["bytes_garbled"], 0)


class Modbus(ToolTest):
    def poll(self, bench, *settings):
        return self.run_command(
            ["mbpoll", "-m", "rtu", "-a", "1", "-r", "1", "-c", "1", "-1", "-o", "0.2", *settings,
             bench.link]
        )

    def test_mbpoll_opens_the_port_gets_no_answer_and_leaves_the_drive_unharmed(self):
        bench = self.bench()
        for settings in (["-b", "115200", "-P", "none"], ["-b", "115200", "-P", "even"]):
            for _ in range(3):
                with self.subTest(settings):
                    result = self.poll(bench, *settings)
                    self.assertNotEqual(result.returncode, 0, result.stdout)
                    self.assertIn("timed out", result.stderr)
                    self.assert_still_served(bench)
        report = bench.stop()
        self.assertEqual(report["requests"], 6)
        self.assertGreater(report["bad_frames"], 0)


class Terminals(ToolTest):
    def assert_answered_each_time(self, bench, command):
        for attempt in range(2):
            with self.subTest(attempt=attempt):
                result = self.run_command(command, VERSION_REQUEST)
                self.assertEqual(result.returncode, 0, result.stderr)
                self.assertEqual(result.stdout.encode("latin-1"), VERSION_ANSWER, result.stderr)
        self.assertEqual(bench.stop()["requests"], 2)

    def test_socat_is_answered_each_time_it_opens_the_port(self):
        bench = self.bench()
        self.assert_answered_each_time(
            bench, ["socat", "-t", "0.5", "-", f"{bench.link},raw,echo=0,b115200"]
        )

    def test_picocom_is_answered_each_time_it_opens_the_port_whatever_parity_it_asks_for(self):
        for parity in ("none", "even"):
            bench = self.bench(link=parity)
            self.assert_answered_each_time(
                bench,
                ["picocom", "--quiet", "--baud", "115200", "--parity", parity, "--exit-after",
                 "500", bench.link],
            )


if __name__ == "__main__":
    unittest.main()
