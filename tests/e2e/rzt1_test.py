"""The RZ/T1 kit over real pseudo-terminals: typed at, and asked by a host written from its document."""

import math
import os
import shutil
import subprocess
import time
import unittest
import xml.etree.ElementTree

import rzt1
from program import SOURCE, ProgramTest

EXAMPLE = SOURCE / "docs/examples/rzt1/step_response.py"

LONG = "VIRTDRIVE_ENDURANCE" in os.environ
CYCLE_S = 100e-6


class DriveTest(ProgramTest):
    deadline_s = 150 if LONG else 60

    def start(self, *arguments):
        self.bench_ = self.bench(*arguments, drive="rzt1")
        host = rzt1.Host(self.bench_.link)
        self.addCleanup(host.close)
        return host


class Hosts(DriveTest):
    def test_a_move_is_ordered_in_packets_and_read_back_in_lines(self):
        host = self.start("--set", "PITIME=1000")
        self.assertEqual(host.send(1, rzt1.MODULE_DATA, reply=4), bytes([3, 0x20, 0, 4]))
        self.assertEqual(host.send(2, rzt1.MODULE_DATA, reply=4), bytes([3, 0x20, 0, 4]))
        self.assertEqual(host.line("KP"), "2000\r\n>")
        host.switch_on()
        host.set("POS", 0)
        host.set("ABS", 30000)
        host.call("GO")
        self.wait_for("the end of the motion", lambda: host.report(2)[0] & rzt1.COMPLETE)
        position, status = host.report(3)
        self.assertAlmostEqual(position, 30000, delta=50)
        self.assertEqual(int(host.line("STA")[:-3], 16), status)
        report = self.bench_.stop()
        self.assertEqual((report["bad_frames"], report["bytes_lost_busy"]), (0, 0))

    def test_what_is_saved_is_there_when_it_is_started_again(self):
        memory = self.path("rzt1.nvm")
        host = self.start("--nvm", memory)
        host.set("KP", 1234)
        host.call("SAVE")
        self.bench_.stop()
        self.assertEqual(self.start("--nvm", memory).get("KP"), 1234)

    def test_refusals_have_their_codes(self):
        host = self.start()
        for order, status in (
            (lambda: host.set("GEARIN", 0), 4),
            (lambda: host.set("TC", 0), 5),
            (lambda: host.call("HOME"), 8),
            (lambda: host.send(1, 99), 1),
            (lambda: host.send(1, rzt1.GET, b"\xc8"), 2),
            (lambda: host.send(1, rzt1.GET), 3),
        ):
            with self.assertRaises(rzt1.Refused) as refused:
                order()
            self.assertEqual(refused.exception.status, status)

    def test_console_2_says_R_after_a_reset(self):
        second, third = self.path("con1"), self.path("con2")
        host = self.start("--link2", second, "--link3", third)
        with rzt1.Host(second) as other, rzt1.Host(third) as ready:
            self.assertEqual(other.line("2"), "\r\n>")
            self.assertEqual(other.line("ADDR"), "2\r\n>")
            self.assertEqual(host.line("ADDR"), "1\r\n>")
            ready.port.reset_input_buffer()  # it may still hold the R of the start
            self.assertEqual(host.line("RESET"), "\r\n>")
            self.assertEqual(ready.read(1), b"R")
            self.assertEqual(other.line("ADDR"), "1\r\n>")


class Streaming(DriveTest):
    """A sine of 20 000 counts and a period of 2 s, in points 20 ms apart: the FIFO holds 2 s, and a machine
    that is busy with other tests may keep us waiting. Points 5 ms apart are a test in simulated time."""

    SLICE = 200  # loop cycles
    AMPLITUDE, PERIOD_S = 20000, 2.0

    def point(self, i):
        time_s = i * self.SLICE * CYCLE_S
        omega = 2 * math.pi / self.PERIOD_S
        position = self.AMPLITUDE * (1 - math.cos(omega * time_s))
        velocity = self.AMPLITUDE * omega * math.sin(omega * time_s)
        return round(position), round(velocity * CYCLE_S * 65536)

    def stream(self, host, seconds, first=1):
        """Keeps the FIFO filled; the number of the first point not sent."""
        mask = 1 << 0 | 1 << 1 | 1 << 6
        next_point, deepest_want = first, 31
        count = first + round(seconds / (self.SLICE * CYCLE_S))
        worst = 0
        while next_point < count:
            _, status, depth = host.report(mask)
            self.assertEqual(status & rzt1.STARVED, 0, f"starved at point {next_point}")
            if depth + deepest_want <= 100:
                end = min(next_point + deepest_want, count)
                host.stream([self.point(i) for i in range(next_point, end)])
                next_point = end
            else:
                time.sleep(0.02)
            if status & rzt1.SERVO_ON:
                worst = max(worst, abs(host.get("ERR")))
        self.assertLess(worst, 1000)
        return next_point

    def begin(self, host):
        host.switch_on()
        host.set("POS", 0)
        host.set("PRO", 3)
        host.send(1, rzt1.INIT_PVT, bytes([self.SLICE]))
        host.stream([self.point(i) for i in range(1, 32)])
        host.stream([self.point(i) for i in range(32, 63)])
        host.call("GO")
        return 63

    def test_pvt_points_at_115200_and_921600_baud_without_starving(self):
        host = self.start("--set", "PITIME=1000")
        seconds = (60, 10) if LONG else (2.5, 1.5)
        next_point = self.stream(host, seconds[0], self.begin(host))
        host.change_baud(921600)
        next_point = self.stream(host, seconds[1], next_point)
        # The host falls silent: what is left is played, then the drive tells that it starves.
        self.wait_for("starvation", lambda: host.report(2)[0] & rzt1.STARVED)
        self.wait_for("standstill", lambda: host.report(2)[0] & rzt1.COMPLETE)
        report = self.bench_.stop()
        self.assertEqual((report["bad_frames"], report["bytes_lost_busy"]), (0, 0))


class Example(DriveTest):
    """docs/examples/rzt1/step_response.py, as a reader would run it."""

    def test_it_draws_a_step_response_as_the_page_shows_it(self):
        bench = self.bench(drive="rzt1")
        picture = self.path("step-response.svg")
        result = self.run_command(["/usr/bin/python3", "-B", EXAMPLE, bench.link, "--svg", picture])
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        self.assertIn("position error", result.stdout)
        drawn = xml.etree.ElementTree.parse(picture).getroot()
        committed = xml.etree.ElementTree.parse(EXAMPLE.parent / "step-response.svg").getroot()
        for root in (drawn, committed):
            lines = root.findall("{http://www.w3.org/2000/svg}polyline")
            self.assertEqual([len(line.get("points").split()) for line in lines], [512] * 3)


@unittest.skipUnless(shutil.which("tmux") and shutil.which("picocom"), "needs tmux and picocom")
class Typing(DriveTest):
    def tmux(self, *words):
        result = subprocess.run(
            ["tmux", "-L", f"virtdrive{os.getpid()}", "-f", "/dev/null", *words],
            capture_output=True, text=True, check=False,
        )
        return result.stdout

    def screen(self):
        return [line.rstrip() for line in self.tmux("capture-pane", "-p", "-t", "typing").splitlines()]

    def test_a_session_in_a_terminal_reads_as_the_document_shows_it(self):
        bench = self.bench(drive="rzt1")
        self.addCleanup(self.tmux, "kill-server")
        self.tmux("new-session", "-d", "-s", "typing", "-x", "80", "-y", "24",
                  f"picocom --quiet --baud 115200 --echo --emap crcrlf {bench.link}")
        self.wait_for("picocom", lambda: self.typed("", "\n>"))
        for line in ("POS 2100", "POS", "POS 2000", "POS", "pos", "ERR 5", "STA"):
            before = "\n".join(self.screen()).count("\n>") + "\n".join(self.screen()).count("\n?")
            self.tmux("send-keys", "-t", "typing", "-l", line)
            self.tmux("send-keys", "-t", "typing", "Enter")
            self.wait_for(f"the prompt after {line}", lambda: self.prompts() > before)
        shown = [line for line in self.screen() if line]
        self.assertEqual(shown[-11:], [
            ">POS", "2100",
            ">POS 2000",
            ">POS", "2000",
            ">pos", "2000",
            ">ERR 5",
            "?STA", "0001",
            ">",
        ])

    def prompts(self):
        text = "\n".join(self.screen())
        return text.count("\n>") + text.count("\n?")

    def typed(self, line, answer):
        # Until picocom is there, what is typed shows up without an answer.
        self.tmux("send-keys", "-t", "typing", "-l", line)
        self.tmux("send-keys", "-t", "typing", "Enter")
        time.sleep(0.2)
        return answer in "\n" + "\n".join(self.screen())


if __name__ == "__main__":
    unittest.main()
