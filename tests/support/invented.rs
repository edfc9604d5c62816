//! Aircraft as linear models, invented, with derivatives of a usual size: a slow light aircraft with strong adverse yaw, a
//! helicopter with weak weathercock stability whose planes are coupled, a light helicopter whose roll rate follows sideslip, yaw
//! rate, pitch rate and incidence, and a glider with a fast roll mode.

use sideslip::flight::file::model_file::ModelFile;
use sideslip::flight::model::LinearModel;

const LIGHT_AIRCRAFT: &str = r#"
name = "light aircraft"
kind = "linear"
[trim]
u = 31.8
w = 3.5
theta = 0.11
[trim.controls]
elevator = -0.04
throttle = 0.5
[derivatives.X]
u = -0.06
w = 0.18
throttle = 2.5
[derivatives.Y]
v = -0.19
r = 0.25
rudder = 2.2
[derivatives.Z]
u = -0.58
w = -2.3
q = -1.0
elevator = -3.0
[derivatives.L]
v = -0.11
p = -7.5
r = 2.6
aileron = -11.0
rudder = 0.4
[derivatives.M]
w = -0.16
q = -3.8
elevator = -9.0
[derivatives.N]
v = 0.075
p = -0.75
r = -0.95
aileron = 1.9
rudder = -3.2
"#;

const HELICOPTER: &str = r#"
name = "helicopter"
kind = "linear"
[trim]
u = 30.8
w = -0.3
phi = -0.02
theta = -0.01
rotor_speed = 40.0
[trim.controls]
collective = 0.2
pedal = 0.1
[derivatives.X]
u = -0.03
w = 0.03
q = 0.6
lon_cyclic = -8.0
collective = 2.0
[derivatives.Y]
v = -0.07
p = -0.6
r = 0.2
lat_cyclic = 8.0
pedal = 2.5
[derivatives.Z]
u = -0.05
w = -0.6
lon_cyclic = -10.0
collective = -70.0
[derivatives.L]
v = -0.05
p = -3.4
q = 0.9
r = 0.15
lat_cyclic = 55.0
pedal = -1.5
[derivatives.M]
u = 0.01
w = 0.008
p = -0.25
q = -1.6
lon_cyclic = 25.0
collective = 4.0
[derivatives.N]
v = 0.007
p = -0.12
r = -0.45
lat_cyclic = 3.0
pedal = -6.0
collective = 3.0
"#;

const LIGHT_HELICOPTER: &str = r#"
name = "light helicopter"
kind = "linear"
[trim]
u = 42.0
w = -0.4
phi = -0.03
theta = -0.01
rotor_speed = 45.0
[trim.controls]
collective = 0.2
pedal = 0.1
[derivatives.X]
u = -0.03
w = 0.02
q = 0.7
lon_cyclic = -7.0
[derivatives.Y]
v = -0.11
p = -0.5
r = 0.15
lat_cyclic = 9.0
pedal = 4.0
[derivatives.Z]
u = -0.05
w = -0.8
lon_cyclic = -18.0
collective = -90.0
[derivatives.L]
u = 0.01
v = -0.09
w = -0.05
p = -4.1
q = -1.2
r = 0.2
lat_cyclic = 40.0
pedal = 2.5
[derivatives.M]
u = 0.02
w = 0.008
p = 0.4
q = -1.4
lon_cyclic = 18.0
collective = 5.0
[derivatives.N]
v = 0.065
w = 0.01
p = -0.3
r = -0.65
lat_cyclic = 1.5
pedal = -11.0
collective = 3.0
"#;

const GLIDER: &str = r#"
name = "glider"
kind = "linear"
[trim]
u = 25.0
w = 0.8
theta = 0.01
[trim.controls]
elevator = -0.02
[derivatives.X]
u = -0.03
w = 0.12
[derivatives.Y]
v = -0.15
rudder = 1.5
[derivatives.Z]
u = -0.6
w = -3.0
elevator = -4.0
[derivatives.L]
v = -0.06
p = -9.0
r = 2.0
aileron = -20.0
rudder = 0.3
[derivatives.M]
w = -0.15
q = -4.0
elevator = -8.0
[derivatives.N]
v = 0.06
p = -0.5
r = -0.6
aileron = 1.0
rudder = -2.5
"#;

const HIGH_ASPECT_RATIO: &str = r#"
name = "high aspect ratio"
kind = "linear"
[trim]
u = 18.0
w = 0.9
theta = 0.04
[trim.controls]
elevator = -0.02
throttle = 0.4
[derivatives.X]
u = -0.05
w = 0.15
throttle = 1.5
[derivatives.Y]
v = -0.1
rudder = 0.8
[derivatives.Z]
u = -0.9
w = -3.2
elevator = -2.5
[derivatives.L]
v = -0.08
p = -7.0
r = 3.5
aileron = -6.0
rudder = 0.2
[derivatives.M]
w = -0.12
q = -3.0
elevator = -6.0
[derivatives.N]
v = 0.04
p = -0.9
r = -0.35
aileron = 0.7
rudder = -1.2
"#;

const UNMANNED: &str = r#"
name = "unmanned"
kind = "linear"
[trim]
u = 20.0
w = 0.7
theta = 0.03
[trim.controls]
elevator = -0.01
throttle = 0.5
[derivatives.X]
u = -0.15
w = 0.4
throttle = 6.0
[derivatives.Y]
v = -0.6
rudder = 3.0
[derivatives.Z]
u = -1.0
w = -4.5
elevator = -6.0
[derivatives.L]
v = -1.0
p = -16.0
r = 3.0
aileron = -90.0
rudder = 4.0
[derivatives.M]
w = -1.0
q = -6.0
elevator = -60.0
[derivatives.N]
v = 0.8
p = -1.0
r = -1.8
aileron = 3.0
rudder = -15.0
"#;

/// The light aircraft.
pub(crate) fn light_aircraft() -> LinearModel {
    ModelFile::parse(LIGHT_AIRCRAFT).unwrap().linear
}

/// The helicopter.
pub(crate) fn helicopter() -> LinearModel {
    ModelFile::parse(HELICOPTER).unwrap().linear
}

/// The light helicopter: after an input of pedal or collective alone its motions are nearly combinations of each other.
pub(crate) fn light_helicopter() -> LinearModel {
    ModelFile::parse(LIGHT_HELICOPTER).unwrap().linear
}

/// The glider.
pub(crate) fn glider() -> LinearModel {
    ModelFile::parse(GLIDER).unwrap().linear
}

/// The aircraft of high aspect ratio: slow, with a roll mode of 7 1/s and little weathercock stability.
pub(crate) fn high_aspect_ratio() -> LinearModel {
    ModelFile::parse(HIGH_ASPECT_RATIO).unwrap().linear
}

/// The small unmanned aeroplane: a roll mode of 16 1/s.
pub(crate) fn unmanned() -> LinearModel {
    ModelFile::parse(UNMANNED).unwrap().linear
}
