"""Hosts that come and go, do not read, or do not stop writing: nothing stale, nothing that grows.

VIRTDRIVE_ENDURANCE multiplies how long the second and third go on (10 in the long tests).
"""

import os
import pathlib
import random
import select
import sys
import termios
import time
import tty
import unittest

import serial

sys.dont_write_bytecode = True

from program import ProgramTest
from toshiba_mcu import Host

FACTOR = int(os.environ.get("VIRTDRIVE_ENDURANCE", "1"))

VERSION_REQUEST = bytes.fromhex("11 14 00 6c 13")
VERSION_ANSWER = bytes.fromhex("11 14 03 0a 0a 13")
STATE_REQUEST = bytes.fromhex("11 02 01 09 13")
STATE_ANSWER_SIZE = 24

PAGE = os.sysconf("SC_PAGE_SIZE")
MOST_GROWTH = 512 * 1024  # bytes: what an allocator may still take once everything has run before


class EnduranceTest(ProgramTest):
    deadline_s = 60 * FACTOR

    def resident(self, bench):
        """Bytes of memory that the program has."""
        return int(pathlib.Path(f"/proc/{bench.process.pid}/statm").read_text().split()[1]) * PAGE

    def descriptors(self, bench):
        return len(os.listdir(f"/proc/{bench.process.pid}/fd"))

    def assert_no_growth(self, bench, before):
        maps = pathlib.Path(f"/proc/{bench.process.pid}/maps").read_text()
        if "libasan" not in maps and "libtsan" not in maps:  # they keep what was freed
            self.assertLess(self.resident(bench) - before, MOST_GROWTH)

    def assert_still_served(self, bench):
        with Host(bench.link) as host:
            self.assertEqual(host.version(), (3, 10))

    def wait_readable(self, fd):
        ready, _, _ = select.select([fd], [], [], 10)
        self.assertTrue(ready, "the drive does not answer")


class Reconnects(EnduranceTest):
    CYCLES = 10_000
    WARM_UP = 100

    def test_a_port_that_is_opened_and_closed_for_ever_gives_nothing_stale_and_grows_nothing(self):
        bench = self.bench("--line", "ideal")
        for cycle in range(self.WARM_UP + self.CYCLES):
            if cycle == self.WARM_UP:
                before = self.resident(bench), self.descriptors(bench)
            fd = os.open(bench.link, os.O_RDWR | os.O_NOCTTY)
            # As pyserial does: between our close() and open() the bench may not have had its turn.
            termios.tcflush(fd, termios.TCIFLUSH)
            if cycle % 3 == 0:  # leaves an answer unread
                os.write(fd, STATE_REQUEST)
                self.wait_readable(fd)
            else:
                os.write(fd, VERSION_REQUEST)
                answer = b""
                while len(answer) < len(VERSION_ANSWER):
                    self.wait_readable(fd)
                    answer += os.read(fd, 4096)
                self.assertEqual(answer, VERSION_ANSWER, f"cycle {cycle}")
            os.close(fd)
        self.assertEqual(self.descriptors(bench), before[1])
        self.assert_no_growth(bench, before[0])
        self.assertEqual(bench.stop()["requests"], self.WARM_UP + self.CYCLES)


class DeafHost(EnduranceTest):
    REQUESTS = 4000 * FACTOR  # 96 kB of answers; the kernel holds about 20 kB
    BATCH = 16

    def test_a_host_that_never_reads_loses_answers_and_the_drive_goes_on(self):
        bench = self.bench("--line", "ideal", "--lenient")
        with Host(bench.link) as host:
            first_tick = host.state(1).tick
        fd = os.open(bench.link, os.O_RDWR | os.O_NOCTTY)
        self.addCleanup(os.close, fd)
        tty.setraw(fd, termios.TCSANOW)
        before = None
        for sent in range(0, self.REQUESTS, self.BATCH):
            if before is None and sent >= 2000:  # all that may fill up has done so
                before = self.resident(bench)
            os.write(fd, STATE_REQUEST * self.BATCH)  # waits for the bench, not for our reading
        self.assert_no_growth(bench, before)
        other = os.open(bench.link, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        self.addCleanup(os.close, other)
        termios.tcflush(other, termios.TCIFLUSH)  # somebody reads at last
        self.wait_for("an answer", lambda: self.answered(other, first_tick))
        report = bench.stop()
        self.assertGreater(report["bytes_lost_unread"], 0)

    def answered(self, fd, first_tick):
        termios.tcflush(fd, termios.TCIFLUSH)
        os.write(fd, STATE_REQUEST)
        time.sleep(0.05)
        try:
            answer = os.read(fd, 4096)
        except BlockingIOError:
            return False
        if len(answer) != STATE_ANSWER_SIZE or answer[0] != 0x11:
            return False
        tick = int.from_bytes(answer[18:22], "little")
        self.assertGreater(tick, first_tick)
        return True


class Flood(EnduranceTest):
    BAUD = 5_000_000
    SECONDS = 2 * FACTOR

    def test_a_host_that_floods_at_5_mbit_s_loses_what_the_drive_cannot_take(self):
        bench = self.bench("--baud", self.BAUD)
        chance = random.Random(1)
        noise = bytes(chance.randrange(256) for _ in range(2000))
        burst = noise + VERSION_REQUEST * 100 + STATE_REQUEST * 100
        before = None
        sent = 0
        with serial.Serial(bench.link, self.BAUD, timeout=0) as port:
            end = self.SECONDS * self.BAUD // 10
            while sent < end:
                sent += port.write(burst)
                port.read(65536)
                if before is None and sent > end // 4:
                    before = self.resident(bench)
            self.assert_no_growth(bench, before)
        for _ in range(20):  # a telegram that the flood left half may swallow the next one
            with Host(bench.link, self.BAUD, patience_s=0.5) as host:
                try:
                    self.assertEqual(host.version(), (3, 10))
                    break
                except Exception as error:  # NoAnswer, ErrorAnswer, BadAnswer: once more
                    last = error
        else:
            self.fail(f"the drive does not come back: {last}")
        report = bench.stop()
        self.assertGreater(report["bytes_lost_busy"], sent // 10)
        self.assertGreaterEqual(report["simulated_s"], 0.9 * self.SECONDS)
        self.assertIn("overruns", report)


if __name__ == "__main__":
    unittest.main()
