#!/usr/bin/env python3
"""Full subset search of 480 rows x 12 candidates against numpy's stepwise regression by QR, in one run.

    python3 tests/bench/structure/compare.py [--rounds 5]

numpy (BSD; installed by pip into target/numpy, never linked) does forward entry and removal by QR factorisations of the
whole matrix, F for white residuals only; ours the best subset of every size, exactly, and, beside it, its own stepwise
regression with coloured standard errors, PRESS and PSE at every step. The same numbers, one thread each, in turn. Says
SKIPPED and ends with 0 where pip cannot bring numpy; ends with 1 where the target is missed or the answers differ.
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

PROBLEM = ROOT / "target" / "structure-problem.csv"
TARGET_RATIO = 0.1
F_ENTER, F_REMOVE = 12.0, 8.0
REPEATS = 200


def stepwise(np, x, y):
    """Forward entry by partial correlation with the residual, removal by partial F; the columns chosen, in order."""
    rows = len(y)
    inside, left = [], set()
    while True:
        basis = np.column_stack([np.ones(rows), x[:, inside]])
        q, _ = np.linalg.qr(basis)
        residual = y - q @ (q.T @ y)
        open_ = [j for j in range(x.shape[1]) if j not in inside and j not in left]
        if not open_:
            return inside
        rest = x[:, open_] - q @ (q.T @ x[:, open_])
        drops = (rest.T @ residual) ** 2 / np.sum(rest * rest, axis=0)
        best = int(np.argmax(drops))
        after = residual @ residual - drops[best]
        if drops[best] / after * (rows - basis.shape[1] - 1) < F_ENTER:
            return inside
        inside.append(open_[best])
        while True:
            q, r = np.linalg.qr(np.column_stack([np.ones(rows), x[:, inside]]))
            theta = np.linalg.solve(r, q.T @ y)
            residual = y - q @ (q.T @ y)
            inverse = np.linalg.inv(r)
            variance = residual @ residual / (rows - len(inside) - 1)
            f = theta[1:] ** 2 / (variance * np.sum(inverse[1:] ** 2, axis=1))
            worst = int(np.argmin(f))
            if f[worst] >= F_REMOVE:
                break
            left.add(inside.pop(worst))


def best_of(np, x, y, size):
    """The best subset of that size by trying all of them."""
    import itertools

    x, y = x - x.mean(axis=0), y - y.mean()
    sums, products, whole = x.T @ x, x.T @ y, y @ y

    def squares(places):
        part = np.ix_(places, places)
        return (whole - products[list(places)] @ np.linalg.solve(sums[part], products[list(places)])) / whole

    return min((squares(places), places) for places in itertools.combinations(range(x.shape[1]), size))


def theirs(np, x, y):
    """Microseconds, median."""
    times = []
    for _ in range(REPEATS):
        begin = time.perf_counter()
        stepwise(np, x, y)
        times.append(1e6 * (time.perf_counter() - begin))
    return statistics.median(times)


def main():
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--rounds", type=int, default=5)
    rounds = options.parse_args().rounds
    np = pypi.module("numpy")
    if np is None:
        return 0
    first = printed.by("structure_rate", PROBLEM)
    problem = np.loadtxt(PROBLEM, delimiter=",")
    x, y = problem[:, :-1], problem[:, -1]
    squares, places = best_of(np, x, y, 4)
    same = "+".join(map(str, places)) == first["best_of_four"] and abs(squares / float(first["squares_of_four"]) - 1) < 1e-9
    print(f"numpy {np.__version__}; {len(y)} rows, {x.shape[1]} candidates; one thread each")
    print(f"numpy's stepwise chose {sorted(stepwise(np, x, y))}, ours {first['stepwise_terms']}")
    print(f"best of four by trying all: {places}, ours {first['best_of_four']}; {first['triangles']} triangles of 2048")
    print("round   numpy stepwise us   our subsets us   ratio   our stepwise us   ratio")
    ratios, stepwise_ratios = [], []
    for count in range(rounds):
        numbers, their = printed.by("structure_rate", PROBLEM), theirs(np, x, y)
        subsets, own = float(numbers["subsets_us"]), float(numbers["stepwise_us"])
        ratios.append(subsets / their)
        stepwise_ratios.append(own / their)
        print(f"{count + 1:5}   {their:17.1f}   {subsets:14.1f}   {ratios[-1]:5.3f}   {own:15.1f}   {stepwise_ratios[-1]:5.3f}")
    ratio = statistics.median(ratios)
    beside = statistics.median(stepwise_ratios)
    print(f"median ratio: subset search {ratio:.3f} (target {TARGET_RATIO} or less), stepwise {beside:.3f}")
    return 0 if same and ratio <= TARGET_RATIO else 1


if __name__ == "__main__":
    sys.exit(main())
