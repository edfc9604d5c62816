//! The flight models of the paper's section 4: descent, level and climb at 100 kn, whose Dutch rolls it prints.
//!
//! Lateral derivatives: Dutch-roll roots and N_p as printed, the others chosen between the simulation's and what the paper says
//! of them (roll damping three quarters of the simulation's, N_r -0.5), L_v and N_v solved so that the root of the lateral
//! subsystem is the printed one in the trim that is flown. The trim, the longitudinal equations and the pilot's other controls
//! are the Level-1 Puma's at 1.024 kg/m^3; there are no cross terms.

use nalgebra::{Complex, Matrix4};
use sideslip::dynamics::linear::state_matrix;
use sideslip::flight::derivative::{Axis, Variable};
use sideslip::flight::file::model_file::ModelFile;
use sideslip::flight::model::LinearModel;
use sideslip::simulation::flight_model::{FlightModel, FlightRequest};

/// Airspeed, m/s, and density, kg/m^3.
pub(crate) const SPEED: f64 = 51.44;
pub(crate) const DENSITY: f64 = 1.024;

/// One of the three.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PaperCase {
    pub(crate) name: &'static str,
    /// Climb rate, m/s: 1000 ft/min.
    pub(crate) climb: f64,
    /// The printed root, and the printed N_p.
    pub(crate) root: (f64, f64),
    pub(crate) n_p: f64,
    pub(crate) y_v: f64,
    pub(crate) l_p: f64,
    /// L_v and N_v of the set that was solved for level attitude; those flown are within a few percent.
    pub(crate) l_v: f64,
    pub(crate) n_v: f64,
    /// Y, L, N of the lateral cyclic and of the pedal (tail rotor).
    pub(crate) lat_cyclic: [f64; 3],
    pub(crate) pedal: [f64; 3],
}

/// Descent, level, climb.
pub(crate) const PAPER: [PaperCase; 3] = [
    PaperCase {
        name: "descent",
        climb: -5.08,
        root: (-0.17, 1.37),
        n_p: -0.213,
        y_v: -0.135,
        l_p: -1.30,
        l_v: -0.047_409,
        n_v: 0.028_991,
        lat_cyclic: [9.37, 18.208, 1.968],
        pedal: [4.17, 2.08, -7.866],
    },
    PaperCase {
        name: "level",
        climb: 0.0,
        root: (-0.118, 1.53),
        n_p: -0.246,
        y_v: -0.138,
        l_p: -1.34,
        l_v: -0.061_452,
        n_v: 0.038_969,
        lat_cyclic: [9.66, 18.512, 2.0],
        pedal: [4.18, 2.08, -7.866],
    },
    PaperCase {
        name: "climb",
        climb: 5.08,
        root: (0.052, 1.45),
        n_p: -0.295,
        y_v: -0.141,
        l_p: -1.38,
        l_v: -0.094_000,
        n_v: 0.031_650,
        lat_cyclic: [9.95, 18.824, 2.032],
        pedal: [4.18, 2.08, -7.8755],
    },
];

const Y_P: f64 = -0.79;
const L_R: f64 = 0.12;
const N_R: f64 = -0.5;

impl PaperCase {
    /// The Level-1 Puma in this flight.
    pub(crate) fn simulation(&self) -> FlightModel {
        let asked =
            FlightRequest { speed: Some(SPEED), climb: Some(self.climb), density: Some(DENSITY), ..FlightRequest::default() };
        FlightModel::puma(&asked).unwrap()
    }

    /// The model that is flown.
    pub(crate) fn model(&self) -> LinearModel {
        let level1 = self.simulation();
        let mut model = LinearModel::about(level1.linear().trim);
        let longitudinal = [Variable::U, Variable::W, Variable::Q, Variable::LonCyclic, Variable::Collective];
        for axis in [Axis::X, Axis::Z, Axis::M] {
            for variable in longitudinal {
                *model.derivative_mut(axis, variable) = level1.linear().derivative(axis, variable);
            }
        }
        for (place, axis) in [Axis::Y, Axis::L, Axis::N].into_iter().enumerate() {
            *model.derivative_mut(axis, Variable::LatCyclic) = self.lat_cyclic[place];
            *model.derivative_mut(axis, Variable::Pedal) = self.pedal[place];
        }
        // v' holds -u0 r beside Y_r r: together -V r, as the set has it.
        for (axis, variable, value) in [
            (Axis::Y, Variable::V, self.y_v),
            (Axis::Y, Variable::P, Y_P),
            (Axis::Y, Variable::R, model.trim.u - SPEED),
            (Axis::L, Variable::P, self.l_p),
            (Axis::L, Variable::R, L_R),
            (Axis::N, Variable::P, self.n_p),
            (Axis::N, Variable::R, N_R),
        ] {
            *model.derivative_mut(axis, variable) = value;
        }
        // det(A - lambda) = 0 is linear in the column of v: two real equations for L_v and N_v.
        let at = |l_v: f64, n_v: f64| {
            let mut model = model.clone();
            *model.derivative_mut(Axis::L, Variable::V) = l_v;
            *model.derivative_mut(Axis::N, Variable::V) = n_v;
            characteristic(&model, Complex::new(self.root.0, self.root.1))
        };
        let (f, f_l, f_n) = (at(0.0, 0.0), at(1.0, 0.0) - at(0.0, 0.0), at(0.0, 1.0) - at(0.0, 0.0));
        let determinant = f_l.re * f_n.im - f_l.im * f_n.re;
        *model.derivative_mut(Axis::L, Variable::V) = (f.im * f_n.re - f.re * f_n.im) / determinant;
        *model.derivative_mut(Axis::N, Variable::V) = (f_l.im * f.re - f_l.re * f.im) / determinant;
        model
    }

    /// As a model file.
    pub(crate) fn model_file(&self) -> String {
        ModelFile::of(&format!("puma-100kn-{}", self.name), self.model()).to_toml()
    }
}

/// det(A - lambda) of the lateral subsystem v p phi r.
fn characteristic(model: &LinearModel, lambda: Complex<f64>) -> Complex<f64> {
    let a = state_matrix(model);
    let lateral = Matrix4::from_fn(|i, j| {
        let entry = Complex::new(a[(4 + i, 4 + j)], 0.0);
        if i == j { entry - lambda } else { entry }
    });
    lateral.determinant()
}
