"""A bench that is controlled while it runs: --control and virtdrive ctl."""

import json
import os
import socket
import stat
import sys
import unittest

sys.dont_write_bytecode = True

from cli_test import CliTest
from toshiba_mcu import Host

DONE, FAILED, UNUSABLE = 0, 1, 2


class Control(CliTest):
    def controlled(self, *arguments):
        self.socket = self.path("ctl")
        return self.bench("--control", self.socket, *arguments)

    def ctl(self, *words, code=DONE):
        result = self.run_program("ctl", self.socket, *[str(word) for word in words])
        self.assertEqual(result.returncode, code, result.stderr)
        return result.stderr if code else result.stdout

    def ask(self, **request):
        with socket.socket(socket.AF_UNIX) as client:
            client.connect(self.socket)
            client.sendall(json.dumps(request).encode() + b"\n")
            return json.loads(client.makefile().readline())

    def test_signals_inputs_faults_and_power_are_at_hand(self):
        bench = self.controlled()
        self.assertEqual(self.ctl("read", "supply1.voltage"), "24.0 V\n")
        self.ctl("set", "supply1.voltage", 26)
        self.assertEqual(self.ctl("read", "supply1.voltage"), "26.0 V\n")
        self.ctl("inject", "line.to_host_lost", 0.5)
        status = json.loads(self.ctl("status"))
        self.assertEqual(status["faults"], {"line.to_host_lost": 0.5})
        self.assertTrue(status["drives"][0]["powered"])
        self.assertIn("motor1.speed", status["signals"])
        self.ctl("clear", "all")
        self.ctl("power", "off")
        self.assertFalse(json.loads(self.ctl("status"))["drives"][0]["powered"])
        self.ctl("power", "on")
        self.ctl("reset")
        with Host(bench.link) as host:
            self.assertEqual(host.version(), (3, 10))
        self.assertIn("line.to_host_cut", self.ctl("list"))

    def test_it_stands_still_steps_and_goes_on(self):
        self.controlled()
        self.ctl("rate", 0)
        before = self.ask(do="status")["time_s"]
        self.assertEqual(self.ask(do="status")["time_s"], before)
        self.ctl("step", 0.25)
        self.wait_for("the step", lambda: self.ask(do="status")["time_s"] > before)
        self.assertAlmostEqual(self.ask(do="status")["time_s"], before + 0.25, places=9)
        self.ctl("rate", 100)
        self.wait_for("time to pass", lambda: self.ask(do="status")["time_s"] > before + 5)
        self.assertIn("stand still first", self.ctl("step", 1, code=FAILED))

    def test_what_cannot_be_done_is_told(self):
        self.controlled()
        self.assertIn("did you mean motor1.speed", self.ctl("read", "motor1.sped", code=FAILED))
        self.assertIn("outside of", self.ctl("set", "load1.brake_torque", -1, code=FAILED))
        self.assertIn("unknown fault", self.ctl("inject", "supply1.voltage", code=FAILED))
        self.assertIn("unknown request", self.ctl("raed", "x", code=UNUSABLE))
        self.assertIn("expected a number", self.ctl("set", "supply1.voltage", code=UNUSABLE))
        for request in ("", "[]", "{", '{"do": 1}', '{"do": "set", "name": "supply1.voltage"}'):
            with self.subTest(request), socket.socket(socket.AF_UNIX) as client:
                client.connect(self.socket)
                client.sendall(request.encode() + b"\n")
                self.assertFalse(json.loads(client.makefile().readline())["ok"])
        self.assertEqual(self.ask(do="read", name="motor1.speed", id=[7])["id"], [7])

    def test_the_socket_is_its_owners_and_goes_with_the_bench(self):
        bench = self.controlled()
        self.assertEqual(stat.S_IMODE(os.stat(self.socket).st_mode), 0o600)
        self.assert_unusable(
            ["run", "toshiba-mcu", "--control", self.socket, "--duration", "0"], "another bench"
        )
        bench.stop()
        self.assertFalse(os.path.exists(self.socket))
        self.assertIn("no bench is controlled there", self.ctl("status", code=UNUSABLE))

    def test_the_socket_of_a_killed_bench_is_taken_over_and_nothing_else(self):
        self.controlled().kill()
        self.assertTrue(os.path.exists(self.socket))
        bench = self.controlled()
        self.ctl("status")
        bench.stop()
        (self.folder / "file").write_text("mine")
        self.assert_unusable(
            ["run", "toshiba-mcu", "--control", self.path("file"), "--duration", "0"], "no socket"
        )

    def test_a_client_that_does_not_behave_harms_nobody(self):
        self.controlled()
        with socket.socket(socket.AF_UNIX) as rude:
            rude.connect(self.socket)
            try:
                rude.sendall(b"x" * 1_000_000)  # no line's end
            except OSError:
                pass  # cut off
            self.assertTrue(self.ask(do="status")["ok"])
        clients = [socket.socket(socket.AF_UNIX) for _ in range(40)]
        for client in clients:
            client.connect(self.socket)
        for client in clients:
            client.close()
        self.wait_for("room", lambda: self.run_program("ctl", self.socket, "status").returncode == 0)


if __name__ == "__main__":
    unittest.main()
