//! Nondimensional derivatives of an identified model, with the reference dimensions, mass and inertia that its runs state.
//!
//! Consumes derivatives (forces over mass, m/s^2; moments over inertia, rad/s^2; per m/s, rad/s or rad) with their covariance,
//! airspeed V and density rho of the trim; produces, of a wing with area S, span b, chord c, with qS = rho V^2 S/2, body axes,
//!     CX_x = m X_x s_x/qS     CY_x = m Y_x s_x/qS     CZ_x = m Z_x s_x/qS                                        (1)
//!     Cl_x = (Ixx L_x - Ixz N_x) s_x/(qS b)   Cn_x = (Izz N_x - Ixz L_x) s_x/(qS b)   Cm_x = Iyy M_x s_x/(qS c)  (2)
//! with s_x = V for u (over V), v (beta = v/V) and w (alpha = w/V), 2V/b for p and r, 2V/c for q, 1 for controls; of a rotor with
//! radius R and tip speed Vt, in units of R and R/Vt,
//!     x_x = X_x s_x R/Vt^2 (y, z alike)     l_x = L_x s_x (R/Vt)^2 (m, n alike)                                    (3)
//! with s_x = Vt for velocities, Vt/R for rates, 1 for controls: mass and inertia stay within.
//! Source: V. Klein and E. A. Morelli, Aircraft System Identification, 2006, section 3.4, for (1), (2); (3) is the dimensional
//! analysis alone, as A. R. S. Bramwell, Helicopter Dynamics, 1976, ch. 5 has time and lengths.
//! Standard errors are those of the derivatives with S, b, c, m, I, rho and V taken as known. Returns no numbers, with the
//! reason, where a quantity is not stated or runs state different ones; `None` where no run states reference dimensions.

use super::columns::Columns;
use super::identify::IdentificationResult;
use super::model_variables::is_control;
use super::test_condition::TestCondition;
use crate::dynamics::atmosphere::density_at;
use crate::flight::derivative::Axis;
use crate::flight::run::{AircraftProperties, Inertia, ReferenceDimensions};

/// One of them.
#[derive(Clone, Debug, PartialEq)]
pub struct NondimensionalDerivative {
    /// `Cn_beta` of a wing, `n_v` of a rotor.
    pub name: String,
    /// Its value.
    pub value: f64,
    /// Its standard error.
    pub std: f64,
}

/// All of a model.
#[derive(Clone, Debug, PartialEq)]
pub struct NondimensionalDerivatives {
    /// What they are formed with.
    pub reference: ReferenceDimensions,
    /// Density of the air, kg/m^3, and the altitude, m, at which the standard atmosphere has it; NaN where the runs record the
    /// density. `None` where they are formed without it.
    pub density: Option<(f64, f64)>,
    /// The derivatives, in the order of the model's.
    pub derivatives: Vec<NondimensionalDerivative>,
    /// Why some or all are missing, a sentence each.
    pub missing: Vec<String>,
}

/// What (1) and (2) take besides the dimensions.
struct WingFlight {
    span_m: f64,
    chord_m: f64,
    speed: f64,
    /// rho V^2 S/2, N.
    force: f64,
    mass_kg: Option<f64>,
    inertia: Option<Inertia>,
}

/// Forms the derivatives of a model that was fitted to these runs.
pub fn nondimensional(identified: &IdentificationResult, runs: &[Columns]) -> Option<NondimensionalDerivatives> {
    let stated: Vec<&AircraftProperties> = runs.iter().map(|run| &run.properties).collect();
    let reference = stated.iter().find_map(|one| one.reference)?;
    let mut all = NondimensionalDerivatives { reference, density: None, derivatives: Vec::new(), missing: Vec::new() };
    if stated.iter().any(|one| one.reference != Some(reference)) {
        all.missing.push("expected the same `reference` of every run, found different ones".to_owned());
        return Some(all);
    }
    let speed = identified.linear.reference_trim.airspeed;
    if !(speed > 0.0) {
        all.missing.push("expected the true airspeed `tas` in the trim, found none".to_owned());
        return Some(all);
    }
    let model = DimensionalModel { identified, speed };
    match reference {
        ReferenceDimensions::Rotor { radius_m, tip_speed_mps } => model.of_rotor(&mut all, radius_m, tip_speed_mps),
        ReferenceDimensions::Wing { area_m2, span_m, chord_m } => {
            let conditions: Vec<TestCondition> = runs.iter().map(TestCondition::of).collect();
            let TestCondition { density, altitude, .. } = TestCondition::mean(&conditions);
            let (density, altitude) = if density.is_finite() { (density, f64::NAN) } else { (density_at(altitude), altitude) };
            if !(density > 0.0) {
                all.missing.push("expected a channel `rho` or `altitude`, which give the density, found none".to_owned());
                return Some(all);
            }
            all.density = Some((density, altitude));
            let force = 0.5 * density * speed * speed * area_m2;
            let (mass_kg, inertia) = (mean(stated.iter().map(|one| one.mass_kg)), mean_inertia(&stated));
            model.of_wing(&mut all, &WingFlight { span_m, chord_m, speed, force, mass_kg, inertia });
        }
    }
    Some(all)
}

/// Mean over the runs; `None` where one does not state it.
fn mean(values: impl Iterator<Item = Option<f64>>) -> Option<f64> {
    let values: Vec<f64> = values.collect::<Option<_>>()?;
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

fn mean_inertia(stated: &[&AircraftProperties]) -> Option<Inertia> {
    let of = |part: fn(&Inertia) -> f64| mean(stated.iter().map(|one| one.inertia.as_ref().map(part)));
    Some(Inertia { xx: of(|i| i.xx)?, yy: of(|i| i.yy)?, zz: of(|i| i.zz)?, xz: of(|i| i.xz)? })
}

/// Derivatives per m/s, rad/s and rad.
struct DimensionalModel<'a> {
    identified: &'a IdentificationResult,
    speed: f64,
}

impl DimensionalModel<'_> {
    fn names(&self) -> impl Iterator<Item = (usize, Axis, &str)> {
        let all = self.identified.linear.derivatives.iter().enumerate();
        all.filter_map(|(place, (axis, variable))| {
            Some((place, Axis::from_name(axis.encode_utf8(&mut [0; 4]))?, variable.as_str()))
        })
    }

    /// Factor from the model's own form to m/s^2: an equation of a flow angle is over airspeed.
    fn row(&self, axis: Axis) -> f64 {
        let has = |name: &str| self.identified.linear.choice.states.iter().any(|state| state == name);
        match axis {
            Axis::Y if has("beta") => self.speed,
            Axis::Z if has("alpha") => self.speed,
            _ => 1.0,
        }
    }

    fn estimate(&self, place: usize) -> (f64, f64) {
        let at = |values: &[f64]| values.get(place).copied().unwrap_or(f64::NAN);
        (at(&self.identified.fitted.theta), at(&self.identified.fitted.std))
    }

    fn of_rotor(&self, all: &mut NondimensionalDerivatives, radius_m: f64, tip_speed_mps: f64) {
        let omega = tip_speed_mps / radius_m;
        for (place, axis, variable) in self.names() {
            let scale = match variable {
                "u" | "v" | "w" => tip_speed_mps,
                "beta" | "alpha" => tip_speed_mps / self.speed,
                "p" | "q" | "r" => omega,
                control if is_control(control) => 1.0,
                other => {
                    all.missing.push(no_scale(axis, other));
                    continue;
                }
            };
            let unit = if axis.is_force() { tip_speed_mps * omega } else { omega * omega };
            let factor = self.row(axis) * scale / unit;
            let (value, std) = self.estimate(place);
            let of = match variable {
                "beta" => "v",
                "alpha" => "w",
                own => own,
            };
            let name = format!("{}_{of}", axis.name().to_lowercase());
            all.derivatives.push(NondimensionalDerivative { name, value: value * factor, std: std * factor });
        }
    }

    fn of_wing(&self, all: &mut NondimensionalDerivatives, flight: &WingFlight) {
        let has = |forces: bool| self.names().any(|(_, axis, _)| axis.is_force() == forces);
        if flight.mass_kg.is_none() && has(true) {
            all.missing.push("coefficients of force: expected `mass_kg` of every run, found none".to_owned());
        }
        if flight.inertia.is_none() && has(false) {
            all.missing.push("coefficients of moment: expected `inertia_kgm2` of every run, found none".to_owned());
        }
        for (place, axis, variable) in self.names() {
            let (scale, of) = match variable {
                "u" | "v" | "w" => (flight.speed, variable.replace('v', "beta").replace('w', "alpha")),
                "beta" | "alpha" => (1.0, variable.to_owned()),
                "p" | "r" => (2.0 * flight.speed / flight.span_m, variable.to_owned()),
                "q" => (2.0 * flight.speed / flight.chord_m, variable.to_owned()),
                control if is_control(control) => (1.0, control.to_owned()),
                other => {
                    all.missing.push(no_scale(axis, other));
                    continue;
                }
            };
            let (name, value, std) = if axis.is_force() {
                let Some(mass_kg) = flight.mass_kg else { continue };
                let factor = mass_kg * self.row(axis) * scale / flight.force;
                let (value, std) = self.estimate(place);
                (format!("C{}_{of}", axis.name()), value * factor, std * factor)
            } else {
                let Some(inertia) = flight.inertia else { continue };
                let length_m = if axis == Axis::M { flight.chord_m } else { flight.span_m };
                let Some((value, std)) = self.moment(axis, variable, place, inertia) else {
                    let other = if axis == Axis::L { Axis::N } else { Axis::L };
                    let (axis, other) = (axis.name(), other.name());
                    all.missing.push(format!("{axis}_{variable}: expected {other}_{variable} beside it for the part of Ixz"));
                    continue;
                };
                let factor = scale / (flight.force * length_m);
                (format!("C{}_{of}", axis.name().to_lowercase()), value * factor, std * factor)
            };
            all.derivatives.push(NondimensionalDerivative { name, value, std });
        }
    }

    /// The moment itself per unit of the variable, N m, with its standard error; `None` without the other lateral one, which Ixz
    /// couples to it.
    fn moment(&self, axis: Axis, variable: &str, place: usize, inertia: Inertia) -> Option<(f64, f64)> {
        let (value, std) = self.estimate(place);
        let (own, other) = match axis {
            Axis::L => (inertia.xx, Axis::N),
            Axis::N => (inertia.zz, Axis::L),
            _ => return Some((inertia.yy * value, inertia.yy * std)),
        };
        if inertia.xz == 0.0 {
            return Some((own * value, own * std));
        }
        let (beside, ..) = self.names().find(|(_, axis, name)| *axis == other && *name == variable)?;
        let (other_value, _) = self.estimate(beside);
        let cov = |i: usize, j: usize| self.identified.fitted.cov[(i, j)];
        let variance = own * own * cov(place, place) + inertia.xz * inertia.xz * cov(beside, beside)
            - 2.0 * own * inertia.xz * cov(place, beside);
        Some((own * value - inertia.xz * other_value, libm::sqrt(variance.max(0.0))))
    }
}

fn no_scale(axis: Axis, variable: &str) -> String {
    format!("{}_{variable}: `{variable}` has no nondimensional form", axis.name())
}
