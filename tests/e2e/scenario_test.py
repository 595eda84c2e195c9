"""virtdrive test: scenarios from files to reports, as a CI uses it."""

import json
import pathlib
import sys
import unittest

import jsonschema
import junitparser
import yaml

from cli_test import CliTest
from program import SOURCE

DONE, FAILED = 0, 1

HEAD = "virtdrive-scenario: 1\nbench: {drive: toshiba-mcu}\nsteps:\n"
GOOD = HEAD + "  - wait: 10 ms\n  - read: ResetStatus = 1\n"
BAD = HEAD + "  - wait: 10 ms\n  - expect: bus1.voltage > 30 V\n"

# A host that a person could have written: it knows a telegram, the port, and nothing of us.
HOST = """
import os, sys, serial
assert os.environ["VIRTDRIVE_PORT"] == os.environ["VIRTDRIVE_PORT_LINE"] == sys.argv[1]
with serial.Serial(sys.argv[1], 115200, timeout=5) as port:
    port.write(bytes.fromhex("111400" "6c13"))
    print("answer", port.read(6).hex())
sys.exit(int(sys.argv[2]))
"""


class ScenarioTest(CliTest):
    def write(self, name, text):
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
        return name

    def tree(self, folder):
        root = pathlib.Path(self.folder, folder)
        return {str(p.relative_to(root)): p.read_bytes() for p in root.rglob("*") if p.is_file()}


class Suite(ScenarioTest):
    def test_the_exit_code_tells_how_it_went(self):
        self.write("good.yaml", GOOD)
        self.write("bad.yaml", BAD)
        good = self.run_program("test", "good.yaml")
        self.assertEqual((good.returncode, good.stderr), (DONE, ""), good.stdout)
        self.assertIn("1 passed, 0 failed", good.stdout)
        bad = self.run_program("test", "good.yaml", "bad.yaml")
        self.assertEqual(bad.returncode, FAILED)
        for part in ("bad.yaml:5:5", "expected  bus1.voltage > 30 V", "6 V too low",
                     "virtdrive test bad.yaml --seed 1", "1 passed, 1 failed"):
            self.assertIn(part, bad.stdout)

    def test_files_and_options_that_cannot_be_used_are_refused(self):
        self.write("good.yaml", GOOD)
        self.write("wrong.yaml", HEAD + "  - expect: bus1.volts > 30 V\n")
        (self.folder / "empty").mkdir()
        self.assert_all_unusable(
            [
                (["test", "wrong.yaml"], "wrong.yaml:4:13", "bus1.voltage"),
                (["test", "good.yaml", "wrong.yaml"], "wrong.yaml:4:13"),
                (["test", "nowhere.yaml"], "nowhere.yaml"),
                (["test", "empty"], "empty", "no scenario"),
                (["test", "good.yaml", "-k", "nothing"], "no scenario is left"),
                (["test", "good.yaml", "--shard", "3/2"], "--shard 3/2"),
                (["test", "good.yaml", "--repeat", "0"], "--repeat"),
                (["test", "good.yaml", "--junit", "nowhere/x.xml"], "--junit nowhere/x.xml"),
                (["test", "good.yaml", "--html", "good.yaml"], "--html good.yaml"),
            ]
        )

    def test_equal_runs_give_equal_reports_whatever_the_jobs(self):
        self.write("all/good.yaml", GOOD)
        self.write("all/bad.yaml", BAD)
        for name, jobs in (("one", "1"), ("two", "4")):
            (self.folder / name).mkdir()
            result = self.run_program("test", "all", "--repeat", "3", "--jobs", jobs,
                                      "--html", f"{name}/html", "--junit", f"{name}/j.xml",
                                      "--json", f"{name}/r.json")
            self.assertEqual(result.returncode, FAILED, result.stderr)
        self.assertEqual(self.tree("one"), self.tree("two"))
        self.assertEqual(len(self.tree("one/html")), 7)

    def test_a_list_shows_what_would_be_played(self):
        self.write("good.yaml", GOOD)
        self.write("long.yaml", "tags: [long]\n" + GOOD)
        listed = self.run_program("test", "good.yaml", "long.yaml", "--list", "--seed", "5")
        self.assertEqual((listed.returncode, listed.stdout), (DONE, "good.yaml  good (seed 5)\n"))
        listed = self.run_program("test", "good.yaml", "long.yaml", "--list", "--long")
        self.assertIn("[long]", listed.stdout)

    def test_junit_is_what_others_read(self):
        self.write("good.yaml", GOOD)
        self.write("bad.yaml", BAD.replace("steps:", 'name: "a <b> & c"\nsteps:'))
        self.run_program("test", "good.yaml", "bad.yaml", "--junit", "j.xml")
        report = junitparser.JUnitXml.fromfile(self.path("j.xml"))
        self.assertEqual((report.tests, report.failures, report.errors), (2, 1, 0))
        cases = {case.name: case for suite in report for case in suite}
        self.assertEqual(set(cases), {"good (seed 1)", "a <b> & c (seed 1)"})
        (failure,) = cases["a <b> & c (seed 1)"].result
        self.assertIsInstance(failure, junitparser.Failure)
        self.assertIn("bus1.voltage", failure.message)
        self.assertFalse(cases["good (seed 1)"].result)

    def test_json_holds_every_step(self):
        self.write("bad.yaml", BAD)
        self.run_program("test", "bad.yaml", "--json", "r.json")
        (case,) = json.loads((self.folder / "r.json").read_text())["cases"]
        self.assertEqual([step["status"] for step in case["steps"]], ["done", "failed"])
        self.assertEqual(case["failure"]["off"], "6 V too low")

    def test_the_html_folder_needs_nothing_from_outside(self):
        self.write("bad.yaml", BAD)
        self.run_program("test", "bad.yaml", "--html", "html")
        pages = self.tree("html")
        self.assertEqual(set(pages), {"index.html", "bad.seed1.html"})
        for name, page in pages.items():
            text = page.decode().replace("http://www.w3.org/2000/svg", "")
            self.assertNotIn("http", text, name)
            self.assertNotIn("<script", text, name)

    def test_the_schema_is_json(self):
        schema = json.loads(self.run_program("schema").stdout)
        self.assertEqual(schema["properties"]["virtdrive-scenario"], {"const": 1})


class HostProgram(ScenarioTest):
    def play(self, command, *keys):
        self.write("host.py", HOST)
        lines = "".join(f"    {key}\n" for key in keys)
        self.write("host.yaml", HEAD + f"  - host: {command}\n{lines}")
        result = self.run_program("test", "host.yaml")
        self.assertEqual(result.stderr, "")
        return result

    def test_a_program_of_ones_own_speaks_with_the_bench(self):
        result = self.play(f"{sys.executable} host.py {{port}} 0", "output: answer 1114030a0a13")
        self.assertEqual(result.returncode, DONE, result.stdout)

    def test_its_exit_code_and_output_are_judged(self):
        result = self.play(f"{sys.executable} host.py {{port:line}} 3")
        self.assertEqual(result.returncode, FAILED)
        self.assertIn("expected  exit code 0", result.stdout)
        self.assertIn("exit code 3", result.stdout)
        self.assertIn("answer 1114030a0a13", result.stdout)
        result = self.play(f"{sys.executable} host.py {{port}} 3", "exit: 3")
        self.assertEqual(result.returncode, DONE, result.stdout)
        result = self.play("echo hello", "output: good bye")
        self.assertIn("'good bye' in its output", result.stdout)

    def test_a_program_that_does_not_end_is_ended(self):
        result = self.play("sleep 1000 & sleep 1000", "timeout: 200 ms")
        self.assertEqual(result.returncode, FAILED)
        self.assertIn("to end within 200 ms", result.stdout)

    def test_a_program_that_is_not_there_fails(self):
        result = self.play("./nowhere")
        self.assertEqual(result.returncode, FAILED)
        self.assertIn("exit code 127", result.stdout)


class Library(ScenarioTest):
    def test_the_schema_accepts_every_scenario_of_the_library(self):
        schema = json.loads(self.run_program("schema").stdout)
        validator = jsonschema.Draft202012Validator(schema)
        for path in (SOURCE / "scenarios/library").rglob("*.yaml"):
            with self.subTest(path.name):
                validator.validate(yaml.safe_load(path.read_text()))


if __name__ == "__main__":
    unittest.main()
