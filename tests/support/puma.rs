//! The Puma's published matrices as linear models, read in place.
//!
//! Source: Padfield, "Helicopter Flight Dynamics", 2nd ed. (2007), appendix 4B. States u w q theta v p phi r, inputs
//! theta0 theta1s theta1c theta0T; 1 kn is 0.5148 m/s there, g is 9.81 m/s^2. X_q, Y_p, Y_r, Z_q of the matrices hold
//! -We, +We, -Ue, +Ue, which belong to the kinematics and are taken out here.

use sideslip::flight::derivative::{Axis, Variable};
use sideslip::flight::model::{LinearModel, Trim};
use std::path::PathBuf;

/// The book's knot, m/s.
pub(crate) const BOOK_KNOT: f64 = 0.5148;

/// The book's gravity, m/s^2.
pub(crate) const BOOK_GRAVITY: f64 = 9.81;

/// Published matrices at one speed.
pub(crate) struct PublishedPuma {
    /// Airspeed, m/s.
    pub(crate) airspeed: f64,
    /// A, rows and columns as in the source.
    pub(crate) a: [[f64; 8]; 8],
    /// B, rows as A, columns collective, longitudinal, lateral cyclic, tail rotor.
    pub(crate) b: [[f64; 4]; 8],
}

/// The published matrices at one of 0, 20, ... 140 kn, level; `None`, said loudly, where the file is absent.
pub(crate) fn published_puma(knots: u32) -> Option<PublishedPuma> {
    let path: PathBuf =
        [env!("CARGO_MANIFEST_DIR"), "..", "shared", "reference", "puma", "helisim_puma_AB.json"].iter().collect();
    let Ok(text) = std::fs::read_to_string(&path) else {
        eprintln!("SKIPPED: {} is absent", path.display());
        return None;
    };
    let document: serde_json::Value = serde_json::from_str(&text).ok()?;
    let speed = knots.to_string();
    Some(PublishedPuma {
        airspeed: f64::from(knots) * BOOK_KNOT,
        a: serde_json::from_value(document["A"][&speed].clone()).ok()?,
        b: serde_json::from_value(document["B"][&speed].clone()).ok()?,
    })
}

const ROWS: [(Axis, usize); 6] = [(Axis::X, 0), (Axis::Z, 1), (Axis::M, 2), (Axis::Y, 4), (Axis::L, 5), (Axis::N, 7)];
const COLUMNS: [(Variable, usize); 6] =
    [(Variable::U, 0), (Variable::W, 1), (Variable::Q, 2), (Variable::V, 4), (Variable::P, 5), (Variable::R, 7)];
const INPUTS: [(Variable, usize); 4] =
    [(Variable::Collective, 0), (Variable::LonCyclic, 1), (Variable::LatCyclic, 2), (Variable::Pedal, 3)];

impl PublishedPuma {
    /// Trim out of the gravity entries, (w, phi) over (u, theta) giving sin(phi) and (w, theta) giving sin(theta);
    /// level without sideslip, so that `w = u tan(theta) / cos(phi)`. The controls are taken as
    /// zero: the source does not give them here.
    pub(crate) fn trim(&self) -> Trim {
        let phi = (self.a[1][6] / self.a[0][3]).asin();
        let theta = (-self.a[1][3] / (BOOK_GRAVITY * phi.cos())).asin();
        let slope = theta.tan() / phi.cos();
        let u = self.airspeed / (1.0 + slope * slope).sqrt();
        Trim { u, v: 0.0, w: u * slope, phi, theta, rotor_speed: Some(27.0), controls: [0.0; 4] }
    }

    /// The linear model with these matrices.
    pub(crate) fn model(&self) -> LinearModel {
        let trim = self.trim();
        let mut model = LinearModel::about(trim);
        for (axis, row) in ROWS {
            for (variable, column) in COLUMNS {
                *model.derivative_mut(axis, variable) = self.a[row][column];
            }
            for (variable, column) in INPUTS {
                *model.derivative_mut(axis, variable) = self.b[row][column];
            }
        }
        *model.derivative_mut(Axis::X, Variable::Q) += trim.w;
        *model.derivative_mut(Axis::Y, Variable::P) -= trim.w;
        *model.derivative_mut(Axis::Y, Variable::R) += trim.u;
        *model.derivative_mut(Axis::Z, Variable::Q) -= trim.u;
        model
    }
}

/// The Puma at 100 kn, level; `None`, said loudly, where the source is absent.
pub(crate) fn puma_100kn() -> Option<LinearModel> {
    published_puma(100).map(|published| published.model())
}
