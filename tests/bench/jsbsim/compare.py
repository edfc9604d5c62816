#!/usr/bin/env python3
"""Level-1 Puma against JSBSim's c172x: simulated seconds a second, side by side in one run.

    python3 tests/bench/jsbsim/compare.py [--rounds 3]

JSBSim (LGPL; installed by pip into target/jsbsim, never linked) steps its c172x at 120 Hz without output; ours flies its Puma
at 256 Hz by Runge-Kutta of fourth order (four evaluations a step), with nothing read of either but the motion. Each in one
thread, in turn, so that both meet the same machine; by processor time, so that what else runs there counts for neither. The call from Python costs JSBSim something: that of an idle call is measured and
taken off. Says SKIPPED and ends with 0 where pip cannot bring JSBSim; ends with 1 where a target is missed.
"""

import argparse
import pathlib
import statistics
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "tests" / "bench"))

import printed  # noqa: E402
import pypi  # noqa: E402

sys.path.pop(0)  # its folders have names of modules

TARGET_RATIO = 5.0
TARGET_MS = 2.0
MEASURED_S = 2.0
RATE_HZ = 120.0


def cessna(module):
    """A c172x in the air at 120 Hz, engine running, no output."""
    module.FGJSBBase().debug_lvl = 0
    fdm = module.FGFDMExec(str(pathlib.Path(module.__file__).parent))
    fdm.set_debug_level(0)
    if not fdm.load_model("c172x"):
        sys.exit("JSBSim could not load c172x")
    fdm.disable_output()
    fdm.set_dt(1.0 / RATE_HZ)
    for name, value in [("ic/h-sl-ft", 5000.0), ("ic/vc-kts", 100.0), ("ic/gamma-deg", 0.0)]:
        fdm[name] = value
    fdm["propulsion/set-running"] = -1
    if not fdm.run_ic():
        sys.exit("JSBSim could not set its initial condition")
    fdm["fcs/throttle-cmd-norm"] = 0.65
    fdm["fcs/mixture-cmd-norm"] = 0.87
    return fdm


def theirs(module):
    """Simulated seconds a second."""
    fdm = cessna(module)
    for _ in range(200):
        fdm.run()
    steps, begin, from_s = 0, time.process_time(), fdm.get_sim_time()
    while time.process_time() - begin < MEASURED_S:
        for _ in range(500):
            fdm.run()
        steps += 500
    took = time.process_time() - begin
    simulated = fdm.get_sim_time() - from_s
    assert abs(simulated - steps / RATE_HZ) < 1e-6 * simulated, "every call is one step"
    begin = time.process_time()
    for _ in range(steps):
        fdm.get_sim_time()
    idle = time.process_time() - begin
    return simulated / (took - idle), idle / took


def ours():
    """Simulated seconds a second, the same with every instrument read, milliseconds a linearisation."""
    numbers = printed.by("level1_rate")
    keys = ["simulated_seconds_per_second", "with_instruments", "milliseconds_per_linearisation"]
    return [float(numbers[key]) for key in keys]


def main():
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--rounds", type=int, default=3)
    rounds = options.parse_args().rounds
    module = pypi.module("jsbsim")
    if module is None:
        return 0
    subprocess.run(["cargo", "bench", "--quiet", "--bench", "level1_rate", "--no-run"], cwd=ROOT, check=True)
    print(f"JSBSim {module.__version__}, c172x at {RATE_HZ:.0f} Hz; Level-1 Puma at 256 Hz, fourth order; one thread each")
    print("round   JSBSim s/s   ours s/s   ratio   with instruments   linearisation ms   idle call of JSBSim's time")
    ratios, milliseconds = [], []
    for count in range(rounds):
        their_rate, idle = theirs(module)
        our_rate, read, linearisation = ours()
        ratios.append(our_rate / their_rate)
        milliseconds.append(linearisation)
        print(f"{count + 1:5}   {their_rate:10.1f}   {our_rate:8.1f}   {ratios[-1]:5.2f}   {read:16.1f}   {linearisation:16.3f}   {idle:.1%}")
    ratio, linearisation = statistics.median(ratios), statistics.median(milliseconds)
    spread = (max(ratios) - min(ratios)) / ratio
    print(f"median ratio {ratio:.2f} (target {TARGET_RATIO:.0f} or more), rounds apart by {spread:.0%} of it")
    print(f"median linearisation, trim from cold included, {linearisation:.3f} ms (target below {TARGET_MS:.0f} ms)")
    return 0 if ratio >= TARGET_RATIO and linearisation < TARGET_MS else 1


if __name__ == "__main__":
    sys.exit(main())
