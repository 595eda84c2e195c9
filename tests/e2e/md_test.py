"""The MD controllers over real pseudo-terminals, asked by a host written from their document."""

import importlib.util
import os
import re
import shutil
import statistics
import subprocess
import sys
import time
import unittest

import md
from program import SOURCE, ProgramTest, read_recording

COUNTS_PER_TURN = 60  # 20 poles x 3


class DriveTest(ProgramTest):
    def start(self, drive, *arguments, baud=md.BAUD, host=md.HOST):
        self.bench_ = self.bench(*arguments, drive=drive)
        connection = md.Host(self.bench_.link, baud=baud, host=host)
        self.addCleanup(connection.port.close)
        return connection


class SingleController(DriveTest):
    def test_a_speed_is_commanded_and_read_back(self):
        host = self.start("md400")
        self.assertEqual(host.request(md.TYPE), b"MD400-V4.4")
        self.assertEqual(len(host.request(md.MAIN_DATA)), 17)
        host.send(md.VEL_CMD, md.Int2Byte(-1000))
        running = self.wait_for("the speed", lambda: self.at(host, -1000))
        self.assertEqual((running.type, running.status), (1, 0))
        self.assertLess(running.posi, 0)
        host.send(md.TQ_OFF, [0])
        self.wait_for("standstill", lambda: host.main_data().type == 0)
        report = self.bench_.stop()
        self.assertEqual((report["bad_frames"], report["bytes_garbled"]), (0, 0))

    def at(self, host, rpm):
        data = host.main_data()
        return data if abs(data.rpm - rpm) <= 10 else None

    def test_hosts_go_by_several_numbers(self):
        self.start("md200")
        for number in (172, 184, 128):
            with md.Host(self.bench_.link, host=number) as host:
                self.assertEqual(host.request(md.VERSION), bytes([44]))

    def test_a_new_id_counts_at_once_and_stays(self):
        memory = self.path("md.nvm")
        host = self.start("md750", "--nvm", memory)
        host.send(md.ID, [md.WRITE_CHECK, 9], device=md.ALL)
        self.assertEqual(host.request(md.ID, device=9), bytes([9]))
        self.bench_.stop()
        host = self.start("md750", "--nvm", memory)
        self.assertEqual(host.request(md.ID, device=9), bytes([9]))

    def test_a_new_baud_rate_counts_after_the_next_power_up(self):
        memory = self.path("md.nvm")
        host = self.start("md100", "--nvm", memory)
        host.send(md.BAUD_RATE, [md.WRITE_CHECK, 4])
        self.assertEqual(host.request(md.VERSION), bytes([44]))
        self.bench_.stop()
        host = self.start("md100", "--nvm", memory, baud=57600)
        self.assertEqual(host.request(md.VERSION), bytes([44]))


@unittest.skipUnless(importlib.util.find_spec("can"), "python3-can is not installed")
class CanBus(DriveTest):
    """A host on CAN, by python-can's own slcan interface."""

    def open_bus(self, bitrate=50_000):
        import can

        self.bench_ = self.bench("--can-link", self.path("can"), drive="md400t")
        bus = can.Bus(self.path("can"), bustype="slcan", bitrate=bitrate, sleep_after_open=0)
        self.addCleanup(bus.shutdown)
        return bus

    def send(self, bus, pid, data=b"", device=1):
        import can

        identifier = md.CONTROLLER << 16 | md.HOST << 8 | device
        bus.send(can.Message(arbitration_id=identifier, data=[pid, *data], is_extended_id=True))

    def receive(self, bus):
        frame = bus.recv(10)
        self.assertIsNotNone(frame, "no answer on CAN")
        self.assertTrue(frame.is_extended_id)
        self.assertEqual(frame.arbitration_id, md.HOST << 16 | md.CONTROLLER << 8 | 1)
        return frame.data[0], bytes(frame.data[1:])

    def request(self, bus, pid):
        self.send(bus, md.REQ_PID_DATA, [pid])
        got, data = self.receive(bus)
        self.assertEqual(got, pid)
        return data

    def test_a_motor_is_driven_and_read_back(self):
        bus = self.open_bus()
        self.assertEqual(self.request(bus, md.VERSION), bytes([44]))
        self.send(bus, md.VEL_CMD, md.Int2Byte(600))
        speed = lambda: md.Byte2Int(*self.request(bus, md.INT_RPM_DATA))
        self.wait_for("the speed", lambda: abs(speed() - 600) < 10)
        self.send(bus, md.TQ_OFF, [0])
        self.wait_for("standstill", lambda: speed() == 0)
        self.assertEqual(bus.get_version(5), (10, 13))

    def test_a_bus_at_another_bit_rate_is_silent(self):
        bus = self.open_bus(bitrate=125_000)
        self.send(bus, md.REQ_PID_DATA, [md.VERSION])
        self.assertIsNone(bus.recv(0.3))

    def test_rs485_hears_what_passes_on_can(self):
        bus = self.open_bus()
        with md.Host(self.bench_.link) as rs485:
            rs485.send(md.COMMAND, [23])
            self.assertEqual(rs485.request(md.VERSION), bytes([44]))
            self.send(bus, md.REQ_PID_DATA, [md.VERSION], device=9)
            pid, data = rs485.receive()
            self.assertEqual((pid, data), (238, bytes([9, 0xAC, 0xB7, 0, md.REQ_PID_DATA, 1])))

    @unittest.skipUnless(os.path.isdir("/sys/module/slcan"), "this kernel has no SLCAN")
    @unittest.skipUnless(shutil.which("slcand") and os.geteuid() == 0, "slcand needs root")
    def test_the_kernel_attaches_with_slcand(self):
        self.bench_ = self.bench("--can-link", self.path("can"), drive="md400t")
        interface = f"vd{os.getpid() % 10000}"
        attached = subprocess.Popen(["slcand", "-F", "-o", "-c", "-s2", self.path("can"), interface])
        self.processes.append(attached)
        self.addCleanup(attached.wait)
        self.addCleanup(attached.terminate)
        self.wait_for("the interface", lambda: os.path.isdir(f"/sys/class/net/{interface}"))


class Ttl(DriveTest):
    def test_the_second_port_is_a_terminal_of_its_own(self):
        second = self.path("ttl")
        host = self.start("md400", "--link2", second)
        with md.Host(second, baud=9600) as ttl:
            ttl.send(md.VEL_CMD, md.Int2Byte(300))
            self.wait_for("the speed", lambda: abs(host.main_data().rpm - 300) < 10)
            self.assertAlmostEqual(ttl.main_data().rpm, 300, delta=15)


class Examples(DriveTest):
    """The programs of docs/examples/md, as their first lines say."""

    def run_example(self, name, *arguments):
        done = self.run_command(
            [sys.executable, "-W", "ignore", "-B", str(SOURCE / "docs/examples/md" / name),
             *arguments])
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return done.stdout

    def test_two_wheels_go_their_way(self):
        self.bench_ = self.bench(drive="md200t")
        printed = self.run_example("two_wheels.py", self.bench_.link, "--left", "120", "--right",
                                   "120", "--seconds", "1.5")
        metres, degrees = re.search(r"way (.*) m, turned (.*) degrees", printed).groups()
        self.assertGreater(float(metres), 0.4)
        self.assertLess(abs(int(degrees)), 20)

    @unittest.skipUnless(importlib.util.find_spec("can"), "python3-can is not installed")
    def test_can_speed_turns_a_motor(self):
        self.bench_ = self.bench("--can-link", self.path("can"), drive="md400t")
        printed = self.run_example("can_speed.py", self.path("can"), "--rpm", "500", "--seconds",
                                   "1")
        self.assertAlmostEqual(int(printed.split()[0]), 500, delta=10)


class TwoWheels(DriveTest):
    """A small robot: two in-wheel motors of 20 poles on one MD200T at 57600 baud.

    VIRTDRIVE_ROBOT_S is how long it drives: 6 s, or a minute where it may take long.
    """

    seconds = int(os.environ.get("VIRTDRIVE_ROBOT_S", "6"))
    deadline_s = 60 + 2 * seconds

    def test_a_robots_host_polls_fifty_times_a_second_and_loses_nothing(self):
        recording = self.path("robot.csv")
        host = self.start("md200t", "--set", "BAUDRATE=4", "--record", recording,
                          "--signals", "motor0.angle,motor1.angle", baud=57600)
        # As vendors' hosts begin: signs, no limit switches, positions to 0 (without a data byte).
        host.send(md.INV_SIGN_CMD, [1])
        host.send(md.INV_SIGN_CMD2, [0])
        host.send(md.USE_LIMIT_SW, [0])
        host.send(md.COMMAND, [8])
        host.send(md.POSI_RESET)
        self.assertTrue(host.request(md.TYPE).startswith(b"MD200T"))
        host.two_speeds(120, 80)
        begin = time.monotonic()
        pids = (md.MAIN_DATA, md.IO_MONITOR, md.MONITOR, md.MAIN_DATA2, md.PNT_MAIN_DATA)
        sizes = {}
        delays = []
        for i in range(50 * self.seconds):
            time.sleep(max(0.0, begin + i / 50 - time.monotonic()))
            pid = pids[i % len(pids)]
            asked = time.monotonic()
            sizes[pid] = len(host.request(pid))
            delays.append(time.monotonic() - asked)
        print(f"{len(delays)} answers in {time.monotonic() - begin:.1f} s, median "
              f"{1e3 * statistics.median(delays):.2f} ms, slowest {1e3 * max(delays):.2f} ms",
              file=sys.stderr)
        self.assertEqual(sizes, {193: 17, 194: 17, 196: 12, 200: 17, 210: 18})
        left, right = md.two_wheels(host.request(md.PNT_MAIN_DATA))
        self.assertAlmostEqual(left.rpm, 120, delta=6)
        self.assertAlmostEqual(right.rpm, 80, delta=6)
        self.assertGreater(left.posi, right.posi)
        host.two_speeds(0, 0, md.RETURN_MAIN_DATA)
        self.assertEqual(host.receive()[0], md.PNT_MAIN_DATA)
        self.wait_for("standstill", lambda: not any(w.rpm for w in self.wheels(host)))
        left, right = self.wheels(host)
        report = self.bench_.stop()
        self.assertEqual((report["bad_frames"], report["bytes_lost_busy"]), (0, 0))
        self.assertGreaterEqual(report["replies"], 50 * self.seconds)
        columns = read_recording(recording)
        for wheel, sign, name in ((left, -1, "motor0.angle"), (right, 1, "motor1.angle")):
            angle = next(v for k, v in columns.items() if k.startswith(name))[-1]
            self.assertAlmostEqual(wheel.posi, sign * angle / 360 * COUNTS_PER_TURN, delta=1)

    def wheels(self, host):
        return md.two_wheels(host.request(md.PNT_MAIN_DATA))


if __name__ == "__main__":
    unittest.main()
