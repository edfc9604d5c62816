//! The names under which numbers go to a ground station: one table, which `src/guide/use.md` repeats.
//!
//! A name has at most ten letters. Each number of [`NUMBERS`] is sent as its value, under its name, and as its standard error,
//! under the name with [`STANDARD_ERROR`] behind it; each status of [`STATUSES`] as the code of [`Status::rank`], or
//! [`SILENT`].

use crate::flight::channel::ControlNames;
use crate::flight::derivative::{Axis, Variable};
use crate::realtime::modes::record::{ModesRecord, OscillatoryMode, RealRoot};
use crate::realtime::regression::record::{DerivativesRecord, EquationRecord, Status};

/// What the name of a standard error ends with.
pub const STANDARD_ERROR: &str = "_se";
/// The status where no run goes on, or its samples have stopped: below all of [`Status::rank`].
pub const SILENT: f32 = -1.0;

/// Where a number stands in the records.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NumberSource {
    /// Undamped natural frequency of a pair of roots, rad/s.
    Frequency(Pair),
    /// Its damping ratio.
    Damping(Pair),
    /// Roll subsidence, 1/s.
    Roll,
    /// Spiral, 1/s.
    Spiral,
    /// A derivative, SI and radians.
    Derivative(Axis, Variable),
}

/// A pair of roots.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pair {
    /// Dutch roll of the lateral subsystem.
    DutchRoll,
    /// Dutch roll of all six axes, coupled.
    Coupled,
    /// Lateral phugoid.
    LateralPhugoid,
}

/// A number with its names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NamedNumber {
    /// Its name where the controls are called as a rotorcraft's.
    pub rotorcraft: &'static str,
    /// Its name where they are called as an aeroplane's.
    pub fixed_wing: &'static str,
    /// Where it stands.
    pub source: NumberSource,
}

/// The status of what.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StatusSource {
    /// Of the modes.
    Modes,
    /// Of the equation of an axis.
    Equation(Axis),
}

const fn number(name: &'static str, source: NumberSource) -> NamedNumber {
    NamedNumber { rotorcraft: name, fixed_wing: name, source }
}

const fn motion(name: &'static str, axis: Axis, variable: Variable) -> NamedNumber {
    number(name, NumberSource::Derivative(axis, variable))
}

const fn control(rotorcraft: &'static str, fixed_wing: &'static str, axis: Axis, variable: Variable) -> NamedNumber {
    NamedNumber { rotorcraft, fixed_wing, source: NumberSource::Derivative(axis, variable) }
}

/// How many numbers have a name.
pub const NUMBERS_NAMED: usize = 31;

/// Every number that is sent, in the order of sending.
pub const NUMBERS: [NamedNumber; NUMBERS_NAMED] = [
    number("DR_wn", NumberSource::Frequency(Pair::DutchRoll)),
    number("DR_zeta", NumberSource::Damping(Pair::DutchRoll)),
    number("D6_wn", NumberSource::Frequency(Pair::Coupled)),
    number("D6_zeta", NumberSource::Damping(Pair::Coupled)),
    number("LP_wn", NumberSource::Frequency(Pair::LateralPhugoid)),
    number("LP_zeta", NumberSource::Damping(Pair::LateralPhugoid)),
    number("roll", NumberSource::Roll),
    number("spiral", NumberSource::Spiral),
    motion("Y_v", Axis::Y, Variable::V),
    motion("Y_p", Axis::Y, Variable::P),
    motion("Y_r", Axis::Y, Variable::R),
    control("Y_ped", "Y_rud", Axis::Y, Variable::Pedal),
    motion("L_v", Axis::L, Variable::V),
    motion("L_p", Axis::L, Variable::P),
    motion("L_r", Axis::L, Variable::R),
    control("L_lat", "L_ail", Axis::L, Variable::LatCyclic),
    control("L_ped", "L_rud", Axis::L, Variable::Pedal),
    motion("N_v", Axis::N, Variable::V),
    motion("N_p", Axis::N, Variable::P),
    motion("N_r", Axis::N, Variable::R),
    control("N_lat", "N_ail", Axis::N, Variable::LatCyclic),
    control("N_ped", "N_rud", Axis::N, Variable::Pedal),
    motion("X_u", Axis::X, Variable::U),
    motion("X_w", Axis::X, Variable::W),
    motion("Z_w", Axis::Z, Variable::W),
    control("Z_lon", "Z_ele", Axis::Z, Variable::LonCyclic),
    control("Z_col", "Z_thr", Axis::Z, Variable::Collective),
    motion("M_u", Axis::M, Variable::U),
    motion("M_w", Axis::M, Variable::W),
    motion("M_q", Axis::M, Variable::Q),
    control("M_lon", "M_ele", Axis::M, Variable::LonCyclic),
];

/// Every status that is sent, in the order of sending.
pub const STATUSES: [(&str, StatusSource); 7] = [
    ("DR_status", StatusSource::Modes),
    ("X_status", StatusSource::Equation(Axis::X)),
    ("Y_status", StatusSource::Equation(Axis::Y)),
    ("Z_status", StatusSource::Equation(Axis::Z)),
    ("L_status", StatusSource::Equation(Axis::L)),
    ("M_status", StatusSource::Equation(Axis::M)),
    ("N_status", StatusSource::Equation(Axis::N)),
];

impl NamedNumber {
    /// Its name on an aircraft.
    pub const fn name(&self, controls: ControlNames) -> &'static str {
        match controls {
            ControlNames::Rotorcraft => self.rotorcraft,
            ControlNames::FixedWing => self.fixed_wing,
        }
    }
}

/// Whether there are numbers under that status.
fn has_numbers(status: Status) -> bool {
    status.rank() >= Status::Stale.rank()
}

impl NumberSource {
    /// Value and standard error; `None` where there is no number, or none that single precision holds.
    pub fn find(self, modes: Option<&ModesRecord>, derivatives: Option<&DerivativesRecord>) -> Option<[f32; 2]> {
        let modes = modes.filter(|modes| has_numbers(modes.status));
        let found = match self {
            NumberSource::Frequency(pair) => pair.of(modes?).map(|mode| [mode.omega, mode.std_omega]),
            NumberSource::Damping(pair) => pair.of(modes?).map(|mode| [mode.zeta, mode.std_zeta]),
            NumberSource::Roll => modes?.roll.map(root),
            NumberSource::Spiral => modes?.spiral.map(root),
            NumberSource::Derivative(axis, variable) => {
                let equation = equation(derivatives?, axis).filter(|equation| has_numbers(equation.status))?;
                let resolved = equation.unresolved_variables().all(|unresolved| unresolved != variable);
                equation.term(variable).filter(|_| resolved).map(|term| [term.value, term.std])
            }
        };
        let single = found?.map(|number| number as f32);
        single.iter().all(|number| number.is_finite()).then_some(single)
    }
}

impl Pair {
    fn of(self, modes: &ModesRecord) -> Option<OscillatoryMode> {
        match self {
            Pair::DutchRoll => modes.dutch_roll,
            Pair::Coupled => modes.coupled,
            Pair::LateralPhugoid => modes.lateral_phugoid,
        }
    }
}

impl StatusSource {
    /// The status as a number; [`SILENT`] where there is no record.
    pub fn code(self, modes: Option<&ModesRecord>, derivatives: Option<&DerivativesRecord>) -> f32 {
        let status = match self {
            StatusSource::Modes => modes.map(|modes| modes.status),
            StatusSource::Equation(axis) => derivatives.and_then(|record| equation(record, axis)).map(|one| one.status),
        };
        status.map_or(SILENT, |status| f32::from(status.rank()))
    }
}

fn root(root: RealRoot) -> [f64; 2] {
    [root.value, root.std]
}

fn equation(derivatives: &DerivativesRecord, axis: Axis) -> Option<&EquationRecord> {
    derivatives.equations.iter().find(|equation| equation.axis == axis)
}

#[cfg(test)]
mod tests {
    use super::super::message::NAME;
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn every_name_fits_and_is_given_once() {
        for controls in [ControlNames::Rotorcraft, ControlNames::FixedWing] {
            let numbers = NUMBERS.iter().flat_map(|number| {
                let name = number.name(controls);
                [name.to_owned(), format!("{name}{STANDARD_ERROR}")]
            });
            let names: Vec<String> = numbers.chain(STATUSES.iter().map(|(name, _)| (*name).to_owned())).collect();
            assert!(names.iter().all(|name| (1..=NAME).contains(&name.len()) && name.is_ascii()), "{names:?}");
            assert_eq!(names.iter().collect::<BTreeSet<_>>().len(), names.len(), "{names:?}");
            // A derivative is called as everywhere, cut after three letters of the control.
            for number in NUMBERS {
                let NumberSource::Derivative(axis, variable) = number.source else { continue };
                let whole = format!("{}_{}", axis.name(), variable.name(controls));
                assert!(whole.starts_with(number.name(controls)), "{whole}");
            }
        }
    }

    #[test]
    fn the_guide_has_every_name() {
        let page = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/src/guide/use.md")).unwrap();
        let names = NUMBERS.iter().flat_map(|number| [number.rotorcraft, number.fixed_wing]);
        for name in names.chain(STATUSES.iter().map(|(name, _)| *name)) {
            assert!(page.contains(&format!("`{name}`")), "{name} is not in the guide");
        }
    }
}
