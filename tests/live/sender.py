"""Plays a run file as MAVLink 2 over UDP, at its own pace, as the telemetry of an autopilot: by pymavlink, not by us.

Call: sender.py RUN.csv HOST PORT [KEY]. A line a flight on standard output: how many rows were sent. With a key (hexadecimal) it is
signed, and once a second of the flight five frames follow that a receiver must refuse: unsigned, MAVLink 1, signed with another
key, replayed, and the first of a stream two minutes behind; their bank angle is one that no aircraft flies.
"""

import csv
import math
import socket
import sys
import time

from pymavlink.dialects.v20 import ardupilotmega as mavlink

NAN = float("nan")
INERTIAL = 0x3F  # the fields of HIGHRES_IMU that are filled in: acceleration and rates
CONTROLS = ("lat_cyclic", "lon_cyclic", "collective", "pedal")  # servo outputs 1 to 4


class Port:
    """What pymavlink writes its frames to."""

    def __init__(self, host, port):
        self.address = (host, port)
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)

    def write(self, frame):
        self.sent = frame
        self.socket.sendto(frame, self.address)


def sign(link, key, timestamp):
    link.signing.secret_key = key
    link.signing.link_id = 1
    link.signing.timestamp = timestamp
    link.signing.sign_outgoing = True


def hostile(port, key, link, ms):
    """What a receiver with the key must refuse."""
    bank = lambda other, **how: other.attitude_send(ms, 2.5, 0.0, 0.0, 0.0, 0.0, 0.0, **how)
    port.write(port.sent)
    plain, forged, behind = (mavlink.MAVLink(port, srcSystem=1, srcComponent=component) for component in (1, 1, 77))
    bank(plain)
    bank(plain, force_mavlink1=True)
    sign(forged, bytes(32 - len(b"forged")) + b"forged", link.signing.timestamp + 50)
    bank(forged)
    sign(behind, key, link.signing.timestamp - 2 * 6000000)
    bank(behind)


def pulse(angle):
    """1500 us is zero, 500 us are 10 degrees."""
    return round(1500 + math.degrees(angle) / 10 * 500)


def main(path, host, number, key=None):
    port = Port(host, int(number))
    link = mavlink.MAVLink(port, srcSystem=1, srcComponent=1)
    if key:
        key = bytes.fromhex(key)
        sign(link, key, int((time.time() - 1420070400) * 1e5))
    with open(path, newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    begun, beat = time.monotonic(), -math.inf
    for row in rows:
        value = {name: float(text) for name, text in row.items() if text}
        seconds = value["time"]
        time.sleep(max(0.0, begun + seconds - time.monotonic()))
        if seconds - beat >= 1.0:
            if key and beat >= 0.0:
                hostile(port, key, link, round(seconds * 1e3))
            beat = seconds
            link.heartbeat_send(
                mavlink.MAV_TYPE_HELICOPTER, mavlink.MAV_AUTOPILOT_GENERIC, 0, 0, mavlink.MAV_STATE_ACTIVE
            )
        us = round(seconds * 1e6)
        rates = [value[name] for name in ("p", "q", "r")]
        forces = [value[name] for name in ("ax", "ay", "az")]
        link.highres_imu_send(us, *forces, *rates, NAN, NAN, NAN, NAN, NAN, NAN, NAN, INERTIAL)
        link.attitude_send(us // 1000, value["phi"], value["theta"], value["psi"], *rates)
        link.airspeed_send(0, value["tas"], 0, NAN, 0)
        link.aoa_ssa_send(us, math.degrees(value["alpha"]), math.degrees(value["beta"]))
        link.servo_output_raw_send(us % 2**32, 0, *(pulse(value[name]) for name in CONTROLS), 0, 0, 0, 0)
    print(len(rows))


main(*sys.argv[1:])
