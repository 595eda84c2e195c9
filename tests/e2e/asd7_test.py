"""The 7-Series drives over real pseudo-terminals: a pump's host in ASCII, and mbpoll over Modbus.

VIRTDRIVE_PUMP_S is how long the pump runs (4 s).
"""

import os
import re
import sys
import time
import unittest

import asd7
from program import PROGRAM, ProgramTest

PUMP_S = float(os.environ.get("VIRTDRIVE_PUMP_S", "4"))
# The torque of a pump that asks for the rated one at the rated speed of the 0.75 kW motor.
PUMP = "quadratic:1.28e-4,inertia:0.01"


class DriveTest(ProgramTest):
    deadline_s = 60 + PUMP_S


class Pump(DriveTest):
    def test_a_host_polls_a_pump_and_reconnects_now_and_then(self):
        bench = self.bench("--load", PUMP, "--set", "ACC=2s", "--set", "DEC=2s", drive="asd7")
        with asd7.Host(bench.link) as host:
            self.assertEqual(host.read(asd7.ACC), 20)
            host.store(asd7.TIME_OUT, 3)
            host.run_at(50)
        end = time.monotonic() + PUMP_S
        polls = 0
        while time.monotonic() < end:
            with asd7.Host(bench.link) as host:  # a new connection each second
                until = min(end, time.monotonic() + 1)
                while time.monotonic() < until:
                    frequency = host.read(asd7.OUTPUT_FREQUENCY)
                    current = host.read(asd7.OUTPUT_CURRENT)
                    status = host.read(asd7.STATUS)
                    self.assertTrue(status & asd7.RUNNING, hex(status))
                    self.assertFalse(status & asd7.TRIPPED, hex(status))
                    self.assertLess(current, 15000)
                    polls += 1
        self.assertEqual(frequency, 5000)
        self.assertGreater(current, 3000)
        self.assertGreater(polls, 2 * PUMP_S)
        with asd7.Host(bench.link) as host:
            host.stop()
            self.wait_for("standstill", lambda: host.read(asd7.STATUS) == asd7.READY)
            self.assertEqual(host.read(asd7.TRIP), 0)
        report = bench.stop()
        self.assertEqual((report["bad_frames"], report["bytes_lost_busy"]), (0, 0))
        self.assertEqual(report["bytes_garbled"], 0)

    def test_a_host_that_falls_silent_finds_a_time_out_and_resets_it(self):
        bench = self.bench(drive="asd7")
        with asd7.Host(bench.link) as host:
            host.run_at(30)
            host.write(asd7.TIME_OUT, 1)
            time.sleep(1.5)
            self.assertEqual(host.read(asd7.TRIP), 0x18)
            self.assertTrue(host.tripped)
            host.port.timeout = 0.2
            with self.assertRaises(asd7.NoAnswer):
                host.write(asd7.COMMAND, asd7.RESET)
            with self.assertRaises(asd7.NoAnswer):
                host.read(asd7.TRIP)
            time.sleep(2.2)
            host.port.timeout = 10
            self.assertEqual(host.read(asd7.TRIP), 0)
            self.assertFalse(host.tripped)


class Binary(DriveTest):
    def test_sixteen_and_thirty_two_bits_agree(self):
        bench = self.bench(drive="asd7-4kw")
        with asd7.Host(bench.link) as host:
            for wide in (False, True):
                request = asd7.binary_frame("R", asd7.ACC, wide=wide)
                host.port.write(request)
                expected = asd7.binary_frame("R", asd7.ACC, 100, wide=wide)
                self.assertEqual(host.port.read(len(expected)), expected)


class Parity(DriveTest):
    def ask(self, address, parity, patience_s=0.4):
        with asd7.Host(address, patience_s=patience_s, parity=parity) as host:
            return host.read(asd7.ACC)

    def test_over_rfc_2217_only_even_parity_is_understood(self):
        bench = self.bench("--rfc2217", "0", link=None, drive="asd7")
        address = bench.ready["port"]
        self.assertEqual(self.ask(address, "E", 10), 100)
        for parity in "NO":
            with self.assertRaises(asd7.NoAnswer):
                self.ask(address, parity)
        self.assertEqual(self.ask(address, "E", 10), 100)


class Modbus(DriveTest):
    def poll(self, bench, register, *values):
        """Reads a register, or writes it; by its communication number, mbpoll counts from 1."""
        result = self.run_command(
            ["mbpoll", "-m", "rtu", "-a", "1", "-b", "9600", "-P", "even", "-1", "-o", "2",
             "-r", register + 1, *([] if values else ["-c", "1"]), bench.link, *values]
        )
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        found = re.search(rf"\[{register + 1}\]:\s+(\d+)", result.stdout)
        return int(found[1]) if found else None

    def test_mbpoll_runs_a_motor_and_reads_what_the_own_protocol_reads(self):
        bench = self.bench("--load", PUMP, "--set", "ACC=1s", drive="asd7-modbus")
        self.assertEqual(self.poll(bench, asd7.ACC), 10)
        self.poll(bench, asd7.FREQUENCY, 4000)
        self.poll(bench, asd7.COMMAND, asd7.PRIORITIES | asd7.RUN)
        self.wait_for("40 Hz", lambda: self.poll(bench, asd7.OUTPUT_FREQUENCY) == 4000)
        self.assertTrue(self.poll(bench, asd7.STATUS) & asd7.RUNNING)
        time.sleep(0.5)  # until the load has settled
        modbus = self.poll(bench, asd7.OUTPUT_CURRENT)
        other = self.bench("--load", PUMP, "--set", "ACC=1s", link="own", drive="asd7")
        with asd7.Host(other.link) as host:
            host.run_at(40)
            self.wait_for("40 Hz", lambda: host.read(asd7.OUTPUT_FREQUENCY) == 4000)
            self.wait_for(
                "the same current",
                lambda: abs(host.read(asd7.OUTPUT_CURRENT) - modbus) < 0.05 * modbus,
            )

    def test_mbpoll_is_told_that_a_register_is_not_there(self):
        bench = self.bench(drive="asd7-modbus")
        result = self.run_command(
            ["mbpoll", "-m", "rtu", "-a", "1", "-b", "9600", "-P", "even", "-1", "-o", "2",
             "-r", "3", "-c", "1", bench.link]
        )
        self.assertIn("Illegal data address", result.stdout + result.stderr)


class Line(DriveTest):
    def test_a_host_program_starts_eight_drives_with_one_frame(self):
        drives = "\n".join(
            f"    - {{name: pump{n}, drive: asd7, load: {{quadratic: 1.28e-4 Nm/(rad/s)^2}}, "
            f"set: {{F802: {n}, ACC: 1 s}}}}"
            for n in range(8)
        )
        scenario = self.folder / "eight.yaml"
        program = f"/usr/bin/python3 -B {os.path.abspath(__file__)} --broadcast {{port}}"
        scenario.write_text(
            "virtdrive-scenario: 1\nname: eight\nbench:\n  lines:\n    - {name: line}\n"
            f"  drives:\n{drives}\nsteps:\n  - host: {program}\n    timeout: 50 s\n"
            "    output: all eight run\n"
        )
        result = self.run_command([PROGRAM, "test", str(scenario)])
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)


def broadcast(path):
    """The host of the test above."""
    with asd7.Host(path) as host:
        host.write(asd7.FREQUENCY, 2000, asd="**")
        host.write(asd7.COMMAND, asd7.PRIORITIES | asd7.RUN, asd="**")
        time.sleep(1)
        running = [host.read(asd7.STATUS, f"{n:02d}") & asd7.RUNNING for n in range(8)]
        if all(running):
            print("all eight run")


if __name__ == "__main__":
    if sys.argv[1:2] == ["--broadcast"]:
        broadcast(sys.argv[2])
    else:
        unittest.main()
