//! The `[level1]` table of a model file: aircraft data, options and the flight condition of the trim.
//!
//! Consumes the table; produces [`DeclaredAircraft`]. All keys except the engine's torque limit are required and no others
//! allowed, so that no datum is taken from another helicopter by default; errors carry line and column.

use super::actuator::Actuator;
use super::aircraft::{Level1, MassProperties, Perturbation};
use super::engine::Engine;
use super::fin::Fin;
use super::fuselage::{Fuselage, PiecewiseLines};
use super::hub::Hub;
use super::internal_states::{Flapping, Options};
use super::rotor::MainRotor;
use super::tail_rotor::TailRotor;
use super::tailplane::Tailplane;
use super::trim::TrimCondition;
use crate::flight::channel::ControlNames;
use crate::flight::control::Control;
use crate::flight::file::toml_reader::{TomlEntry, TomlError, TomlTable};

/// What a `[level1]` table declares.
#[derive(Clone, Debug, PartialEq)]
pub struct DeclaredAircraft {
    /// The aircraft with its options.
    pub aircraft: Level1,
    /// The flight condition where nobody asks for another.
    pub condition: TrimCondition,
}

const PARTS: [&str; 11] = [
    "flight",
    "options",
    "body",
    "main_rotor",
    "tail_rotor",
    "fin",
    "tailplane",
    "fuselage",
    "engine",
    "actuators",
    "perturbation",
];

/// Keys of `[level1.options]`.
pub const OPTIONS: [&str; 6] = ["hub", "flapping", "inflow", "rotor_speed", "actuators", "perturbation"];

/// The one key that may be left out, of `[level1.engine]`.
pub(crate) const TORQUE_LIMIT: &str = "torque_limit";

pub(crate) fn read(table: &TomlTable<'_>) -> Result<DeclaredAircraft, TomlError> {
    table.allow_only(&PARTS)?;
    let part = |name: &str, keys: &[&str]| -> Result<TomlTable<'_>, TomlError> {
        let part = table.require(name)?.table(&format!("[level1.{name}]"))?;
        part.allow_only(keys)?;
        Ok(part)
    };
    let options = part("options", &OPTIONS)?;
    let aircraft = Level1 {
        body: body(&part("body", &["mass", "ixx", "iyy", "izz", "ixz", "cg_forward"])?)?,
        hub: choose(&options, "hub", &[("published", Hub::Published), ("exact", Hub::Exact)])?,
        main_rotor: main_rotor(&part("main_rotor", &MAIN_ROTOR)?)?,
        tail_rotor: tail_rotor(&part("tail_rotor", &TAIL_ROTOR)?)?,
        fin: fin(&part("fin", &["area", "aft", "height", "incidence", "gain", "cubic", "quintic", "hold"])?)?,
        tailplane: tailplane(&part("tailplane", &["area", "aft", "incidence", "gain", "cubic", "hold", "downwash"])?)?,
        fuselage: fuselage(&part("fuselage", &FUSELAGE)?)?,
        engine: engine(&part("engine", &["full_torque", "droop", "lag_fuel", "lag_engine", "lead", "inertia", TORQUE_LIMIT])?)?,
        actuators: actuators(&part("actuators", &Control::ALL.map(|control| control.name(ControlNames::Rotorcraft)))?)?,
        perturbation: perturbation(&part("perturbation", &["velocity", "rate", "control"])?)?,
        options: read_options(&options)?,
    };
    let flight = part("flight", &["speed", "climb", "sideslip", "density"])?;
    let condition = TrimCondition {
        speed: not_negative(&flight, "speed")?,
        climb: number(&flight, "climb")?,
        sideslip: number(&flight, "sideslip")?,
        density: positive(&flight, "density")?,
    };
    Ok(DeclaredAircraft { aircraft, condition })
}

fn number(table: &TomlTable<'_>, key: &str) -> Result<f64, TomlError> {
    table.require(key)?.number()
}

fn positive(table: &TomlTable<'_>, key: &str) -> Result<f64, TomlError> {
    table.require(key)?.positive()
}

fn not_negative(table: &TomlTable<'_>, key: &str) -> Result<f64, TomlError> {
    table.require(key)?.not_negative()
}

fn choose<T: Copy>(table: &TomlTable<'_>, key: &str, choices: &[(&str, T)]) -> Result<T, TomlError> {
    let entry = table.require(key)?;
    match choices.iter().find(|(name, _)| entry.text() == Ok(*name)) {
        Some(&(_, choice)) => Ok(choice),
        None => Err(entry.choice("a choice", &choices.iter().map(|&(name, _)| name).collect::<Vec<_>>())),
    }
}

fn read_options(table: &TomlTable<'_>) -> Result<Options, TomlError> {
    let flapping =
        [("quasi_steady", Flapping::QuasiSteady), ("first_order", Flapping::FirstOrder), ("second_order", Flapping::SecondOrder)];
    Ok(Options {
        flapping: choose(table, "flapping", &flapping)?,
        dynamic_inflow: choose(table, "inflow", &[("quasi_steady", false), ("dynamic", true)])?,
        governed: choose(table, "rotor_speed", &[("held", false), ("governed", true)])?,
        actuators: choose(table, "actuators", &[("ideal", false), ("first_order", true)])?,
        finite_perturbation: choose(table, "perturbation", &[("small", false), ("finite", true)])?,
    })
}

fn body(table: &TomlTable<'_>) -> Result<MassProperties, TomlError> {
    let body = MassProperties {
        mass: positive(table, "mass")?,
        ixx: positive(table, "ixx")?,
        iyy: positive(table, "iyy")?,
        izz: positive(table, "izz")?,
        ixz: number(table, "ixz")?,
        cg_forward: number(table, "cg_forward")?,
    };
    if !(body.ixz * body.ixz < body.ixx * body.izz) {
        let what = format_args!("expected less than sqrt(ixx izz) in magnitude, found {}", body.ixz);
        return Err(table.require("ixz")?.misread(what));
    }
    Ok(body)
}

const MAIN_ROTOR: [&str; 13] = [
    "rotation",
    "radius",
    "chord",
    "blades",
    "lift_slope",
    "drag_0",
    "drag_2",
    "twist",
    "speed",
    "flap_inertia",
    "flap_stiffness",
    "shaft_tilt",
    "height",
];

fn main_rotor(table: &TomlTable<'_>) -> Result<MainRotor, TomlError> {
    Ok(MainRotor {
        direction: choose(table, "rotation", &[("clockwise", -1.0), ("anticlockwise", 1.0)])?,
        radius: positive(table, "radius")?,
        chord: positive(table, "chord")?,
        blades: table.require("blades")?.whole(1.0, 32.0)?,
        lift_slope: positive(table, "lift_slope")?,
        drag_0: not_negative(table, "drag_0")?,
        drag_2: not_negative(table, "drag_2")?,
        twist: number(table, "twist")?,
        speed: positive(table, "speed")?,
        flap_inertia: positive(table, "flap_inertia")?,
        flap_stiffness: not_negative(table, "flap_stiffness")?,
        shaft_tilt: number(table, "shaft_tilt")?,
        height: number(table, "height")?,
    })
}

const TAIL_ROTOR: [&str; 12] = [
    "radius",
    "gearing",
    "lift_slope",
    "solidity",
    "drag_0",
    "drag_2",
    "aft",
    "height",
    "pitch_flap_coupling",
    "flap_ratio",
    "blockage",
    "downwash",
];

fn tail_rotor(table: &TomlTable<'_>) -> Result<TailRotor, TomlError> {
    Ok(TailRotor {
        radius: positive(table, "radius")?,
        gearing: positive(table, "gearing")?,
        lift_slope: positive(table, "lift_slope")?,
        solidity: positive(table, "solidity")?,
        drag_0: not_negative(table, "drag_0")?,
        drag_2: not_negative(table, "drag_2")?,
        aft: number(table, "aft")?,
        height: number(table, "height")?,
        pitch_flap_coupling: coupling(table)?,
        flap_ratio: not_negative(table, "flap_ratio")?,
        blockage: positive(table, "blockage")?,
        downwash: number(table, "downwash")?,
    })
}

/// A positive coupling would raise pitch with flap: the disc could run away, and the inflow's equation lose its slope.
fn coupling(table: &TomlTable<'_>) -> Result<f64, TomlError> {
    let entry = table.require("pitch_flap_coupling")?;
    match entry.number()? {
        value if value <= 0.0 => Ok(value),
        value => Err(entry.misread(format_args!("expected zero or less, found {value}"))),
    }
}

fn fin(table: &TomlTable<'_>) -> Result<Fin, TomlError> {
    Ok(Fin {
        area: not_negative(table, "area")?,
        aft: number(table, "aft")?,
        height: number(table, "height")?,
        incidence: number(table, "incidence")?,
        gain: number(table, "gain")?,
        cubic: number(table, "cubic")?,
        quintic: number(table, "quintic")?,
        hold: positive(table, "hold")?,
    })
}

fn tailplane(table: &TomlTable<'_>) -> Result<Tailplane, TomlError> {
    Ok(Tailplane {
        area: not_negative(table, "area")?,
        aft: number(table, "aft")?,
        incidence: number(table, "incidence")?,
        gain: number(table, "gain")?,
        cubic: number(table, "cubic")?,
        hold: positive(table, "hold")?,
        downwash: number(table, "downwash")?,
    })
}

const FUSELAGE: [&str; 18] = [
    "plan_area",
    "side_area",
    "length",
    "downwash",
    "reference_speed",
    "reference_density",
    "near_limit_deg",
    "far_limit_deg",
    "near_x",
    "near_z",
    "near_m",
    "near_y",
    "near_n",
    "far_x",
    "far_z",
    "far_m",
    "far_y",
    "far_n",
];

fn fuselage(table: &TomlTable<'_>) -> Result<Fuselage, TomlError> {
    let (near_limit, far_limit) = (positive(table, "near_limit_deg")?, positive(table, "far_limit_deg")?);
    if !(far_limit > near_limit) {
        let what = format_args!("expected more than near_limit_deg ({near_limit}), found {far_limit}");
        return Err(table.require("far_limit_deg")?.misread(what));
    }
    let near = |key: &str| -> Result<[f64; 4], TomlError> { table.require(key)?.numbers() };
    let far = |key: &str| lines(&table.require(key)?);
    Ok(Fuselage {
        plan_area: not_negative(table, "plan_area")?,
        side_area: not_negative(table, "side_area")?,
        length: not_negative(table, "length")?,
        downwash: number(table, "downwash")?,
        reference_speed: positive(table, "reference_speed")?,
        reference_density: positive(table, "reference_density")?,
        limits: (near_limit.to_radians(), far_limit.to_radians()),
        near: [near("near_x")?, near("near_z")?, near("near_m")?, near("near_y")?, near("near_n")?],
        far: [far("far_x")?, far("far_z")?, far("far_m")?, far("far_y")?, far("far_n")?],
    })
}

/// Points whose angles, degrees, increase.
fn lines(entry: &TomlEntry<'_>) -> Result<PiecewiseLines, TomlError> {
    let points = entry.pairs()?;
    for ([before, _], [angle, _]) in points.iter().zip(points.iter().skip(1)) {
        if !(angle > before) {
            return Err(entry.misread(format_args!("expected angles that increase, found {angle} after {before}")));
        }
    }
    if points.is_empty() {
        return Err(entry.misread("expected points [angle, coefficient], found none"));
    }
    Ok(points.into_iter().map(|[angle, value]| [angle.to_radians(), value]).collect())
}

fn engine(table: &TomlTable<'_>) -> Result<Engine, TomlError> {
    Ok(Engine {
        full_torque: positive(table, "full_torque")?,
        droop: positive(table, "droop")?,
        lag_fuel: positive(table, "lag_fuel")?,
        lag_engine: positive(table, "lag_engine")?,
        lead: not_negative(table, "lead")?,
        inertia: positive(table, "inertia")?,
        torque_limit: table.find(TORQUE_LIMIT).map(|entry| entry.positive()).transpose()?,
    })
}

fn actuators(table: &TomlTable<'_>) -> Result<[Actuator; 4], TomlError> {
    let mut actuators = [Actuator { tau: 0.0, rate: 0.0 }; 4];
    for (control, place) in Control::ALL.into_iter().zip(&mut actuators) {
        let name = control.name(ControlNames::Rotorcraft);
        let own = table.require(name)?.table(&format!("[level1.actuators.{name}]"))?;
        own.allow_only(&["tau", "rate"])?;
        *place = Actuator { tau: positive(&own, "tau")?, rate: positive(&own, "rate")? };
    }
    Ok(actuators)
}

fn perturbation(table: &TomlTable<'_>) -> Result<Perturbation, TomlError> {
    Ok(Perturbation {
        velocity: positive(table, "velocity")?,
        rate: positive(table, "rate")?,
        control: positive(table, "control")?,
    })
}
