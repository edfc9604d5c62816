"""A peer from PyPI, for the scripts that measure beside one: installed into target/, single-threaded, never linked."""

import importlib
import os
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]

# Before numpy is there: it reads them once.
for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[threads] = "1"


def module(name, package=None):
    """The module, installed by pip (from a package of another name) if need be; None, said loudly, where that fails."""
    place = ROOT / "target" / name
    sys.path.insert(0, str(place))
    try:
        return importlib.import_module(name)
    except ImportError:
        pass
    pip = [sys.executable, "-m", "pip", "install", "--quiet", "--target", str(place), package or name]
    done = subprocess.run(pip, capture_output=True, text=True)
    if done.returncode != 0:
        print(f"SKIPPED: pip could not install {package or name}: {done.stderr.strip().splitlines()[-1:]}", file=sys.stderr)
        return None
    importlib.invalidate_caches()
    return importlib.import_module(name)
