#!/usr/bin/env python3
"""Breaks the plant in the known ways, one after the other, and tells which tests notice.

  tools/mutate.py [NAME...]        all mutations, or those named

Needs build/dev (./dev build). A mutation that no test notices, or whose place is no longer there, is an
error. The files are put back whatever happens.
"""

import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
BUILD = ROOT / "build/dev"

# name: (file, tests that run, [(what stands there, what is put in its place) ...])
DIODES = "Accuracy.*:HalfBridges*:SixStep*:*Bridge*"
FAST = "-Accuracy.*:Energy*:Referee*:Golden*"
MUTATIONS = {
    # The first stage of a step is taken over from the last one, with the inputs of that time.
    "no reset at a change of inputs": ("plant/ode.cc", "OdeSolver.*", [
        ('  require(ERKStepReset(erk, 0, x_.get()), "ERKStepReset");',
         '  double from = 0;\n  require(ERKStepGetCurrentTime(erk, &from), "time");'),
        ("ERKStepSetStopTime(erk, duration_s)", "ERKStepSetStopTime(erk, from + duration_s)"),
        ("ERKStepEvolve(erk, 2 * duration_s,", "ERKStepEvolve(erk, from + 2 * duration_s,"),
        ("std::min(reached, duration_s)", "std::min(reached - from, duration_s)")]),
    # The tables' defaults have changed between releases of SUNDIALS.
    "no named table": ("plant/ode.cc", "OdeSolver.*", [
        ('  require(ERKStepSetTableNum(e, ARKODE_DORMAND_PRINCE_7_4_5), "ERKStepSetTableNum");\n', "")]),
    "roots of the other direction": ("plant/ode.cc", "OdeSolver.*", [("int falling = -1;", "int falling = 1;")]),
    # An edge or a load step within a step of the integrator.
    "time events are not waited for": ("plant/circuit.cc", FAST, [
        ("      until = std::min(until, unit->next_time_event());\n", "")]),
    # Zero-length cycles of an open phase that touches a rail.
    "diodes without hysteresis": ("plant/half_bridges.cc", DIODES, [
        ("inverter_.diode_v + kDiodeHysteresisV", "inverter_.diode_v"),
        (" + kZeroCurrentA);", ");"),
        (" + kZeroCurrentA > 0) continue;", " > 0) continue;")]),
    "diodes that forget": ("plant/half_bridges.cc", FAST, [
        ("      take_over(n, current_a);", "      take_over(n, {0 * current_a[0], 0, 0});")]),
    "diodes that never turn off": ("plant/half_bridges.cc", FAST, [
        (" + kZeroCurrentA > 0) continue;", " > -1e9) continue;")]),
    "long steps over slivers of conduction": ("plant/axis_model.cc", DIODES, [
        ("return kOfShapes * peak_v > bus_v ? 0.01 : 0.1;", "return kOfShapes * peak_v > bus_v ? 2 : 0.1;")]),
    "corners of the EMF within a step": ("plant/axis_model.cc", DIODES, [
        ("return ahead * distance / std::fabs(speed);",
         "return 1e9 * ahead * distance / std::fabs(speed);")]),
    "stiction without breakaway": ("plant/shaft.cc", FAST, [
        ("std::max(sliding_nm, stiction_nm)", "sliding_nm + 0 * stiction_nm")]),
}


def tests_that_fail(tests):
    build = subprocess.run(["ninja", "-C", BUILD, "-j2", "plant_test"], capture_output=True, text=True)
    if build.returncode != 0:
        sys.exit(f"does not build:\n{build.stdout[-2000:]}")
    try:
        run = subprocess.run([BUILD / "bin/plant_test", "--gtest_brief=1", f"--gtest_filter={tests}"],
                             capture_output=True, text=True, timeout=120)
    except subprocess.TimeoutExpired:
        return ["(it hangs)"]
    failed = sorted(set(re.findall(r"\[  FAILED  \] ([\w./]+)", run.stdout)))
    return failed or (["(it crashes)"] if run.returncode != 0 else [])


def try_one(name):
    file, tests, replacements = MUTATIONS[name]
    path = ROOT / file
    original = path.read_text()
    text = original
    for old, new in replacements:
        if old not in text:
            sys.exit(f"{name}: {file} has no {old.strip()!r} any more")
        text = text.replace(old, new)
    try:
        path.write_text(text)
        return tests_that_fail(tests)
    finally:
        path.write_text(original)


def main():
    unnoticed = 0
    for name in sys.argv[1:] or MUTATIONS:
        if name not in MUTATIONS:
            sys.exit(f"unknown mutation {name!r}; known: {', '.join(MUTATIONS)}")
        failed = try_one(name)
        unnoticed += not failed
        shown = ", ".join(failed[:4]) + (f" and {len(failed) - 4} more" if len(failed) > 4 else "")
        print(f"{name}: {shown or 'NOBODY NOTICES'}", flush=True)
    return 1 if unnoticed else 0


if __name__ == "__main__":
    sys.exit(main())
