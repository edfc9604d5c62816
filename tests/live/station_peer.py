"""The other end of what we send and of what we receive signed: by pymavlink, not by us. Keys are hexadecimal.

station_peer.py receive [KEY]   a ground station: its port on the first line, then a line of JSON for each message, until standard
                                input ends. With a key what is not rightly signed is a line with `error`.
station_peer.py sign KEY        frames in hexadecimal, a line each: what is expected of the receiver, then the frame.
station_peer.py verify KEY      frames in hexadecimal on standard input; a line for each: ok or refused.
"""

import json
import math
import select
import socket
import sys
import time

from pymavlink.dialects.v20 import ardupilotmega as mavlink

EPOCH_S = 1420070400  # 2015-01-01


def now():
    return int((time.time() - EPOCH_S) * 1e5)


def parser(key):
    link = mavlink.MAVLink(None, srcSystem=255, srcComponent=190)
    if key:
        link.signing.secret_key = bytes.fromhex(key)
        link.signing.timestamp = now()
    return link


def signer(key, link_id, timestamp, component=1):
    link = mavlink.MAVLink(None, srcSystem=1, srcComponent=component)
    link.signing.secret_key = bytes.fromhex(key)
    link.signing.link_id = link_id
    link.signing.timestamp = timestamp
    link.signing.sign_outgoing = True
    return link


def attitude(link, ms, roll=0.0, **how):
    frame = link.attitude_encode(ms, roll, 0.0, 0.0, 0.0, 0.0, 0.0).pack(link, **how)
    link.seq = (link.seq + 1) % 256
    return frame


def field(value):
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def receive(key):
    port = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    port.bind(("127.0.0.1", 0))
    print(port.getsockname()[1], flush=True)
    link = parser(key)
    while True:
        ready = select.select([port, sys.stdin], [], [])[0]
        if port not in ready:
            return
        frame = port.recv(2048)
        line = {"at": time.monotonic(), "id": int.from_bytes(frame[7:10], "little"), "signed": bool(frame[2] & 1)}
        line["timestamp"] = int.from_bytes(frame[-12:-6], "little") if line["signed"] else None
        line["link"] = frame[-13] if line["signed"] else None
        try:
            for message in link.parse_buffer(frame) or []:
                line |= {"system": message.get_srcSystem(), "component": message.get_srcComponent(), "name": message.get_type()}
                line["fields"] = {name: field(getattr(message, name)) for name in message.get_fieldnames()}
        except mavlink.MAVError as error:
            line["error"] = str(error)
        print(json.dumps(line), flush=True)


def sign(key):
    other = "ff" * 32
    then = now()
    link = signer(key, 5, then)
    say = lambda what, frame: print(what, frame.hex())
    first = attitude(link, 1000)
    say("accepted", first)
    say("accepted", attitude(link, 1020))
    held = attitude(link, 1040)
    say("accepted", attitude(link, 1060))
    say("not-later", held)  # out of order
    say("not-later", first)  # replayed
    say("wrong-signature", attitude(signer(other, 5, then + 1000), 1080))
    plain = mavlink.MAVLink(None, srcSystem=1, srcComponent=1)
    say("unsigned", attitude(plain, 1100))
    say("version-1", attitude(plain, 1120, force_mavlink1=True))
    say("behind", attitude(signer(key, 6, then - 6100000), 1140))
    say("accepted", attitude(signer(key, 6, then - 5000000), 1160))
    say("accepted", attitude(signer(key, 5, then - 5000000, component=2), 1180))
    damaged = bytearray(attitude(link, 1200))
    damaged[-13] ^= 1  # the link id, which no checksum covers
    say("wrong-signature", bytes(damaged))
    say("accepted", attitude(link, 1220))


def verify(key):
    link = parser(key)
    for line in sys.stdin:
        try:
            messages = link.parse_buffer(bytes.fromhex(line.strip())) or []
            print("ok" if len(messages) == 1 else "refused", flush=True)
        except mavlink.MAVError:
            print("refused", flush=True)


{"receive": receive, "sign": sign, "verify": verify}[sys.argv[1]](*(sys.argv[2:] or [None]))
