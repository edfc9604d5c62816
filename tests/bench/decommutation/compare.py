#!/usr/bin/env python3
"""Words and samples out of PCM, beside pychapter10, in one run; and how busy 128 Ki words a second keep a processor.

    python3 tests/bench/decommutation/compare.py [--rounds 3]

pychapter10 (BSD; installed by pip into target/chapter10, never linked) reads a Chapter 10 recording of packed minor frames of 64
words of 16 bits. Words: `struct` makes the words of each frame, the least that one can do with it; ours reads the same file.
Samples: a loop makes parameter, time, raw word, value and limit check of each word; ours does so from the bits of the same minor
frames, with the search for their pattern before it, which the peer does not have. One thread each, processor time, in turn; the
sums of all words are compared. Says SKIPPED and ends with 0 where pip cannot bring pychapter10; ends with 1 where a target is
missed or the sums differ.
"""

import argparse
import pathlib
import statistics
import struct
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "tests" / "bench"))

import printed  # noqa: E402
import pypi  # noqa: E402

sys.path.pop(0)  # its folders have names of modules

RECORDING = ROOT / "target" / "decommutation.c10"
FRAME_BYTES = 4 + 2 * 64
TARGET_RATIO = 100
TARGET_BUSY = 0.1


def frames(chapter10, pcm):
    """Time and words of each minor frame."""
    pcm.PCMF1.Message.length = FRAME_BYTES
    words = struct.Struct(f"<{FRAME_BYTES // 2}H")
    with open(RECORDING, "rb") as file:
        for packet in chapter10.C10(file):
            for message in packet:
                yield message.ipts, words.unpack(message.data)[2:]


def their_words(chapter10, pcm):
    """Words a second, how many, and their sum."""
    count = total = 0
    begin = time.process_time()
    for _, values in frames(chapter10, pcm):
        count += len(values)
        total += sum(values)
    return count / (time.process_time() - begin), count, total


def their_samples(chapter10, pcm):
    """Samples a second."""
    offsets = [(32 + 16 * word) / (2048 * (32 + 16 * 64)) for word in range(64)]
    count, total = 0, 0.0
    begin = time.process_time()
    for stamp, values in frames(chapter10, pcm):
        start = 1e-7 * stamp
        for parameter, (raw, offset) in enumerate(zip(values, offsets)):
            value = -10.0 + 0.001 * raw
            sample = (parameter, start + offset, raw, value, value < -9.9 or value > 60.0)
            count += 1
            total += sample[3]
    return count / (time.process_time() - begin)


def main():
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--rounds", type=int, default=3)
    rounds = options.parse_args().rounds
    chapter10 = pypi.module("chapter10", "pychapter10")
    if chapter10 is None:
        return 0
    from chapter10 import pcm

    write = ["cargo", "bench", "--quiet", "--bench", "decommutation_rate", "--", str(RECORDING)]
    subprocess.run(write, cwd=ROOT, check=True, stdout=subprocess.DEVNULL)
    print("a second, one thread each")
    print("round   words: pychapter10       ours   ratio   samples: pychapter10       ours   ratio   live words     busy")
    ratios, busy, same = {"words": [], "samples": []}, [], True
    for count in range(rounds):
        numbers, (words, number, total) = printed.by("decommutation_rate"), their_words(chapter10, pcm)
        samples = their_samples(chapter10, pcm)
        ours = {name: float(value) for name, value in numbers.items()}
        same &= (number, total) == (ours["words"], ours["sum"]) == (ours["stream_words"], ours["stream_sum"])
        recorded, stream, live = (ours[name + "_words_per_s"] for name in ("recording", "stream", "live"))
        ratios["words"].append(recorded / words)
        ratios["samples"].append(stream / samples)
        busy.append(ours["live_busy_fraction"])
        print(f"{count + 1:5}   {words:18.2e}   {recorded:8.2e}   {recorded / words:5.1f}   {samples:20.2e}   {stream:8.2e}   "
              f"{stream / samples:5.1f}   {live:10.0f}   {100 * busy[-1]:4.2f} %")
    print(f"{number} words, the sums {'are the same' if same else 'DIFFER'}")
    median = {name: statistics.median(all) for name, all in ratios.items()}
    print(f"median ratio: words {median['words']:.1f}, samples {median['samples']:.1f} (target {TARGET_RATIO} or more); "
          f"busy {100 * max(busy):.2f} % at most (target below {100 * TARGET_BUSY:.0f} %)")
    return 0 if same and min(median.values()) >= TARGET_RATIO and max(busy) < TARGET_BUSY else 1


if __name__ == "__main__":
    sys.exit(main())
