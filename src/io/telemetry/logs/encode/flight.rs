//! A simulated flight whose channels are known in closed form, as a dataflash log and as a ULog.
//!
//! Consumes a duration and rates; produces bytes, and the truth at any time ([`FlightTruth`]). Every channel is an oscillation
//! of its own about a level of its own: the values mean nothing but are distinguishable. Both logs state times of whole
//! microseconds.

use super::LogEncodeError;
use super::dataflash::{DataflashCell, DataflashWriter};
use super::ulog::UlogWriter;

/// Microseconds since start at the first sample.
pub const START_US: u64 = 20_000_000;

/// The channels at a time, SI and radians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlightTruth {
    /// Specific force, m/s^2.
    pub force: [f64; 3],
    /// Rates, rad/s.
    pub rates: [f64; 3],
    /// Bank, pitch attitude, heading, rad.
    pub attitude: [f64; 3],
    /// Incidence and sideslip, rad.
    pub flow: [f64; 2],
    /// Airspeed as indicated at sea-level density, m/s.
    pub indicated: f64,
    /// Static pressure, Pa.
    pub pressure: f64,
    /// Commands to four servos, us.
    pub servos: [f64; 4],
}

impl FlightTruth {
    /// The channels so long after the first sample, s.
    pub fn at(time_s: f64) -> Self {
        let wave = |level: f64, size: f64, omega: f64| level + size * libm::sin(omega * time_s);
        FlightTruth {
            force: [wave(0.3, 0.2, 1.1), wave(-0.1, 0.5, 1.7), wave(-9.8, 1.5, 2.3)],
            rates: [wave(0.01, 0.3, 3.1), wave(-0.02, 0.2, 2.3), wave(0.005, 0.1, 1.9)],
            attitude: [wave(0.05, 0.2, 1.3), wave(0.08, 0.1, 0.9), wave(2.0, 0.3, 0.4)],
            flow: [wave(0.06, 0.03, 2.3), wave(0.01, 0.05, 1.9)],
            indicated: wave(22.0, 1.5, 0.5),
            pressure: wave(94_000.0, 40.0, 0.3),
            servos: [wave(1500.0, 120.0, 1.3), wave(1480.0, 90.0, 2.3), wave(1350.0, 30.0, 0.4), wave(1510.0, 100.0, 1.9)],
        }
    }
}

/// How long, and how often each instrument is written, Hz.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SimulatedFlight {
    /// s.
    pub duration_s: f64,
    /// Gyros and accelerometers.
    pub imu_hz: f64,
    /// Attitude and servos.
    pub attitude_hz: f64,
    /// Airspeed, flow angles, pressure.
    pub air_hz: f64,
}

/// What is due at a time.
#[derive(Clone, Copy, Debug)]
enum Due {
    Imu,
    Attitude,
    Air,
}

impl SimulatedFlight {
    /// Every sample's time after the first, us, in order.
    fn schedule(&self) -> Vec<(u64, Due)> {
        let mut all = Vec::new();
        for (rate, due) in [(self.imu_hz, Due::Imu), (self.attitude_hz, Due::Attitude), (self.air_hz, Due::Air)] {
            let mut count = 0_u32;
            while rate > 0.0 && f64::from(count) / rate < self.duration_s {
                #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "positive and below 2^53")]
                all.push(((f64::from(count) / rate * 1e6) as u64, due));
                count += 1;
            }
        }
        all.sort_by_key(|(time_us, _)| *time_us);
        all
    }

    /// The flight as ArduPilot writes it.
    ///
    /// # Errors
    /// Never for rates that are finite.
    pub fn dataflash(&self) -> Result<Vec<u8>, LogEncodeError> {
        let mut writer = DataflashWriter::new();
        let labels = [('s', "s"), ('#', "instance"), ('E', "rad/s"), ('o', "m/s/s"), ('d', "deg"), ('n', "m/s")];
        let more = [('h', "degheading"), ('P', "Pa"), ('m', "m"), ('Y', "us"), ('-', ""), ('O', "degC")];
        writer.tables(&[labels, more].concat(), &[('F', 1e-6), ('0', 1.0), ('B', 0.01), ('-', 0.0)])?;
        let definitions = [
            (1, "IMU", "QBffffff", "TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ", "s#EEEooo", "F-000000"),
            (2, "ATT", "QccC", "TimeUS,Roll,Pitch,Yaw", "sddh", "FBBB"),
            (3, "AOA", "Qff", "TimeUS,AOA,SSA", "sdd", "F00"),
            (4, "ARSP", "QBfBB", "TimeUS,I,Airspeed,H,U", "s#n--", "F-0--"),
            (5, "BARO", "QBffc", "TimeUS,I,Alt,Press,Temp", "s#mPO", "F-00B"),
            (6, "RCOU", "QHHHH", "TimeUS,C1,C2,C3,C4", "sYYYY", "F----"),
        ];
        for (kind, name, characters, columns, units, multipliers) in definitions {
            writer.define(kind, name, characters, columns)?;
            writer.units(kind, units, multipliers)?;
        }
        let number = DataflashCell::Number;
        for (after_us, due) in self.schedule() {
            let truth = FlightTruth::at(after_us as f64 / 1e6);
            let time = DataflashCell::Whole(START_US + after_us);
            let first = DataflashCell::Whole(0);
            match due {
                Due::Imu => {
                    let [x, y, z] = truth.rates.map(number);
                    let [ax, ay, az] = truth.force.map(number);
                    writer.message(1, &[time, first, x, y, z, ax, ay, az])?;
                }
                Due::Attitude => {
                    let [phi, theta, psi] = truth.attitude.map(|angle| number(angle.to_degrees()));
                    writer.message(2, &[time, phi, theta, psi])?;
                    let [a, b, c, d] = truth.servos.map(number);
                    writer.message(6, &[time, a, b, c, d])?;
                }
                Due::Air => {
                    let [alpha, beta] = truth.flow.map(|angle| number(angle.to_degrees()));
                    writer.message(3, &[time, alpha, beta])?;
                    writer.message(5, &[time, first, number(0.0), number(truth.pressure), number(21.5)])?;
                    let healthy = DataflashCell::Whole(1);
                    writer.message(4, &[time, first, number(truth.indicated), healthy, healthy])?;
                }
            }
        }
        Ok(writer.bytes().to_vec())
    }

    /// The flight as PX4 writes it; a place to begin at before every hundredth sample.
    ///
    /// # Errors
    /// Never for rates that are finite.
    pub fn ulog(&self) -> Result<Vec<u8>, LogEncodeError> {
        let mut writer = UlogWriter::new(START_US);
        let formats = [
            "sensor_combined:uint64_t timestamp;float[3] gyro_rad;int32_t accelerometer_timestamp_relative;\
             float[3] accelerometer_m_s2;uint8_t[4] _padding0;",
            "vehicle_attitude:uint64_t timestamp;float[4] q;",
            "airspeed:uint64_t timestamp;float indicated_airspeed_m_s;float true_airspeed_m_s;",
            "vehicle_air_data:uint64_t timestamp;uint64_t timestamp_sample;float baro_pressure_pa;float rho;",
            "actuator_outputs:uint64_t timestamp;uint32_t noutputs;float[16] output;uint8_t[4] _padding0;",
        ];
        // The first subscription ends the definitions.
        formats.iter().try_for_each(|format| writer.format(format))?;
        for (id, format) in (0..).zip(formats) {
            writer.subscribe(0, id, format.split(':').next().unwrap_or_default())?;
        }
        let single = |values: &[f64]| -> Vec<u8> {
            #[expect(clippy::cast_possible_truncation, reason = "the nearest single-precision number is meant")]
            values.iter().flat_map(|value| (*value as f32).to_le_bytes()).collect()
        };
        for (count, (after_us, due)) in self.schedule().into_iter().enumerate() {
            if count % 100 == 0 {
                writer.sync();
            }
            let truth = FlightTruth::at(after_us as f64 / 1e6);
            let time = (START_US + after_us).to_le_bytes();
            match due {
                Due::Imu => {
                    writer.data(0, &[&time, &single(&truth.rates), &0_i32.to_le_bytes(), &single(&truth.force)])?;
                }
                Due::Attitude => {
                    writer.data(1, &[&time, &single(&quaternion(truth.attitude))])?;
                    let mut outputs = [0.0; 16];
                    outputs.iter_mut().zip(truth.servos).for_each(|(output, servo)| *output = servo);
                    writer.data(4, &[&time, &4_u32.to_le_bytes(), &single(&outputs)])?;
                }
                Due::Air => {
                    writer.data(2, &[&time, &single(&[truth.indicated, 1.05 * truth.indicated])])?;
                    let later = (START_US + after_us + 1500).to_le_bytes();
                    writer.data(3, &[&later, &time, &single(&[truth.pressure, 1.13])])?;
                }
            }
        }
        Ok(writer.bytes().to_vec())
    }
}

/// The quaternion (w, x, y, z) that turns body axes into north, east, down, of bank, pitch attitude and heading.
pub fn quaternion([phi, theta, psi]: [f64; 3]) -> [f64; 4] {
    let [(sr, cr), (sp, cp), (sy, cy)] = [phi, theta, psi].map(|angle| (libm::sin(angle / 2.0), libm::cos(angle / 2.0)));
    [cr * cp * cy + sr * sp * sy, sr * cp * cy - cr * sp * sy, cr * sp * cy + sr * cp * sy, cr * cp * sy - sr * sp * cy]
}
