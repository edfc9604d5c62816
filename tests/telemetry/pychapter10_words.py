"""Prints what pychapter10 reads in the recordings, as the expected values of recordings.rs. Run by hand:

    python tests/pychapter10_words.py DATA_FOLDER        (needs: pip install pychapter10)

For each channel and data type: packets. For PCM in unpacked and packed mode: minor frames, and the FNV-1a digest (64 bits)
of time stamp, sync pattern and 16-bit words of every frame, each as 8 little-endian bytes (its lock status is left out:
pychapter10 takes it from other bits than 15-12 and finds 0 where they are set). For throughput mode: the digest of the bits
as bytes, first bit most significant, and a slow search for the sync patterns in them, bit by bit.
pychapter10 does not know how long a frame is: FRAME_BYTES says it, from what is known of the recordings.
"""
import collections
import os
import struct
import sys

from chapter10 import C10
from chapter10.pcm import PCMF1

FRAME_BYTES = {("err.c10", 10): 28, ("pcm.c10", 55): 64, ("pcm.c10", 56): 64}
SYNCS = (0xFE6B2840, 0x1F74E949)


def fnv(digest, data):
    for byte in data:
        digest = (digest ^ byte) * 0x100000001B3 & 0xFFFFFFFFFFFFFFFF
    return digest


def main(folder):
    for name in ("err.c10", "pcm.c10", "pcm_old_101348.c10"):
        counts, frames, digests = collections.Counter(), collections.Counter(), {}
        streams, times = collections.defaultdict(bytes), []
        raw = open(os.path.join(folder, name), "rb")
        length = os.path.getsize(raw.name)
        recording = C10(raw)
        while True:
            try:
                packet = next(recording)
            except StopIteration:
                break
            # pychapter10 hands out a packet that the end of the file cuts off; it is left out here.
            if raw.tell() == length and len(packet.buffer.getvalue()) < packet.packet_length:
                print(name, "cut off at the end:", packet.channel_id, len(packet.buffer.getvalue()), "of", packet.packet_length)
                break
            channel = packet.channel_id
            counts[channel, packet.data_type] += 1
            if packet.data_type == 0x11:
                times.append((packet.rtc, packet.time.strftime("%H:%M:%S.%f")))
            if not isinstance(packet, PCMF1):
                continue
            body = packet.buffer.getvalue()[28:24 + packet.data_length]
            word = struct.unpack("<I", packet.buffer.getvalue()[24:28])[0]
            if word >> 20 & 1:
                streams[channel] += b"".join(body[at:at + 2][::-1] for at in range(0, len(body), 2))
                continue
            PCMF1.Message.length = FRAME_BYTES[name, channel]
            wide = word >> 21 & 1
            for message in packet:
                if wide:
                    words = [half for (long,) in struct.iter_unpack("<I", message.data) for half in (long >> 16, long & 0xFFFF)]
                else:
                    words = [short for (short,) in struct.iter_unpack("<H", message.data)]
                values = [message.ipts, words[0] << 16 | words[1], *words[2:]]
                digest = digests.get(channel, 0xCBF29CE484222325)
                digests[channel] = fnv(digest, b"".join(value.to_bytes(8, "little") for value in values))
                frames[channel] += 1
        print(name, sum(counts.values()), "packets", dict(counts))
        print(name, "times", times)
        for channel, count in frames.items():
            print(name, "channel", channel, count, "frames, digest", hex(digests[channel]))
        for channel, data in sorted(streams.items()):
            bits = "".join(f"{byte:08b}" for byte in data)
            digest = hex(fnv(0xCBF29CE484222325, data))
            print(name, "channel", channel, len(bits), "bits, digest", digest)
            for sync in SYNCS:
                hits, at = [], bits.find(f"{sync:032b}")
                while at >= 0:
                    hits.append(at)
                    at = bits.find(f"{sync:032b}", at + 1)
                steps = collections.Counter(later - earlier for earlier, later in zip(hits, hits[1:]))
                identifiers = [int(bits[hit + 32:hit + 48], 2) for hit in hits]
                if hits:
                    print(f"    {sync:X}: {len(hits)} times from bit {hits[0]}, distances {dict(steps)}")
                    print(f"    next words {identifiers[:20]}")


main(sys.argv[1])
