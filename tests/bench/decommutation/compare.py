#!/usr/bin/env python3
"""Words and samples out of PCM, beside pychapter10 and AcraNetwork, in one run; and how busy 128 Ki words a second keep a
processor.

    python3 tests/bench/decommutation/compare.py [--rounds 3]

The peers (pychapter10, BSD; AcraNetwork, GPL; installed by pip into target/, run here and never linked) read a Chapter 10
recording of packed minor frames of 64 words of 16 bits, each by its own reader of packets and minor frames.
Words: `struct` makes the words of each frame, the least that one can do with what a peer hands out; ours reads the same file.
Samples: a loop makes parameter, time, raw word, value and limit check of each word; ours does so from the bits of the same minor
frames, with the search for their pattern before it, which the peers do not have. One thread each, processor time, in turn; the
sums of all words are compared.

The comparison that decides is that of words, beside each of the peers: the same bytes go in and the same words come out, proved
by their sums, while the loop over samples is no part of a peer and its input is not that of ours. The ratio of samples is
printed beside it. Says SKIPPED where pip cannot bring a peer, and ends with 0 where it brings none; ends with 1 where a target
is missed or the sums differ.
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


WORDS = struct.Struct(f"<{FRAME_BYTES // 2}H")


def pychapter10_frames():
    """A reader of time, in 100 ns, and words of each minor frame; None where the peer cannot be had."""
    chapter10 = pypi.module("chapter10", "pychapter10")
    if chapter10 is None:
        return None
    from chapter10 import pcm

    def frames():
        pcm.PCMF1.Message.length = FRAME_BYTES
        with open(RECORDING, "rb") as file:
            for packet in chapter10.C10(file):
                for message in packet:
                    yield message.ipts, WORDS.unpack(message.data)[2:]

    return frames


def acra_network_frames():
    """The same by AcraNetwork."""
    if pypi.module("AcraNetwork") is None:
        return None
    from AcraNetwork.IRIG106.Chapter10.FileParser import FileParser
    from AcraNetwork.IRIG106.Chapter11 import DATA_TYPE_PCM_DATA_FMT1, Chapter11
    from AcraNetwork.IRIG106.Chapter11.PCM import PCMDataPacket

    def frames():
        with FileParser(str(RECORDING)) as packets:
            for octets in packets:
                packet = Chapter11()
                packet.unpack(octets)
                if packet.datatype != DATA_TYPE_PCM_DATA_FMT1:
                    continue
                minor_frames = PCMDataPacket(minor_frame_size_bytes=FRAME_BYTES)
                minor_frames.unpack(packet.payload)
                for frame in minor_frames:
                    yield frame.ipts.count, WORDS.unpack(frame.payload)[2:]

    return frames


def words_of(frames):
    """Words a second, how many, and their sum."""
    count = total = 0
    begin = time.process_time()
    for _, values in frames():
        count += len(values)
        total += sum(values)
    return count / (time.process_time() - begin), count, total


def samples_of(frames):
    """Samples a second."""
    offsets = [(32 + 16 * word) / (2048 * (32 + 16 * 64)) for word in range(64)]
    count, total = 0, 0.0
    begin = time.process_time()
    for stamp, values in frames():
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
    readers = {"pychapter10": pychapter10_frames(), "AcraNetwork": acra_network_frames()}
    peers = {name: frames for name, frames in readers.items() if frames is not None}
    if not peers:
        return 0

    write = ["cargo", "bench", "--quiet", "--bench", "decommutation_rate", "--", str(RECORDING)]
    subprocess.run(write, cwd=ROOT, check=True, stdout=subprocess.DEVNULL)
    print("a second, one thread each")
    print("round          peer   words: peer       ours   ratio   samples: peer       ours   ratio")
    word_ratios, sample_ratios = ({name: [] for name in peers} for _ in range(2))
    busy, same = [], True
    for count in range(rounds):
        ours = {name: float(value) for name, value in printed.by("decommutation_rate").items()}
        recorded, stream = ours["recording_words_per_s"], ours["stream_words_per_s"]
        same &= (ours["words"], ours["sum"]) == (ours["stream_words"], ours["stream_sum"])
        for name, frames in peers.items():
            words, number, total = words_of(frames)
            samples = samples_of(frames)
            same &= (number, total) == (ours["words"], ours["sum"])
            word_ratios[name].append(recorded / words)
            sample_ratios[name].append(stream / samples)
            print(f"{count + 1:5}   {name:>11}   {words:11.2e}   {recorded:8.2e}   {recorded / words:5.1f}   {samples:13.2e}   "
                  f"{stream:8.2e}   {stream / samples:5.1f}")
        busy.append(ours["live_busy_fraction"])
        print(f"{count + 1:5}   live: {ours['live_words_per_s']:.0f} words a second, busy {100 * busy[-1]:.2f} %")
    print(f"{ours['words']:.0f} words, the sums {'are the same' if same else 'DIFFER'}")
    median = {name: statistics.median(ratios) for name, ratios in word_ratios.items()}
    for name, ratio in median.items():
        print(f"median ratio beside {name}: words {ratio:.1f} (target {TARGET_RATIO} or more), "
              f"samples {statistics.median(sample_ratios[name]):.1f}")
    print(f"busy {100 * max(busy):.2f} % at most (target below {100 * TARGET_BUSY:.0f} %)")
    return 0 if same and min(median.values()) >= TARGET_RATIO and max(busy) < TARGET_BUSY else 1


if __name__ == "__main__":
    sys.exit(main())
