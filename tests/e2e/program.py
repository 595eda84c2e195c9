"""Runs the program under test, and ends it, whatever happens.

The environment may name what is tested: VIRTDRIVE is the program (build/dev/virtdrive),
VIRTDRIVE_TEST_DATA the folder of the vectors (tests/data).
"""

import csv
import json
import os
import pathlib
import signal
import subprocess
import tempfile
import threading
import time
import unittest

SOURCE = pathlib.Path(__file__).resolve().parents[2]
PROGRAM = os.environ.get("VIRTDRIVE", str(SOURCE / "build/dev/virtdrive"))
TEST_DATA = pathlib.Path(os.environ.get("VIRTDRIVE_TEST_DATA", SOURCE / "tests/data"))
DRIVE = "toshiba-mcu"


class Bench:
    """A running `virtdrive run ... --json` whose port is ready."""

    def __init__(self, test, arguments, link, drive=DRIVE):
        self.test = test
        self.link = link
        self.stderr = tempfile.TemporaryFile("w+")
        test.addCleanup(self.stderr.close)
        self.process = subprocess.Popen(
            [PROGRAM, "run", drive, "--json", *(["--link", link] if link else []), *arguments],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=self.stderr,
            text=True,
        )
        test.addCleanup(self._end)
        test.processes.append(self.process)
        line = self.process.stdout.readline()
        if not line:
            raise AssertionError(f"no ready line: {self.errors()}")
        self.ready = json.loads(line)

    def errors(self):
        self.process.wait()
        self.stderr.seek(0)
        return self.stderr.read()

    def stop(self, number=signal.SIGTERM):
        """Ends the run as Ctrl-C or a service manager would; the report."""
        self.process.send_signal(number)
        return self.report()

    def report(self):
        """Waits for the end of the run."""
        rest = self.process.stdout.read()  # up to its end; the watchdog sees to that
        self.notes = [line for line in self.errors().splitlines() if line.startswith("note: ")]
        others = [line for line in self.errors().splitlines() if line not in self.notes]
        self.test.assertEqual((self.process.returncode, others), (0, []))
        lines = rest.splitlines()
        self.test.assertEqual(len(lines), 1, rest)
        return json.loads(lines[0])

    def kill(self):
        self.process.kill()
        self.process.wait()

    def _end(self):
        # A test that has not looked at the report still wants a clean end.
        try:
            if self.process.poll() is None and not self.test.gave_up:
                self.stop()
        finally:
            self.process.kill()
            self.process.wait()
            self.process.stdout.close()


class ProgramTest(unittest.TestCase):
    """A test with a folder of its own and a watchdog that ends the programs it started."""

    # Wall time; a test that passes needs a fraction of it, with sanitizers too.
    deadline_s = 60

    def setUp(self):
        self.gave_up = False
        self.processes = []
        folder = tempfile.TemporaryDirectory(prefix="virtdrive-e2e-")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        watchdog = threading.Timer(self.deadline_s, self._give_up)
        watchdog.daemon = True
        self.addCleanup(self._check_deadline)
        self.addCleanup(watchdog.cancel)
        watchdog.start()

    def _give_up(self):
        self.gave_up = True
        for process in self.processes:
            process.kill()

    def _check_deadline(self):
        self.assertFalse(self.gave_up, f"not done after {self.deadline_s} s: programs killed")

    def path(self, name):
        return str(self.folder / name)

    def files(self):
        return sorted(entry.name for entry in self.folder.iterdir())

    def bench(self, *arguments, link="drive", drive=DRIVE):
        """A bench of a drive under `link`, if that is not None, in the test's folder."""
        return Bench(
            self, [str(argument) for argument in arguments], link and self.path(link), drive
        )

    def run_program(self, *arguments, stdin=""):
        """The program with these arguments, run to its end."""
        return self.run_command([PROGRAM, *arguments], stdin.encode())

    def run_command(self, command, stdin=b""):
        """Any command, run to its end; output as text of single bytes."""
        process = subprocess.Popen(
            [str(word) for word in command],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            cwd=self.folder,
        )
        self.processes.append(process)
        stdout, stderr = process.communicate(stdin)
        return subprocess.CompletedProcess(
            command, process.returncode, stdout.decode("latin-1"), stderr.decode("latin-1")
        )

    def wait_for(self, what, condition):
        """Polls until `condition` holds; the watchdog's deadline bounds it."""
        while not self.gave_up:
            result = condition()
            if result:
                return result
            time.sleep(0.001)
        self.fail(f"waited in vain for {what}")


def read_recording(path):
    """A --record file as a dict of columns."""
    with open(path, newline="") as file:
        header, *rows = csv.reader(file)
    return {name: [float(row[i]) for row in rows] for i, name in enumerate(header)}
