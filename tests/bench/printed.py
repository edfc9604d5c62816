"""What a benchmark of this project prints, for the scripts that put a peer beside it."""

import pathlib
import subprocess

ROOT = pathlib.Path(__file__).resolve().parents[2]


def by(bench, *arguments):
    """Runs it; the lines of a name and a value, by name."""
    command = ["cargo", "bench", "--quiet", "--bench", bench, *(["--", *map(str, arguments)] if arguments else [])]
    done = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True)
    return dict(line.split() for line in done.stdout.splitlines() if len(line.split()) == 2)
