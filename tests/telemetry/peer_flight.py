#!/usr/bin/env python3
"""A simulated flight in logs of autopilots, as pymavlink's DFReader and pyulog read them, against its run file.

    peer_flight.py RUN.csv RUN.bin RUN.ulg

Prints a line for each log and channel: how many values, and the largest difference from the run file at the same time, SI and
radians. Units are converted here, by what the documentation of the two autopilots says; the scale of the controls is read from
the logs' parameters.
"""
import csv
import math
import sys

from pymavlink import DFReader
from pyulog import ULog

CONTROLS = {'LON': 'lon_cyclic', 'LAT': 'lat_cyclic', 'COL': 'collective', 'PED': 'pedal'}


def truth(path):
    """The run file: rows by their time in microseconds."""
    with open(path) as file:
        rows = csv.DictReader(line for line in file if not line.startswith('#'))
        return {round(1e6 * float(row['time'])): row for row in rows}


class Differences:
    def __init__(self, name, rows):
        self.name, self.rows, self.largest, self.counts = name, rows, {}, {}

    def take(self, time_us, channel, value):
        if math.isnan(value):
            return
        difference = value - float(self.rows[time_us][channel])
        if channel == 'psi':
            difference = (difference + math.pi) % (2 * math.pi) - math.pi
        self.largest[channel] = max(self.largest.get(channel, 0.0), abs(difference))
        self.counts[channel] = self.counts.get(channel, 0) + 1

    def report(self):
        for channel, count in self.counts.items():
            print(self.name, channel, count, f'{self.largest[channel]:.3e}')


def density(pressure):
    """kg/m^3 and m of the standard atmosphere below 11 km."""
    temperature = 288.15 * (pressure / 101325.0) ** (287.05287 * 0.0065 / 9.80665)
    return pressure / (287.05287 * temperature), (288.15 - temperature) / 0.0065


def angle(parameters, short, outputs):
    scale = {what: parameters[f'SIDESLIP_{short}_{what}'] for what in ('OUT', 'MID', 'DEG')}
    return math.radians((outputs[round(scale['OUT']) - 1] - scale['MID']) * scale['DEG'])


def dataflash(path, differences):
    log = DFReader.DFReader_binary(path)
    parameters, rho = {}, None
    while (message := log.recv_msg()) is not None:
        kind = message.get_type()
        if kind == 'PARM':
            parameters[message.Name] = message.Value
        if kind not in ('IMU', 'ATT', 'AOA', 'BARO', 'ARSP', 'RCOU', 'RPM'):
            continue
        at = message.TimeUS
        if kind == 'IMU':
            for channel, field in zip(('p', 'q', 'r', 'ax', 'ay', 'az'), ('GyrX', 'GyrY', 'GyrZ', 'AccX', 'AccY', 'AccZ')):
                differences.take(at, channel, getattr(message, field))
        elif kind == 'ATT':
            for channel, field in (('phi', 'Roll'), ('theta', 'Pitch'), ('psi', 'Yaw')):
                differences.take(at, channel, math.radians(getattr(message, field)))
        elif kind == 'AOA':
            differences.take(at, 'alpha', math.radians(message.AOA))
            differences.take(at, 'beta', math.radians(message.SSA))
        elif kind == 'BARO':
            rho, height = density(message.Press)
            differences.take(at, 'altitude', height)
        elif kind == 'ARSP':
            differences.take(at, 'tas', message.Airspeed * math.sqrt(1.225 / rho))
        elif kind == 'RCOU':
            outputs = [message.C1, message.C2, message.C3, message.C4]
            for short, channel in CONTROLS.items():
                differences.take(at, channel, angle(parameters, short, outputs))
        else:
            differences.take(at, 'rotor_speed', message.RPM * 2 * math.pi / 60)
    differences.report()


def ulog(path, differences):
    log = ULog(path)
    assert not log.file_corruption and not log.dropouts
    for topic in log.data_list:
        data, times = topic.data, [int(time) for time in topic.data['timestamp']]

        def take(channel, values):
            for at, value in zip(times, values):
                differences.take(at, channel, float(value))

        if topic.name == 'sensor_combined':
            for axis, (rate, force) in enumerate((('p', 'ax'), ('q', 'ay'), ('r', 'az'))):
                take(rate, data[f'gyro_rad[{axis}]'])
                take(force, data[f'accelerometer_m_s2[{axis}]'])
        elif topic.name == 'vehicle_attitude':
            w, x, y, z = (data[f'q[{part}]'].astype(float) for part in range(4))
            take('phi', [math.atan2(2 * (a * b + c * d), 1 - 2 * (b * b + c * c)) for a, b, c, d in zip(w, x, y, z)])
            take('theta', [math.asin(2 * (a * c - d * b)) for a, b, c, d in zip(w, x, y, z)])
            take('psi', [math.atan2(2 * (a * d + b * c), 1 - 2 * (c * c + d * d)) for a, b, c, d in zip(w, x, y, z)])
        elif topic.name == 'vehicle_air_data':
            take('altitude', [density(float(pressure))[1] for pressure in data['baro_pressure_pa']])
        elif topic.name == 'airspeed':
            take('tas', data['true_airspeed_m_s'])
        elif topic.name == 'rpm':
            take('rotor_speed', [float(rpm) * 2 * math.pi / 60 for rpm in data['rpm_raw']])
        elif topic.name == 'debug_vect':
            assert bytes(int(data[f'name[{place}]'][0]) for place in range(4)) == b'flow'
            take('alpha', data['x'])
            take('beta', data['y'])
        elif topic.name == 'actuator_servos':
            outputs = list(zip(*(data[f'control[{place}]'] for place in range(8))))
            for short, channel in CONTROLS.items():
                take(channel, [angle(log.initial_parameters, short, row) for row in outputs])
        else:
            raise SystemExit(f'unexpected topic {topic.name}')
    differences.report()


if __name__ == '__main__':
    flight = truth(sys.argv[1])
    dataflash(sys.argv[2], Differences('bin', flight))
    ulog(sys.argv[3], Differences('ulg', flight))
