"""The Toshiba MCU's oscilloscope, motion and example host, through a real pseudo-terminal."""

import struct
import subprocess
import sys
import unittest
import xml.etree.ElementTree

sys.dont_write_bytecode = True

import serial

import toshiba_mcu as mcu
from drive_test import MOTOR, DriveTest
from program import SOURCE
from toshiba_mcu import Stage

EXAMPLE = SOURCE / "docs/examples/toshiba-mcu/commission.py"
COUNTS_PER_TURN = 2000
A_MAX_MA = 2500 / 0.316  # 2.5 V over 316 mV/A


class Oscilloscope(DriveTest):
    def fetch(self, host, blocks):
        """All values, asked for as the document says: until the drive has them."""
        values = []
        while len(values) < 16 * blocks:
            try:
                values += host.dso_block()
            except mcu.ErrorAnswer as error:
                self.assertEqual(error.code, mcu.DSO_NOT_READY)
        return values

    def test_a_shot_of_the_phase_currents_shows_the_current_that_the_drive_reports(self):
        _, host = self.start_bench("--load", "brake:20mNm,inertia:1e-5", "--rate", 5)
        self.spin_up(host, 2000)
        selected = mcu.DSO["Ia"] | mcu.DSO["Ib"] | mcu.DSO["Ic"]
        blocks = host.arm(MOTOR, selected, mcu.DSO["Ia"], mcu.RISING, 0)
        self.assertEqual(blocks, 20)
        values = self.fetch(host, blocks)
        self.assert_refused(mcu.DSO_EMPTY, host.dso_block)
        sets = [values[3 * i : 3 * i + 3] for i in range(106)]
        for currents in sets:
            self.assertAlmostEqual(sum(currents), 0, delta=150)  # noise, 16 a count
        peak = max(abs(value) for currents in sets for value in currents)
        self.assertAlmostEqual(
            peak / 32768 * A_MAX_MA, host.state(MOTOR).current_ma, delta=60
        )

    def test_a_stopped_motor_never_gives_a_shot(self):
        _, host = self.start_bench()
        self.assertEqual(host.arm(MOTOR, mcu.DSO["Va"]), 20)
        self.assert_refused(mcu.DSO_NOT_READY, host.dso_block)

    def test_the_second_port_streams_each_period_with_its_number(self):
        second = self.path("scope")
        _, host = self.start_bench("--link2", second, "--rate", 0.5)
        self.spin_up(host, 2000, acceleration=3000)
        selected = mcu.DSO["Ia"] | mcu.DSO["Ib"] | mcu.DSO["Ic"]
        with serial.Serial(second, 5_000_000, timeout=self.deadline_s) as scope:
            host.configure_stream(MOTOR, 1, selected)
            frames = [scope.read(11) for _ in range(400)]
            host.configure_stream(MOTOR, 0, 0)
        stamps = []
        for frame in frames:
            self.assertEqual(frame[0], mcu.BOT)
            self.assertEqual(frame[1], mcu.crc8(0, frame[2:]))
            missed, stamp, *currents = struct.unpack("<BH3h", frame[2:])
            self.assertEqual(missed, 0)
            self.assertAlmostEqual(sum(currents), 0, delta=150)  # noise, 16 a count
            stamps.append(stamp)
        self.assertEqual(stamps, list(range(400)))


class Motion(DriveTest):
    def test_turns_are_made_counted_and_ended_with_a_stop(self):
        _, host = self.start_bench("--rate", 10)
        host.do_turn(MOTOR, -3, 600)
        self.wait_for_stage(host, Stage.FORCE)
        self.wait_for_stage(host, Stage.STOP)
        self.assertEqual(host.get(MOTOR, mcu.TURN_NUMBER).value, -3)

    def test_a_position_is_reached_held_and_read_back(self):
        _, host = self.start_bench("--rate", 10)
        host.set(MOTOR, mcu.ENCODER, mcu.ENCODER_INCENC_ABZ)
        host.set(MOTOR, mcu.ENCODER_START_POS, 5000)
        self.assertEqual(host.absolute_position(MOTOR), 5000)
        target = 5000 + 4 * COUNTS_PER_TURN
        self.assertEqual(host.do_linear_motion(MOTOR, target, 500), 0)
        self.assertEqual(host.do_linear_motion(MOTOR, 5000, 500), 1)  # busy
        self.wait_for("arrival", lambda: host.state(MOTOR).target_rpm == 0)
        self.assertAlmostEqual(host.absolute_position(MOTOR), target, delta=15)
        self.assertAlmostEqual(host.encoder_counter(MOTOR), 4 * COUNTS_PER_TURN, delta=15)
        self.assertEqual(host.stage(MOTOR), Stage.FORCE)
        self.assertEqual(host.abort_linear_motion(MOTOR), 0)

    def test_the_demos_state_is_a_number_that_is_kept(self):
        _, host = self.start_bench()
        self.assertEqual(host.demo_state(), 0)
        self.assertEqual(host.set_demo_state(3), 0)
        self.assertEqual(host.demo_state(), 3)


class Commissioning(DriveTest):
    """docs/examples/toshiba-mcu/commission.py, as a reader would run it."""

    def commission(self, link):
        picture = self.path("phase-currents.svg")
        done = subprocess.run(
            ["/usr/bin/python3", "-B", EXAMPLE, link, "--svg", picture],
            capture_output=True, text=True, timeout=self.deadline_s, check=False,
        )
        return done, picture

    def test_the_example_reads_everything_starts_the_motor_and_draws_its_currents(self):
        bench = self.bench("--load", "brake:15mNm,inertia:1e-5", "--rate", 3)
        done, picture = self.commission(bench.link)
        self.assertEqual((done.returncode, done.stderr), (0, ""), done.stdout)
        self.assertIn("firmware 3.10, motor 1: Nanotec DB42S03", done.stdout)
        self.assertIn("PwmFrequency                     12500 unit 0", done.stdout)
        root = xml.etree.ElementTree.parse(picture).getroot()
        curves = [element for element in root if element.tag.endswith("polyline")]
        self.assertEqual([len(curve.get("points").split()) for curve in curves], [106] * 3)

    def test_the_picture_of_the_docs_is_of_this_example(self):
        committed = xml.etree.ElementTree.parse(EXAMPLE.parent / "phase-currents.svg").getroot()
        titles = [element.text for element in committed if element.tag.endswith("text")]
        self.assertEqual(titles[0], "Nanotec DB42S03 at 2000 rpm: phase currents")

    def test_a_drive_that_does_not_answer_ends_it_with_one_line(self):
        bench = self.bench("--baud", 57600)
        done, _ = self.commission(bench.link)
        self.assertEqual(done.returncode, 1)
        self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)
        self.assertIn("no answer to command 14", done.stderr)


if __name__ == "__main__":
    unittest.main()
