#!/usr/bin/env python3
"""What pymavlink's DFReader and pyulog find in two logs: counts and digests, for the tables in logs_recordings.rs.

Run by hand: python3 peer_logs.py FOLDER, where FOLDER has plane-3.8.2.BIN and sample_log_small.ulg: the recordings, or the
simulated logs that logs_recordings.rs leaves under the same names in the folder that SIDESLIP_LOGS_OUT names.
Needs pymavlink 2.4.50 and pyulog 1.3.0. A digest is FNV-1a of 64 bits over the values of all messages of one type, in order:
a number as double precision, little-endian (NaN as 0x7ff8000000000000), integers of ULog as 64 bits, a text up to its first
zero and then 0xff.
"""
import collections
import math
import struct
import sys

from pymavlink import DFReader
from pyulog import ULog

MASK = (1 << 64) - 1


class Digest:
    def __init__(self):
        self.count = 0
        self.state = 0xCBF29CE484222325

    def take(self, data):
        state = self.state
        for byte in data:
            state = (state ^ byte) * 0x100000001B3 & MASK
        self.state = state

    def number(self, value):
        value = float(value)
        self.take(struct.pack('<Q', 0x7FF8000000000000) if math.isnan(value) else struct.pack('<d', value))


def dataflash(path):
    log = DFReader.DFReader_binary(path)
    every = Digest()
    kinds = collections.defaultdict(Digest)
    while True:
        message = log.recv_msg()
        if message is None:
            break
        for digest in (every, kinds[message.get_type()]):
            digest.count += 1
            for place, name in enumerate(message.fmt.columns):
                raw = message._elements[place]
                if isinstance(raw, bytes):
                    digest.take(raw.split(b'\0')[0] + b'\xff')
                else:
                    digest.number(getattr(message, name))
    print(f'DATAFLASH_ALL ({every.count}, 0x{every.state:016x})')
    for name, digest in sorted(kinds.items()):
        print(f'    ("{name}", {digest.count}, 0x{digest.state:016x}),')


def ulog(path):
    log = ULog(path)
    print('ULOG', log.start_timestamp, 'formats', len(log.message_formats), 'parameters', len(log.initial_parameters),
          'text', len(log.logged_messages), 'dropouts', [d.duration for d in log.dropouts], 'corrupt', log.file_corruption)
    for topic in log.data_list:
        digest = Digest()
        fields = [f for f in topic.field_data if not f.field_name.split('.')[-1].startswith('_padding')]
        columns = [(f.type_str, topic.data[f.field_name].tolist()) for f in fields]
        digest.count = len(topic.data['timestamp'])
        for row in range(digest.count):
            for kind, values in columns:
                if kind in ('float', 'double'):
                    digest.number(values[row])
                else:
                    digest.take(struct.pack('<Q', int(values[row]) & MASK))
        print(f'    ("{topic.name}", {topic.multi_id}, {digest.count}, 0x{digest.state:016x}),')
    digest = Digest()
    for key, value in log.initial_parameters.items():
        digest.count += 1
        digest.take(key.encode() + b'\xff')
        digest.number(value)
    print(f'PARAMETERS ({digest.count}, 0x{digest.state:016x})')
    digest = Digest()
    for line in log.logged_messages:
        digest.count += 1
        digest.take(struct.pack('<Q', line.timestamp) + line.message.encode() + b'\xff')
    print(f'TEXT ({digest.count}, 0x{digest.state:016x})')
    digest = Digest()
    for key, value in log.msg_info_dict.items():
        digest.count += 1
        digest.take(key.encode() + b'\xff')
        if isinstance(value, str):
            digest.take(value.encode() + b'\xff')
        else:
            digest.number(value)
    print(f'INFORMATION ({digest.count}, 0x{digest.state:016x})')


if __name__ == '__main__':
    dataflash(sys.argv[1] + '/plane-3.8.2.BIN')
    ulog(sys.argv[1] + '/sample_log_small.ulg')
