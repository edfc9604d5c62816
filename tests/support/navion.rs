//! The Navion, a light fixed-wing aircraft, as a linear model at sea level and 176 ft/s.
//!
//! Source: derivatives after R. C. Nelson, "Flight Stability and Automatic Control", 2nd ed. (1998), appendix B, brought to SI and
//! to body axes; the moment by the rate of w counts as damping in pitch. Elevator, aileron and rudder stand in the places of the
//! longitudinal and lateral cyclic and the pedal.

use sideslip::flight::file::model_file::ModelFile;
use sideslip::flight::model::LinearModel;

const TEXT: &str = r#"
name = "navion"
kind = "linear"
[trim]
u = 53.64
theta = 0.0
[derivatives.X]
u = -0.045
w = 0.036
[derivatives.Z]
u = -0.369
w = -2.02
lon_cyclic = -8.58
[derivatives.M]
w = -0.164
q = -2.96
lon_cyclic = -11.87
[derivatives.Y]
v = -0.254
pedal = 3.79
[derivatives.L]
v = -0.2987
p = -8.40
r = 2.19
lat_cyclic = 28.98
pedal = 2.55
[derivatives.N]
v = 0.0837
p = -0.35
r = -0.76
lat_cyclic = -0.222
pedal = -4.60
"#;

/// The model.
pub(crate) fn navion() -> LinearModel {
    ModelFile::parse(TEXT).unwrap().linear
}
