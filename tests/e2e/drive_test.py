"""A host program drives the emulated Toshiba MCU through a real pseudo-terminal.

The yardstick of time is the drive's own tick (1 ms, in each GetMotorState), so that a busy machine
changes no result: where the simulation cannot keep its rate it slips, and its tick with it.
"""

import csv
import itertools
import statistics
import sys
import unittest

sys.dont_write_bytecode = True

import toshiba_mcu as mcu
from program import TEST_DATA, ProgramTest, read_recording
from toshiba_mcu import Host, Stage

MOTOR = 1  # of the document's examples
POLE_PAIRS = 4
RPM_PER_HZ = 60 / POLE_PAIRS
RAD_PER_TURN = 6.283185307179586

MAX_ANG_ACC = 300  # rad/s2, electrical (4.2.12)
RAMP_RPM_PER_S = MAX_ANG_ACC / RAD_PER_TURN * RPM_PER_HZ  # 716.2
SPEED_CHANGE_HZ = 25
TORQUE_FACTOR = 34  # mNm/A

BOOTSTRAP_MS = 10
POSITION_DELAY_MS = 200
FORCE_MS = SPEED_CHANGE_HZ / (MAX_ANG_ACC / RAD_PER_TURN) * 1000  # 523.6
ZERO_CURRENT_MS = 4 / 12.5  # four periods of 12.5 kHz

SILENCE_S = 0.1  # an answer takes 2 ms
PATIENCE_S = 0.3  # where a host may have to repeat its request
REFUSED = bytes.fromhex("11 ee ff 77 13")
CRC_ERROR = bytes.fromhex("11 ee 01 83 13")
VERSION_REQUEST = bytes.fromhex("11 14 00 6c 13")
VERSION_ANSWER = bytes.fromhex("11 14 03 0a 0a 13")


class DriveTest(ProgramTest):
    def start_bench(self, *arguments):
        """A bench, and a host on its port."""
        bench = self.bench(*arguments)
        return bench, self.open(bench)

    def open(self, bench, baud=mcu.BAUD):
        host = Host(bench.link, baud)
        self.addCleanup(host.close)
        return host

    def spin_up(self, host, rpm, acceleration=MAX_ANG_ACC):
        """Starts the motor and waits until it has settled at the speed."""
        if acceleration != MAX_ANG_ACC:
            host.set(MOTOR, mcu.MAX_ANG_ACC, acceleration)
        host.set(MOTOR, mcu.SPEED, rpm)
        host.start(MOTOR)
        begin = host.state(MOTOR).tick
        ramp_ms = abs(rpm) / RAMP_RPM_PER_S * MAX_ANG_ACC / acceleration * 1000
        self.wait_for_tick(host, begin + POSITION_DELAY_MS + ramp_ms + 700)
        self.assertAlmostEqual(host.state(MOTOR).actual_rpm, rpm, delta=20)
        self.assertEqual(host.stage(MOTOR), Stage.FOC)

    def wait_for_tick(self, host, tick):
        return self.wait_for(
            f"tick {tick}", lambda: (s := host.state(MOTOR)).tick >= tick and s or None
        )

    def wait_for_stage(self, host, stage):
        self.wait_for(stage.name, lambda: host.stage(MOTOR) == stage)

    def assert_duration(self, times, stage, expected_ms):
        """Fails if what the host saw contradicts a duration, counted at the drive's 1 kHz tick."""
        shortest, longest = times.duration(stage)
        self.assertLessEqual(shortest, expected_ms + 1, stage.name)
        self.assertGreaterEqual(longest, expected_ms - 1, stage.name)

    def assert_refused(self, code, action):
        with self.assertRaises(mcu.ErrorAnswer) as caught:
            action()
        self.assertEqual(caught.exception.code, code)


class StageTimes:
    """When each stage was entered, as polls can tell: not before one tick, nor after another."""

    def __init__(self, host, begin):
        self.host = host
        self.begin = begin
        self.entered = []  # (stage, earliest, latest)

    def follow(self, last):
        """Polls until the motor is in stage `last`; the stages in the order they were seen."""
        still_before = self.begin
        while not self.entered or self.entered[-1][0] != last:
            before = self.host.state(MOTOR).tick
            stage = self.host.stage(MOTOR)
            after = self.host.state(MOTOR).tick
            if not self.entered or self.entered[-1][0] != stage:
                self.entered.append((stage, still_before, after))
            still_before = before
        return [stage for stage, _, _ in self.entered]

    def duration(self, stage):
        """Shortest and longest time in the stage that agree with what was seen."""
        for (here, earliest, latest), (_, next_earliest, next_latest) in itertools.pairwise(
            self.entered
        ):
            if here == stage:
                # A tick is rounded down: its instant lies up to 1 ms later.
                return next_earliest - latest - 1, next_latest - earliest + 1
        raise AssertionError(f"{stage.name} was not seen")


class Start(DriveTest):
    def test_the_port_answers_with_version_3_10(self):
        _, host = self.start_bench()
        self.assertEqual(host.version(), (3, 10))

    def test_the_stages_take_the_time_that_their_parameters_give(self):
        # Slowed down so that polls are dense; an ideal line so that they take no simulated time.
        _, host = self.start_bench("--rate", 0.1, "--line", "ideal")
        bootstrap_ms = 50  # instead of 10, for a busy machine to see it
        host.set(MOTOR, mcu.BOOTSTRAP_DELAY, bootstrap_ms)
        host.set(MOTOR, mcu.SPEED, 2000)
        times = StageTimes(host, host.state(MOTOR).tick)
        host.start(MOTOR)
        stages = times.follow(last=Stage.FOC)
        self.assertEqual(
            [stage for stage in stages if stage != Stage.ZERO_CURRENT_MEASURE],
            [Stage.BOOTSTRAP, Stage.INITPOSITION, Stage.FORCE, Stage.FOC],
        )
        self.assert_duration(times, Stage.BOOTSTRAP, bootstrap_ms)
        self.assert_duration(times, Stage.INITPOSITION, POSITION_DELAY_MS)
        self.assert_duration(times, Stage.FORCE, FORCE_MS)

    def test_a_host_sees_each_stage_when_time_is_slow_enough(self):
        # 0.32 ms of ZeroCurrentMeasure become 320 ms.
        _, host = self.start_bench("--rate", 0.001, "--line", "ideal", "--set", "BootstrapDelay=1")
        host.set(MOTOR, mcu.SPEED, 2000)
        host.start(MOTOR)
        stages = StageTimes(host, 0).follow(last=Stage.INITPOSITION)
        self.assertEqual(
            stages, [Stage.BOOTSTRAP, Stage.ZERO_CURRENT_MEASURE, Stage.INITPOSITION]
        )

    def test_a_recording_shows_each_stage_with_its_exact_duration(self):
        step_ms = 0.02
        bench = self.bench(
            "--start", 2000, "--rate", "max", "--duration", 1, "--interval", step_ms / 1000,
            "--record", self.path("stages.csv"), "--signals", "drive1.stage",
        )
        bench.report()
        stages = read_recording(self.path("stages.csv"))["drive1.stage"]
        runs = [(Stage(stage), len(list(rows))) for stage, rows in itertools.groupby(stages)]
        self.assertEqual(
            [stage for stage, _ in runs],
            [
                Stage.STOP,
                Stage.BOOTSTRAP,
                Stage.ZERO_CURRENT_MEASURE,
                Stage.INITPOSITION,
                Stage.FORCE,
                Stage.FOC,
            ],
        )
        # Milliseconds are counted at the drive's 1 kHz tick, periods at its PWM.
        for stage, expected_ms, tolerance_ms in (
            (Stage.BOOTSTRAP, BOOTSTRAP_MS, 1),
            (Stage.ZERO_CURRENT_MEASURE, ZERO_CURRENT_MS, 0.08 + step_ms),
            (Stage.INITPOSITION, POSITION_DELAY_MS, 1),
            (Stage.FORCE, FORCE_MS, 1 + step_ms),
        ):
            with self.subTest(stage.name):
                self.assertAlmostEqual(
                    dict(runs)[stage] * step_ms, expected_ms, delta=tolerance_ms + 1e-9
                )

    def test_counter_clockwise_speeds_are_negative(self):
        _, host = self.start_bench("--rate", 10)
        self.spin_up(host, -2000, acceleration=1500)
        state = host.state(MOTOR)
        self.assertEqual(state.target_rpm, -2000)
        self.assertGreater(state.current_ma, 0)

    def test_a_second_start_changes_nothing(self):
        _, host = self.start_bench("--rate", 10)
        self.spin_up(host, 2000, acceleration=1500)
        host.start(MOTOR)
        self.assertEqual(host.stage(MOTOR), Stage.FOC)
        self.assertAlmostEqual(host.state(MOTOR).actual_rpm, 2000, delta=20)

    def test_the_control_method_is_speed_while_running_and_none_while_idle(self):
        _, host = self.start_bench("--rate", 10)
        self.assertEqual(host.control_method(MOTOR), 0)
        self.assertEqual(host.extended_state(MOTOR).method, 0)
        self.spin_up(host, 2000, acceleration=1500)
        self.assertEqual(host.control_method(MOTOR), 1)
        state = host.extended_state(MOTOR)
        self.assertEqual((state.target, state.method), (2000, 1))
        # The field labelled Ncm, by the document's example: 34 mNm/A and 60 mA give 204.
        self.assertEqual(state.non_control, TORQUE_FACTOR * state.current_ma // 10)

    def test_the_motors_run_independently(self):
        _, host = self.start_bench("--rate", 10)
        self.spin_up(host, 2000, acceleration=1500)
        self.assertEqual([host.stage(0), host.stage(2)], [Stage.STOP, Stage.STOP])
        self.assertEqual(host.state(0)[:4], (0, 0, 0, 0))


class Ramp(DriveTest):
    def test_the_speed_rises_by_max_ang_acc(self):
        _, host = self.start_bench()
        for unit, value, rpm_per_s in (
            (mcu.RAD_BY_S2, MAX_ANG_ACC, RAMP_RPM_PER_S),
            (mcu.HZ_BY_S, 80, 80 * RPM_PER_HZ),
            (mcu.RPM_BY_S, 1000, 1000),
        ):
            with self.subTest(f"unit {unit}"):
                host.set(MOTOR, mcu.SHUTDOWN_MODE, mcu.DISABLE_OUTPUT)
                host.set(MOTOR, mcu.MAX_ANG_ACC, value, unit)
                host.set(MOTOR, mcu.SPEED, 2000)
                host.start(MOTOR)
                samples = []
                while (state := host.state(MOTOR)).actual_rpm < 1900:
                    if 1000 <= state.actual_rpm <= 1800:
                        samples.append((state.tick / 1000, state.actual_rpm))
                self.assertEqual(host.stage(MOTOR), Stage.FOC)
                host.stop(MOTOR)
                # The lurch at the change to FOC may cross 1000 rpm: from its last crossing on.
                crossing = max((i for i, (_, rpm) in enumerate(samples) if rpm < 1010), default=0)
                times, speeds = zip(*samples[crossing:])
                self.assertGreater(speeds[-1] - speeds[0], 400, "the host was too slow")
                self.assertGreater(len(speeds), 4, "the host was too slow")
                slope = statistics.linear_regression(times, speeds).slope
                self.assertAlmostEqual(slope, rpm_per_s, delta=0.02 * rpm_per_s)


class Load(DriveTest):
    LOAD_AT_MS = 5000

    def run_into(self, load):
        """Runs at 2000 rpm when the load comes; the state before."""
        load_step = f"brake:{load}mNm@{self.LOAD_AT_MS}ms"
        _, host = self.start_bench("--rate", 5, "--load", load_step)
        self.spin_up(host, 2000, acceleration=1500)
        before = host.state(MOTOR)
        self.assertLess(before.tick, self.LOAD_AT_MS, "the host was too slow")
        return host, before

    def test_the_current_rises_by_the_torque_of_the_load(self):
        host, before = self.run_into(load=20)
        after = self.wait_for_tick(host, self.LOAD_AT_MS + 2000)
        self.assertEqual(host.stage(MOTOR), Stage.FOC)
        self.assertEqual(host.errors(MOTOR), 0)
        self.assertAlmostEqual(after.actual_rpm, 2000, delta=20)
        expected_ma = 20 / TORQUE_FACTOR * 1000
        self.assertAlmostEqual(
            after.current_ma - before.current_ma, expected_ma, delta=0.05 * expected_ma
        )
        self.assertEqual(after.torque, TORQUE_FACTOR * after.current_ma // 10)

    def test_a_step_beyond_what_the_estimator_follows_stalls_the_motor(self):
        host, _ = self.run_into(load=30)
        host.set(MOTOR, mcu.RESTART_MODE, 0)
        self.wait_for_stage(host, Stage.STOP)
        self.assertEqual(host.errors(MOTOR), mcu.STALL_ERROR)


class Shutdown(DriveTest):
    """Each ShutdownMode, as the host sees it and as the rotor does."""

    def run_down(self, mode, *options, braketime=2, deceleration=1500):
        """Stops a motor at 2000 rpm; the bench, its host, and what will tell the stages' times."""
        bench, host = self.start_bench(
            "--record", self.path("stop.csv"), "--signals", "motor1.speed,drive1.stage", *options
        )
        host.set(MOTOR, mcu.SHUTDOWN_MODE, mode)
        host.set(MOTOR, mcu.BRAKETIME, braketime)
        self.spin_up(host, 2000, acceleration=1500)
        host.set(MOTOR, mcu.MAX_ANG_ACC, deceleration)
        times = StageTimes(host, host.state(MOTOR).tick)
        host.stop(MOTOR)
        return bench, host, times

    def time_to_stand_still(self, bench):
        """Milliseconds from leaving FOC until the rotor turns slower than 20 rpm."""
        bench.stop()
        recording = read_recording(self.path("stop.csv"))
        stages = recording["drive1.stage"]
        left = max(i for i, stage in enumerate(stages) if stage == Stage.FOC)
        speeds = recording["motor1.speed[rpm]"][left:]
        return next(i for i, rpm in enumerate(speeds) if abs(rpm) < 20)

    def test_mode_0_switches_off_at_once_and_the_rotor_coasts(self):
        bench, host, _ = self.run_down(mcu.DISABLE_OUTPUT, "--rate", 5)
        self.assertEqual(host.stage(MOTOR), Stage.STOP)
        self.assertEqual(host.state(MOTOR)[:4], (0, 0, 0, 0))
        tick = host.state(MOTOR).tick
        self.wait_for_tick(host, tick + 500)
        # 209 rad/s, 2.4e-6 kg m2, 3 mNm of friction and a little viscous: 0.14 .. 0.17 s.
        self.assertTrue(130 < self.time_to_stand_still(bench) < 175)

    def test_mode_1_brakes_for_braketime_and_stops(self):
        bench, host, times = self.run_down(
            mcu.SHORT_BRAKE, "--rate", 1, "--line", "ideal", braketime=300
        )
        self.assertEqual(times.follow(last=Stage.STOP), [Stage.BRAKE, Stage.STOP])
        self.assert_duration(times, Stage.BRAKE, 300)
        # Shorted windings take 90 mNm out of the rotor at 2000 rpm.
        self.assertLess(self.time_to_stand_still(bench), 50)

    def test_mode_2_ramps_down_through_foc_and_force(self):
        _, host, times = self.run_down(mcu.GENTLE, deceleration=MAX_ANG_ACC)
        self.assertEqual(host.state(MOTOR).target_rpm, 0)
        stages = times.follow(last=Stage.STOP)
        self.assertEqual(stages, [Stage.FOC, Stage.FORCE, Stage.STOP])
        self.assertEqual(host.errors(MOTOR), 0)
        # From 2000 to 356 rpm, where FOC ends: 95 % of SpeedChange.
        expected_ms = (2000 - 0.95 * SPEED_CHANGE_HZ * RPM_PER_HZ) / RAMP_RPM_PER_S * 1000
        self.assert_duration(times, Stage.FOC, expected_ms)

    def test_the_set_speed_is_gone_after_a_gentle_stop(self):
        _, host, times = self.run_down(mcu.GENTLE, "--rate", 10)
        times.follow(last=Stage.STOP)
        host.start(MOTOR)
        self.wait_for_stage(host, Stage.FORCE)
        self.wait_for_tick(host, host.state(MOTOR).tick + 1000)
        self.assertEqual(host.stage(MOTOR), Stage.FORCE)
        self.assertEqual(host.state(MOTOR)[:2], (0, 0))

    def test_a_start_during_the_ramp_restores_the_speed(self):
        _, host, _ = self.run_down(mcu.GENTLE, deceleration=MAX_ANG_ACC)
        host.start(MOTOR)
        self.assertEqual(host.state(MOTOR).target_rpm, 2000)
        self.wait_for_tick(host, host.state(MOTOR).tick + 2000)
        self.assertAlmostEqual(host.state(MOTOR).actual_rpm, 2000, delta=20)

    def test_a_motor_that_does_not_run_cannot_be_stopped(self):
        _, host = self.start_bench()
        self.assertEqual(host.exchange(mcu.telegram(mcu.STOP_MOTOR, [MOTOR]), 5), REFUSED)


class Faults(DriveTest):
    def test_an_emergency_is_left_by_a_stop_only(self):
        _, host = self.start_bench("--rate", 10)
        host.set(MOTOR, mcu.SW_UNDERVOLTAGE, 30)  # the bus has 24 V
        host.set(MOTOR, mcu.SPEED, 2000)
        host.start(MOTOR)
        self.wait_for_stage(host, Stage.EMERGENCY)
        self.assertEqual(host.errors(MOTOR), mcu.SW_UNDERVOLTAGE_ERROR)
        self.assertEqual(host.state(MOTOR)[:4], (0, 0, 0, 0))
        self.assert_refused(-2, lambda: host.start(MOTOR))
        host.stop(MOTOR)
        self.assertEqual((host.stage(MOTOR), host.errors(MOTOR)), (Stage.STOP, 0))

    def test_a_speed_against_direction_is_taken_as_0_with_a_warning(self):
        _, host = self.start_bench("--rate", 10)
        host.set(MOTOR, mcu.DIRECTION, 0)  # clockwise only
        host.start(MOTOR)
        host.set(MOTOR, mcu.SPEED, -500)
        self.assertEqual(host.errors(MOTOR), mcu.WRONG_DIRECTION_ERROR)
        self.assertEqual(host.state(MOTOR).target_rpm, 0)
        host.set(MOTOR, mcu.SPEED, 500)
        self.assertEqual(host.errors(MOTOR), 0)

    def test_a_speed_beyond_the_limit_is_clipped(self):
        _, host = self.start_bench("--rate", 10)
        host.start(MOTOR)
        host.set(MOTOR, mcu.SPEED, 100000)
        self.assertEqual(host.state(MOTOR).target_rpm, 350 * RPM_PER_HZ)


class Telegrams(DriveTest):
    """What the drive makes of bytes that are not as they should be."""

    def assert_silent(self, host, data):
        host.send(data)
        self.assertEqual(host.listen(SILENCE_S), b"")

    def assert_answers(self, host):
        self.assertEqual(host.exchange(VERSION_REQUEST, len(VERSION_ANSWER)), VERSION_ANSWER)

    def bring_back(self, host, tries):
        """Repeats a request, as a host does that got no answer, until it is answered."""
        for _ in range(tries):
            host.send(VERSION_REQUEST)
            if host.listen(PATIENCE_S, last=VERSION_ANSWER).endswith(VERSION_ANSWER):
                return
        self.fail("the drive is lost")

    def test_a_wrong_crc_is_answered_with_error_1(self):
        bench, host = self.start_bench()
        self.assertEqual(host.exchange(bytes.fromhex("11 00 01 06 13"), 5), CRC_ERROR)
        self.assertEqual(host.stage(MOTOR), Stage.STOP)
        self.assertEqual(bench.stop()["bad_frames"], 1)

    def test_an_unknown_command_is_not_answered_and_does_not_harm_the_next(self):
        _, host = self.start_bench()
        for command in (0x15, 0x20, 0x24, 0x7F, 0xEE, 0xFF):
            with self.subTest(f"{command:02x}"):
                self.assert_silent(host, mcu.telegram(command, [1]))
                self.assert_answers(host)

    def test_bytes_between_telegrams_are_ignored(self):
        _, host = self.start_bench()
        garbage = bytes(byte for byte in range(256) if byte != mcu.BOT)
        self.assert_silent(host, garbage)
        self.assert_answers(host)
        self.assertEqual(host.exchange(garbage + VERSION_REQUEST, 6), VERSION_ANSWER)

    def test_a_wrong_end_byte_is_not_answered(self):
        _, host = self.start_bench()
        self.assert_silent(host, bytes.fromhex("11 00 01 07 12"))
        self.assert_answers(host)
        self.assertEqual(host.stage(MOTOR), Stage.STOP)

    def test_flow_control_characters_are_data(self):
        # 0x11 and 0x13 are XON and XOFF, and each control character means something to a terminal.
        _, host = self.start_bench()
        for value in (0x11, 0x13, 0x11131113, 0x03040D0A, 0x1A1C157F):
            with self.subTest(f"{value:x}"):
                host.set(MOTOR, 0x35, value)  # EncoderMaxPos holds any 32 bits
                self.assertEqual(host.get(MOTOR, 0x35), (value, 0))

    def test_a_cut_telegram_swallows_the_next_and_its_crc_error_brings_both_back(self):
        bench, host = self.start_bench()
        cut = mcu.telegram(mcu.SET_ONE, bytes.fromhex("01 e5 00 d0 07 00 00"))[:6]
        self.assert_silent(host, cut)
        self.assertEqual(host.exchange(VERSION_REQUEST, 5), CRC_ERROR)
        self.assert_answers(host)
        self.assertEqual(bench.stop()["bad_frames"], 1)

    def test_wherever_a_telegram_is_cut_repeating_the_request_brings_the_drive_back(self):
        _, host = self.start_bench()
        whole = mcu.telegram(mcu.SET_ONE, bytes.fromhex("01 e5 00 d0 07 00 00"))
        for length in range(1, len(whole)):
            with self.subTest(length):
                host.send(whole[:length])
                # Two requests fill what is missing, and the rest of one may begin another telegram.
                self.bring_back(host, tries=5)

    def test_the_drive_waits_for_ever_for_the_rest_of_a_telegram(self):
        # Ten times the 100 ms after which a lenient drive gives up.
        _, host = self.start_bench("--rate", 10)
        host.send(VERSION_REQUEST[:2])
        self.assertEqual(host.listen(SILENCE_S), b"")
        self.assertEqual(host.exchange(VERSION_REQUEST[2:], 6), VERSION_ANSWER)

    def test_a_lenient_drive_gives_a_cut_telegram_up_after_a_silence(self):
        bench, host = self.start_bench("--rate", 10, "--lenient")
        host.send(VERSION_REQUEST[:2])
        self.assertEqual(host.listen(PATIENCE_S), b"")  # 3 s of the drive's
        self.assert_answers(host)
        self.assertEqual(bench.stop()["bad_frames"], 1)

    def test_bytes_sent_while_the_drive_is_busy_are_lost_and_counted(self):
        bench, host = self.start_bench()
        self.assertEqual(host.exchange(VERSION_REQUEST * 2, 6), VERSION_ANSWER)
        self.assertEqual(host.listen(SILENCE_S), b"")
        # The UART's register kept one byte, 0x11: the next request is read from the wrong start.
        self.bring_back(host, tries=2)
        report = bench.stop()
        self.assertEqual(report["bytes_lost_busy"], len(VERSION_REQUEST) - 1)
        self.assertEqual(report["requests"], report["replies"])

    def test_a_lenient_drive_keeps_what_comes_while_it_is_busy(self):
        bench, host = self.start_bench("--lenient")
        self.assertEqual(host.exchange(VERSION_REQUEST * 20, 6 * 20), VERSION_ANSWER * 20)
        report = bench.stop()
        self.assertEqual((report["bytes_lost_busy"], report["requests"]), (0, 20))

    def test_a_host_at_another_baud_rate_gets_no_valid_answer_and_is_counted(self):
        bench = self.bench()
        for baud in (9600, 57600, 230400):
            with self.subTest(baud), self.open(bench, baud) as host:
                for _ in range(3):
                    host.send(VERSION_REQUEST)
                    self.assertNotIn(VERSION_ANSWER, host.listen(SILENCE_S))
        with self.open(bench) as host:
            # Whatever was heard may have begun a telegram; 0C is the longest, 54 bytes.
            self.bring_back(host, tries=54 // len(VERSION_REQUEST) + 2)
        # What was sent at those rates; the last of each may be read after the rate has changed.
        self.assertGreaterEqual(bench.stop()["bytes_garbled"], 3 * 2 * len(VERSION_REQUEST))

    def test_a_bench_at_another_baud_rate_serves_a_host_at_that_rate(self):
        bench = self.bench("--baud", 9600)
        with self.open(bench, 9600) as host:
            self.assertEqual(host.version(), (3, 10))
        self.assertEqual(bench.stop()["bytes_garbled"], 0)


class Parameters(DriveTest):
    def assert_error_ff(self, host, request):
        self.assertEqual(host.exchange(request, len(REFUSED)), REFUSED)

    def set_request(self, motor, parameter, value, unit=0):
        payload = bytes([motor, parameter, unit & 0xFF]) + value.to_bytes(4, "little", signed=True)
        return mcu.telegram(mcu.SET_ONE, payload)

    def get_request(self, motor, parameter):
        return mcu.telegram(mcu.GET_ONE, [motor, parameter, 0])

    def test_read_only_parameters_cannot_be_written(self):
        _, host = self.start_bench()
        for parameter in (0x90, 0x91, 0x92, 0x93, 0x94, 0x95, 0xB0, 0xB2, 0xE0, 0xE2, 0xE3):
            before = host.get(MOTOR, parameter).value
            with self.subTest(f"{parameter:02x}"):
                self.assert_error_ff(host, self.set_request(MOTOR, parameter, before + 1))
                after = host.get(MOTOR, parameter).value
                # The bus voltage is measured, noise and all.
                self.assertAlmostEqual(after, before, delta=1 if parameter == 0xE2 else 0)

    def test_write_only_parameters_cannot_be_read(self):
        _, host = self.start_bench()
        self.assert_error_ff(host, self.get_request(MOTOR, mcu.SPEED))

    def test_unknown_parameters_are_refused(self):
        _, host = self.start_bench()
        for parameter in (0x00, 0x0F, 0x1E, 0x38, 0x48, 0x5D, 0x79, 0x99, 0xB3, 0xE7, 0xFF):
            with self.subTest(f"{parameter:02x}"):
                self.assert_error_ff(host, self.get_request(MOTOR, parameter))
                self.assert_error_ff(host, self.set_request(MOTOR, parameter, 1))

    def test_values_out_of_range_and_unknown_units_are_refused(self):
        _, host = self.start_bench()
        for parameter, value, unit in (
            (mcu.POLE_PAIRS, 0, 0),
            (mcu.POLE_PAIRS, 101, 0),
            (mcu.POLE_PAIRS, -1, 0),
            (mcu.MAX_ANG_ACC, 0, 0),
            (mcu.MAX_ANG_ACC, 10001, 0),
            (mcu.MAX_ANG_ACC, 100, 4),
            (mcu.IQ_START, 1000, -6),
            (0x17, 352, 0),  # SpeedChange above SpeedLimit + 1, in Hz
            (0x17, 5280, 1),  # the same in rpm
            (mcu.SHUTDOWN_MODE, 3, 0),
            (0x75, 4, 0),
        ):
            before = host.get(MOTOR, parameter)
            with self.subTest(f"{parameter:02x} = {value} unit {unit}"):
                self.assert_error_ff(host, self.set_request(MOTOR, parameter, value, unit))
                self.assertEqual(host.get(MOTOR, parameter), before)

    def test_range_limits_themselves_are_taken_and_returned_as_written(self):
        _, host = self.start_bench()
        for parameter, value, unit in (
            (mcu.POLE_PAIRS, 1, 0),
            (mcu.POLE_PAIRS, 100, 0),
            (mcu.MAX_ANG_ACC, 10000, mcu.RPM_BY_MIN),
            (mcu.IQ_START, 1, 0),
            (0x17, 351, 0),
            (0x35, -1, 0),  # 4294967295 as the wire's int32
            (0x56, -40, 0),
            (0x5C, 100, 0),
        ):
            with self.subTest(f"{parameter:02x} = {value} unit {unit}"):
                host.set(MOTOR, parameter, value, unit)
                self.assertEqual(host.get(MOTOR, parameter), (value, unit))

    def test_channels_that_are_not_there_are_refused(self):
        _, host = self.start_bench()
        for motor in (3, 7, 0x80, 0xFE):
            with self.subTest(motor):
                for command in (mcu.START_MOTOR, mcu.STOP_MOTOR, mcu.GET_MOTOR_STATE,
                                mcu.GET_CONTROL_METHOD, mcu.GET_EXTENDED_STATE):
                    self.assert_error_ff(host, mcu.telegram(command, [motor]))
                self.assert_error_ff(host, self.get_request(motor, mcu.POLE_PAIRS))
                self.assert_error_ff(host, self.set_request(motor, mcu.POLE_PAIRS, 5))

    def test_the_system_is_asked_with_minus_1_and_motors_are_not(self):
        _, host = self.start_bench()
        self.assertEqual(host.get(mcu.ALL_MOTORS, 0x50), (12500, 0))  # PwmFrequency
        self.assert_error_ff(host, self.get_request(mcu.ALL_MOTORS, mcu.POLE_PAIRS))
        self.assert_error_ff(host, self.get_request(mcu.ALL_MOTORS, mcu.MOTOR_STAGE))
        self.assert_error_ff(host, self.set_request(mcu.ALL_MOTORS, 0x50, 16000))
        self.assert_error_ff(host, mcu.telegram(mcu.START_MOTOR, [mcu.ALL_MOTORS]))

    def test_a_setting_that_nothing_acts_on_is_kept_and_noted_once(self):
        bench, host = self.start_bench()
        for value in (3, 5):
            host.set(MOTOR, 0x57, value)  # CanId: there is no CAN
        self.assertEqual(host.get(MOTOR, 0x57), (5, 0))
        host.set(MOTOR, mcu.POLE_PAIRS, 4)
        bench.stop()
        self.assertEqual(len(bench.notes), 1, bench.notes)
        self.assertIn("CanId is stored", bench.notes[0])

    def test_a_parameter_is_kept_per_motor(self):
        _, host = self.start_bench()
        host.set(0, mcu.POLE_PAIRS, 7)
        self.assertEqual([host.get(m, mcu.POLE_PAIRS).value for m in (0, 1, 2)], [7, 4, 4])

    def test_several_parameters_stop_at_the_first_that_is_refused(self):
        _, host = self.start_bench()
        entries = [(mcu.POLE_PAIRS, 5, 0), (mcu.MAX_ANG_ACC, 400, 0), (mcu.SHUTDOWN_MODE, 9, 0),
                   (mcu.BRAKETIME, 50, 0)]
        self.assertEqual(host.set_many(MOTOR, entries), (1, 2))
        parameters = [parameter for parameter, _, _ in entries]
        error, offset, slots = host.get_many(MOTOR, parameters)
        self.assertEqual((error, offset), (0, 0))
        self.assertEqual([slot.value for slot in slots], [5, 400, 2, 2, 0, 0, 0, 0])
        error, offset, slots = host.get_many(MOTOR, [mcu.POLE_PAIRS, mcu.SPEED, mcu.BRAKETIME])
        self.assertEqual((error, offset), (1, 1))
        self.assertEqual(slots, [(5, 0)] + [(0, 0)] * 7)

    def test_commands_of_features_that_are_switched_off_are_refused(self):
        _, host = self.start_bench()
        features = host.get(mcu.ALL_MOTORS, 0x90).value
        for bit, request in (
            (0, mcu.telegram(0x05, bytes(13))),  # DSO
            (0, mcu.telegram(0x06, [0])),
            (2, mcu.telegram(0x08, bytes.fromhex("01 f4 01 e8 03"))),  # turn control
            (13, mcu.telegram(0x0D, bytes.fromhex("00 64 00 00 00 64 00"))),  # motion control
            (13, mcu.telegram(0x0E, [0])),
            (16, mcu.telegram(0x22, [0])),  # demo
            (17, mcu.telegram(0x10, [1])),  # torque control
        ):
            if not features >> bit & 1:
                with self.subTest(request.hex(" ")):
                    self.assert_error_ff(host, request)


class Memory(DriveTest):
    """What is stored outlives the program, with a file; without one it does not."""

    def test_stored_parameters_are_there_after_a_kill(self):
        bench, host = self.start_bench("--nvm", self.path("drive.nvm"))
        host.set(MOTOR, mcu.MAX_ANG_ACC, 800)
        host.store(MOTOR)
        host.set(MOTOR, mcu.MAX_ANG_ACC, 900)
        host.close()
        bench.process.kill()
        bench.process.wait()
        _, host = self.start_bench("--nvm", self.path("drive.nvm"))
        self.assertEqual(host.get(MOTOR, mcu.MAX_ANG_ACC).value, 800)
        self.assertEqual(host.get(0, mcu.MAX_ANG_ACC).value, MAX_ANG_ACC)
        host.clear()
        self.assertEqual(host.get(MOTOR, mcu.MAX_ANG_ACC).value, 800)

    def test_without_a_file_nothing_is_kept(self):
        bench, host = self.start_bench()
        host.set(MOTOR, mcu.MAX_ANG_ACC, 800)
        host.store(MOTOR)
        host.close()
        bench.stop()
        self.assertEqual(self.files(), [])

    def test_a_damaged_file_is_told_and_the_drive_starts_with_factory_settings(self):
        file = self.path("drive.nvm")
        bench, host = self.start_bench("--nvm", file)
        host.set(MOTOR, mcu.MAX_ANG_ACC, 800)
        host.store(MOTOR)
        host.close()
        bench.stop()
        with open(file, "r+b") as damaged:
            damaged.truncate(100)
        bench, host = self.start_bench("--nvm", file)
        self.assertEqual(host.get(MOTOR, mcu.MAX_ANG_ACC).value, MAX_ANG_ACC)
        host.close()
        bench.stop()
        self.assertIn("drive.nvm is damaged", bench.notes[0])


class TorqueControl(DriveTest):
    def test_the_torque_is_held_and_told(self):
        _, host = self.start_bench("--rate", 10, "--load", "quadratic:6e-7,inertia:2e-5")
        host.set(MOTOR, mcu.SPEED, 4000)
        host.set(MOTOR, mcu.TORQUE, 30)
        host.start_torque(MOTOR)
        begin = host.state(MOTOR).tick
        self.wait_for_tick(host, begin + 6000)
        self.assertEqual(host.control_method(MOTOR), 2)
        state = host.extended_state(MOTOR)
        self.assertEqual((state.target, state.method), (3000, 2))  # 30 mNm in 0.001 Ncm
        self.assertAlmostEqual(state.actual, 3000, delta=60)
        self.assertAlmostEqual(state.non_control, 1990, delta=80)  # rpm, where the fan takes it

    def test_methods_that_do_not_exist_are_invalid(self):
        _, host = self.start_bench()
        self.assertEqual([host.set_control_method(MOTOR, m) for m in (0, 1, 2, 3)], [1, 0, 0, 1])
        self.assertEqual(host.control_method(MOTOR), 0)


class Session(DriveTest):
    """Hosts come and go, the drive stays."""

    def test_the_motor_turns_on_while_the_port_is_closed(self):
        bench, host = self.start_bench("--rate", 5)
        host.set(MOTOR, mcu.SPEED, 2000)
        host.start(MOTOR)
        self.wait_for_stage(host, Stage.FOC)
        before = host.state(MOTOR)
        host.close()
        host = self.open(bench)
        self.assertEqual(host.stage(MOTOR), Stage.FOC)
        after = self.wait_for_tick(host, before.tick + 3500)
        self.assertEqual(after.target_rpm, 2000)
        self.assertAlmostEqual(after.actual_rpm, 2000, delta=20)

    def test_an_answer_that_was_not_read_does_not_reach_the_next_host(self):
        bench, host = self.start_bench()
        for _ in range(5):
            host.send(mcu.telegram(mcu.GET_MOTOR_STATE, [MOTOR]))
            self.wait_for("the answer", lambda: host.port.in_waiting == 24)
            host.close()
            host = self.open(bench)
            self.assertEqual(host.listen(SILENCE_S), b"")
            self.assertEqual(host.version(), (3, 10))

    def test_a_host_may_come_again_and_again(self):
        bench = self.bench()
        for _ in range(50):
            with self.open(bench) as host:
                self.assertEqual(host.version(), (3, 10))
        self.assertEqual(bench.stop()["requests"], 50)

    def test_a_host_that_asks_for_even_parity_can_come_again_and_again(self):
        # The kernel drops PARENB from a pseudo-terminal, and glibc takes that for a failure.
        bench = self.bench()
        for _ in range(50):
            with Host(bench.link, parity="E") as host:
                self.assertEqual(host.version(), (3, 10))
        self.assertEqual(bench.stop()["requests"], 50)


class GoldenVectors(DriveTest):
    """The document's own frames, and frames computed from it, byte for byte on a fresh drive."""

    def setUp(self):
        super().setUp()
        self.frames = {}
        with open(TEST_DATA / "vectors_toshiba_mcu.csv", newline="") as file:
            for row in csv.DictReader(file):
                self.frames[row["name"], row["direction"]] = bytes.fromhex(row["hex"])

    def request(self, name):
        return self.frames[name, "request"]

    def response(self, name):
        return self.frames[name, "response"]

    def test_our_own_encoder_makes_the_documents_frames(self):
        invalid = ("_badcrc", "_badeot", "_truncated", "_as_printed", "HsDSO_frame")
        checked = 0
        for (name, direction), frame in self.frames.items():
            if not any(mark in name for mark in invalid):
                with self.subTest(f"{name} {direction}"):
                    self.assertEqual(mcu.telegram(frame[1], frame[2:-2]), frame)
                    checked += 1
        self.assertGreater(checked, 100)

    def replay(self, host, pairs):
        for request, response in pairs:
            with self.subTest(request):
                wanted = self.response(response)
                self.assertEqual(host.exchange(self.request(request), len(wanted)), wanted)

    def test_questions_to_a_fresh_drive(self):
        _, host = self.start_bench()
        self.replay(
            host,
            [
                ("09_GetOne_ResetStatus", "09_GetOne_ResetStatus_1st"),
                ("09_GetOne_ResetStatus", "09_GetOne_ResetStatus_2nd"),
                ("14_GetFWVersion_dummy00", "14_GetFWVersion_3_10"),
                ("14_GetFWVersion_dummyFF", "14_GetFWVersion_3_10"),
                ("09_GetOneMotorParameter", "09_GetOneMotorParameter"),
                ("09_GetOne_ErrorState_ch1", "09_GetOneMotorParameter"),
                ("09_GetOne_Channels", "09_GetOne_Channels_012"),
                ("09_GetOne_DsoSize", "09_GetOne_DsoSize_320"),
                ("09_GetOne_ParameterTransferCount", "09_GetOne_ParameterTransferCount_8"),
                ("09_GetOne_FirmwareVersion", "09_GetOne_FirmwareVersion_3_10"),
                ("09_GetOne_Temperature", "09_GetOne_Temperature_25"),
                ("09_GetOne_DcLinkVoltage_ch1", "09_GetOne_DcLinkVoltage_24V0"),
                ("09_GetOne_MotorId_off0", "09_GetOne_MotorId_off0"),
                ("09_GetOne_MotorId_off4", "09_GetOne_MotorId_off4"),
                ("09_GetOne_MotorId_off8", "09_GetOne_MotorId_off8"),
                ("09_GetOne_MotorId_off12", "09_GetOne_MotorId_off12"),
                ("09_GetOne_MotorId_off16", "09_GetOne_MotorId_off16"),
                ("0B_GetMotorParameters", "0B_GetMotorParameters"),
                ("0B_GetMotorParameters_1used", "0B_GetMotorParameters_1used"),
                ("11_GetMotorControlMethod", "11_GetMotorControlMethod_idle"),
            ],
        )

    def test_orders_to_a_fresh_drive(self):
        _, host = self.start_bench()
        self.replay(
            host,
            [
                ("01_StopMotor", "EE_Error_minus1"),
                ("01_StopMotor_ch0", "EE_Error_minus1"),
                ("0A_SetOneMotorParameter", "0A_SetOneMotorParameter"),
                ("00_StartMotor", "00_StartMotor"),
                ("01_StopMotor", "01_StopMotor"),
                ("00_StartMotor_ch0", "00_StartMotor"),
                ("01_StopMotor_ch0", "01_StopMotor"),
                ("00_StartMotor_ch2", "00_StartMotor"),
                ("11_GetMotorControlMethod", "11_GetMotorControlMethod"),
                ("01_StopMotor_ch2", "01_StopMotor"),
                ("0A_SetOne_Speed_minus500", "0A_SetOneMotorParameter"),
                ("0A_SetOne_SpeedLimit_6000rpm", "0A_SetOneMotorParameter"),
                ("0C_SetMotorParameters", "0C_SetMotorParameters"),
                ("0A_SetOne_PolePairs_0_invalid", "EE_Error_minus1"),
                ("0A_SetOne_FirmwareFeatures_ro", "EE_Error_minus1"),
                ("09_GetOne_Speed_wo", "EE_Error_minus1"),
                ("00_StartMotor_badcrc", "EE_Error_crc"),
            ],
        )
        self.assertEqual(host.get(MOTOR, mcu.IQ_START), (2000, mcu.MAMPERE))
        self.assertEqual(host.get(MOTOR, 0x16), (6000, 1))

    def test_states_of_a_motor_that_stands_but_for_the_time_stamp(self):
        _, host = self.start_bench()
        for request, response in (
            ("02_GetMotorState", "02_GetMotorState_stopped"),
            ("02_GetMotorState_ch0", "02_GetMotorState_stopped"),
            ("23_GetExtendedMotorState", "23_GetExtendedMotorState_idle"),
        ):
            with self.subTest(request):
                wanted = self.response(response)
                got = host.exchange(self.request(request), len(wanted))
                tick = slice(18, 22)
                payload = wanted[2:18] + got[tick] + wanted[22:-2]
                self.assertEqual(got, mcu.telegram(wanted[1], payload))

    def test_frames_that_must_not_be_answered(self):
        _, host = self.start_bench()
        for request in ("7F_unknown_cmd", "00_StartMotor_badeot"):
            with self.subTest(request):
                host.send(self.request(request))
                self.assertEqual(host.listen(SILENCE_S), b"")
                self.assertEqual(host.version(), (3, 10))
        host.send(self.request("00_StartMotor_truncated"))
        self.assertEqual(host.listen(SILENCE_S), b"")


if __name__ == "__main__":
    unittest.main()
