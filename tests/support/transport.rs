//! A transport aircraft at 100 m/s as a linear model: invented derivatives of a usual size, with a stable Dutch roll of
//! 1.8 rad/s. Its side force is small beside what rotation makes of the sideslip, and a thrust of 3 m/s^2 per unit changes
//! its speed.

use sideslip::flight::file::model_file::ModelFile;
use sideslip::flight::model::LinearModel;

const TEXT: &str = r#"
name = "transport"
kind = "linear"
[trim]
u = 99.6
w = 8.7
theta = 0.087
[trim.controls]
elevator = -0.02
throttle = 0.3
[derivatives.X]
u = -0.01
w = 0.06
throttle = 3.0
[derivatives.Y]
v = -0.12
r = 0.3
rudder = 3.0
[derivatives.Z]
u = -0.19
w = -0.75
q = -2.0
elevator = -6.0
[derivatives.L]
v = -0.032
p = -2.1
r = 0.95
aileron = -6.0
rudder = 0.9
[derivatives.M]
w = -0.045
q = -1.6
elevator = -6.5
[derivatives.N]
v = 0.029
p = -0.18
r = -0.42
aileron = -0.3
rudder = -1.7
"#;

/// The model.
pub(crate) fn transport() -> LinearModel {
    ModelFile::parse(TEXT).unwrap().linear
}
