#!/usr/bin/env python3
"""One recursive regression update, 12 regressors, beside padasip's RLS, in one run.

    python3 tests/bench/recursive/compare.py [--rounds 5]

padasip (MIT; installed by pip into target/padasip with numpy, never linked) updates its weights sample by sample with a
forgetting factor; ours updates the sums that any subset of regressors is solved from, over 16 lags as well for coloured
standard errors, and, in the second column, solves for all 12 after every sample, which is what RLS has then. The same
numbers, one thread each, in turn. Says SKIPPED and ends with 0 where pip cannot bring padasip; ends with 1 where the target is
missed or the answers differ.
"""

import argparse
import pathlib
import statistics
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "tests" / "bench"))

import printed  # noqa: E402
import pypi  # noqa: E402

sys.path.pop(0)  # its folders have names of modules

PROBLEM = ROOT / "target" / "recursive-problem.csv"
TARGET_RATIO = 0.05
LAMBDA = 0.999


def theirs(padasip, x, y):
    """Nanoseconds an update, and the last weights."""
    rls = padasip.filters.FilterRLS(n=x.shape[1], mu=LAMBDA, eps=1e-9, w="zeros")
    begin = time.perf_counter()
    for row, response in zip(x, y):
        rls.adapt(response, row)
    return 1e9 * (time.perf_counter() - begin) / len(y), rls.w


def main():
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--rounds", type=int, default=5)
    rounds = options.parse_args().rounds
    padasip = pypi.module("padasip")
    if padasip is None:
        return 0
    import numpy as np

    first = printed.by("recursive_rate", PROBLEM)
    problem = np.loadtxt(PROBLEM, delimiter=",")
    x, y = problem[:, :-1].copy(), problem[:, -1].copy()
    solution = np.array([float(value) for value in first["solution"].split(",")])
    weights = np.sqrt(LAMBDA ** np.arange(len(y) - 1, -1, -1))
    batch = np.linalg.lstsq(x * weights[:, None], y * weights, rcond=None)[0]
    same = np.allclose(solution, batch, rtol=1e-9, atol=1e-12)
    print(f"{len(y)} rows, {x.shape[1]} regressors; one thread each; ours {'is' if same else 'IS NOT'} the batch solution")
    print("round   padasip RLS ns   our update ns   ratio   update and solution ns   ratio")
    ratios, solved_ratios = [], []
    for count in range(rounds):
        numbers, (their, last) = printed.by("recursive_rate", PROBLEM), theirs(padasip, x, y)
        update, solved = float(numbers["update_ns"]), float(numbers["update_and_solution_ns"])
        ratios.append(update / their)
        solved_ratios.append(solved / their)
        print(f"{count + 1:5}   {their:14.0f}   {update:13.0f}   {ratios[-1]:5.3f}   {solved:22.0f}   {solved_ratios[-1]:5.3f}")
    print(f"padasip's weights are {np.max(np.abs(last - batch)):.1e} off the batch solution")
    ratio, solved = statistics.median(ratios), statistics.median(solved_ratios)
    print(f"median ratio: update {ratio:.3f} (target {TARGET_RATIO} or less), update and solution {solved:.3f}")
    return 0 if same and ratio <= TARGET_RATIO else 1


if __name__ == "__main__":
    sys.exit(main())
