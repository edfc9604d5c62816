//! Sensors whose position on the aircraft matters to what they read.

/// An instrument whose position matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PositionedSensor {
    /// The three accelerometers.
    Accelerometer,
    /// The flow-angle vanes.
    Vane,
}

impl PositionedSensor {
    /// Both.
    pub const ALL: [PositionedSensor; 2] = [PositionedSensor::Accelerometer, PositionedSensor::Vane];

    /// The name in files.
    pub const fn name(self) -> &'static str {
        match self {
            PositionedSensor::Accelerometer => "accelerometer",
            PositionedSensor::Vane => "vane",
        }
    }
}
