//! The model file: a linear model (or a Level-1 aircraft) with its name, tolerance and effects, as TOML.
//!
//! Consumes a text; produces a [`ModelFile`]; writes one back. A misspelt derivative, axis, control or key is an error
//! with line and column, what was found and the nearest valid name. `u` and `theta` of `[trim]` are required, its other
//! entries are zero where absent (the rotor speed is then unknown). Of `[derivatives.N]` the keys are variables
//! (`v`, `pedal`), nonlinear terms (`"v*|v|"`) and `rotor_speed`. Of `[tolerance.N]` they are variables, and the values the
//! standard errors of these derivatives, as an identification found them.

use super::effect_file::{DeclaredEffect, Naming, read_effects};
use super::toml_reader::{TomlEntry, TomlError, TomlTable, TomlText};
use crate::flight::channel::ControlNames;
use crate::flight::control::Control;
use crate::flight::derivative::{AXES, Axis, VARIABLES, Variable};
use crate::flight::effect::Effect;
use crate::flight::model::{LinearModel, Trim};
use crate::flight::term::{Term, TermError};
use std::fmt::Write;

/// How far off (relative) every derivative may be before it counts as wrong, where a file does not say.
pub const DEFAULT_TOLERANCE: f64 = 0.03;

/// A model file's contents.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelFile {
    /// What the file calls the model; empty where it does not say.
    pub name: String,
    /// The model without its effects.
    pub linear: LinearModel,
    /// Relative tolerance of every derivative.
    pub tolerance: f64,
    /// Standard errors of the derivatives by axis and variable, the derivatives' units; zero where the file says nothing.
    pub stds: [[f64; VARIABLES]; AXES],
    /// Effects in the order of the file.
    pub effects: Vec<DeclaredEffect>,
    /// How the file calls the controls.
    pub controls: ControlNames,
}

impl ModelFile {
    /// Its effects, without their standard errors.
    pub fn own_effects(&self) -> Vec<Effect> {
        self.effects.iter().map(|declared| declared.effect).collect()
    }

    /// A model without effects, with the default tolerance.
    pub fn of(name: &str, linear: LinearModel) -> Self {
        ModelFile {
            name: name.to_owned(),
            linear,
            tolerance: DEFAULT_TOLERANCE,
            stds: [[0.0; VARIABLES]; AXES],
            effects: Vec::new(),
            controls: ControlNames::Rotorcraft,
        }
    }

    /// Reads a model file's text.
    ///
    /// # Errors
    /// [`TomlError`] with the first wrong place; a file of kind `level1` has no linear model of its own and is refused.
    pub fn parse(text: &str) -> Result<Self, TomlError> {
        let refuse = |table: &TomlTable<'_>| -> Result<(), TomlError> {
            Err(table.misread("expected a model of kind `linear` here, found one of kind `level1`"))
        };
        Ok(ModelFile::parse_either(text, refuse)?.0)
    }

    /// Reads a model file of either kind. What `[level1]` holds is read by the one who knows it; the linear model of such a
    /// file is empty.
    ///
    /// # Errors
    /// [`TomlError`] with the first wrong place.
    pub(crate) fn parse_either<T>(
        text: &str,
        read_level1: impl FnOnce(&TomlTable<'_>) -> Result<T, TomlError>,
    ) -> Result<(Self, Option<T>), TomlError> {
        let root = TomlText(text).parse()?;
        let root = TomlTable::root(TomlText(text), &root);
        let kind = root.require("kind")?;
        let naming = Naming::default();
        let (linear, level1) = match kind.text()? {
            "linear" => {
                root.allow_only(&["name", "kind", "trim", "tolerance", "derivatives", "effect"])?;
                let mut linear = LinearModel::about(read_trim(&root, &naming)?);
                read_derivatives(&root, &naming, &mut linear)?;
                (linear, None)
            }
            "level1" => {
                root.allow_only(&["name", "kind", "tolerance", "effect", "level1"])?;
                let table = root.require("level1")?.table("[level1]")?;
                (LinearModel::default(), Some(read_level1(&table)?))
            }
            _ => return Err(kind.choice("a kind of model", &["linear", "level1"])),
        };
        let name = root.find("name").map_or(Ok(""), |entry| entry.text())?.to_owned();
        let (tolerance, stds) = read_tolerance(&root, &naming)?;
        let effects = read_effects(&root, &naming)?;
        Ok((ModelFile { name, linear, tolerance, stds, effects, controls: naming.kept() }, level1))
    }

    /// The file's text; read again it gives the same model, number for number.
    pub fn to_toml(&self) -> String {
        let mut text = String::new();
        let name = toml::Value::String(self.name.clone());
        let trim = &self.linear.trim;
        let _ = writeln!(text, "name = {name}\nkind = \"linear\"\n\n[trim]");
        for (key, value) in [("u", trim.u), ("v", trim.v), ("w", trim.w), ("phi", trim.phi), ("theta", trim.theta)] {
            let _ = writeln!(text, "{key} = {value:?}");
        }
        if let Some(rotor_speed) = trim.rotor_speed {
            let _ = writeln!(text, "rotor_speed = {rotor_speed:?}");
        }
        let _ = writeln!(text, "\n[trim.controls]");
        for (control, value) in Control::ALL.into_iter().zip(trim.controls) {
            let _ = writeln!(text, "{} = {value:?}", control.name(self.controls));
        }
        let _ = writeln!(text, "\n[tolerance]\nderivatives = {:?}", self.tolerance);
        for (axis, stds) in Axis::ALL.into_iter().zip(&self.stds).filter(|(_, stds)| stds.iter().any(|std| *std > 0.0)) {
            let _ = writeln!(text, "\n[tolerance.{}]", axis.name());
            for (variable, std) in Variable::ALL.into_iter().zip(stds).filter(|(_, std)| **std > 0.0) {
                let _ = writeln!(text, "{} = {std:?}", variable.name(self.controls));
            }
        }
        for axis in Axis::ALL {
            let entries = self.axis_entries(axis);
            if !entries.is_empty() {
                let _ = writeln!(text, "\n[derivatives.{}]\n{entries}", axis.name());
            }
        }
        for effect in &self.effects {
            let _ = writeln!(text, "\n{}", effect.to_toml(self.controls).trim_end());
        }
        text
    }

    /// The lines of one axis's table of derivatives, zeros left out.
    fn axis_entries(&self, axis: Axis) -> String {
        let mut lines = Vec::new();
        for variable in Variable::ALL {
            let value = self.linear.derivative(axis, variable);
            if value != 0.0 {
                lines.push(format!("{} = {value:?}", variable.name(self.controls)));
            }
        }
        if let Some(&value) = self.linear.rotor_speed.get(axis.index()).filter(|&&value| value != 0.0) {
            lines.push(format!("rotor_speed = {value:?}"));
        }
        for term in self.linear.terms.iter().filter(|term| term.axis == axis) {
            lines.push(format!("\"{}\" = {:?}", term.term, term.coefficient));
        }
        lines.join("\n")
    }
}

fn read_trim(root: &TomlTable<'_>, naming: &Naming) -> Result<Trim, TomlError> {
    let table = root.require("trim")?.table("[trim]")?;
    table.allow_only(&["u", "v", "w", "phi", "theta", "rotor_speed", "controls"])?;
    let or_zero = |key: &str| table.find(key).map_or(Ok(0.0), |entry| entry.number());
    let mut trim = Trim {
        u: table.require("u")?.number()?,
        v: or_zero("v")?,
        w: or_zero("w")?,
        phi: or_zero("phi")?,
        theta: table.require("theta")?.number()?,
        rotor_speed: table.find("rotor_speed").map(|entry| entry.positive()).transpose()?,
        controls: [0.0; 4],
    };
    if let Some(entry) = table.find("controls") {
        for entry in entry.table("[trim.controls]")?.entries() {
            let Some(control) = Control::from_name(entry.key) else {
                return Err(entry.unknown_key("a control", &naming.control_names()));
            };
            naming.note(entry.key).map_err(|what| entry.misread(what))?;
            if let Some(place) = trim.controls.get_mut(control.index()) {
                *place = entry.number()?;
            }
        }
    }
    Ok(trim)
}

fn read_derivatives(root: &TomlTable<'_>, naming: &Naming, model: &mut LinearModel) -> Result<(), TomlError> {
    let Some(entry) = root.find("derivatives") else { return Ok(()) };
    for axis_entry in entry.table("[derivatives]")?.entries() {
        let Some(axis) = Axis::from_name(axis_entry.key) else {
            return Err(axis_entry.unknown_key("an axis", &Axis::ALL.map(Axis::name)));
        };
        for entry in axis_entry.table("[derivatives.AXIS]")?.entries() {
            read_derivative(&entry, axis, naming, model)?;
        }
    }
    Ok(())
}

fn read_derivative(entry: &TomlEntry<'_>, axis: Axis, naming: &Naming, model: &mut LinearModel) -> Result<(), TomlError> {
    let value = entry.number()?;
    if entry.key == "rotor_speed" {
        if let Some(place) = model.rotor_speed.get_mut(axis.index()) {
            *place = value;
        }
        return Ok(());
    }
    let term = match Term::from_name(entry.key) {
        Ok(term) => term,
        Err(TermError::Unknown) => {
            let names: Vec<&str> = naming.variable_names().into_iter().chain(["rotor_speed"]).collect();
            return Err(entry.unknown_key("a variable or a term of them such as \"v*|v|\"", &names));
        }
        Err(error) => return Err(entry.misread(error)),
    };
    naming.note(entry.key).map_err(|what| entry.misread(what))?;
    let added = model.add_term(axis, term, value);
    added.map_err(|_| {
        entry.misread(format_args!("expected at most {} nonlinear terms in a model", crate::flight::model::MODEL_TERMS))
    })
}

/// The tolerance of every derivative, and standard errors of some.
type Tolerance = (f64, [[f64; VARIABLES]; AXES]);

fn read_tolerance(root: &TomlTable<'_>, naming: &Naming) -> Result<Tolerance, TomlError> {
    let mut stds = [[0.0; VARIABLES]; AXES];
    let Some(entry) = root.find("tolerance") else { return Ok((DEFAULT_TOLERANCE, stds)) };
    let table = entry.table("[tolerance]")?;
    table.allow_only(&["derivatives", "X", "Y", "Z", "L", "M", "N"])?;
    for (axis, row) in Axis::ALL.into_iter().zip(&mut stds) {
        let Some(entry) = table.find(axis.name()) else { continue };
        for entry in entry.table("[tolerance.AXIS]")?.entries() {
            let Some(variable) = Variable::from_name(entry.key) else {
                return Err(entry.unknown_key("a variable", &naming.variable_names()));
            };
            naming.note(entry.key).map_err(|what| entry.misread(what))?;
            if let Some(std) = row.get_mut(variable.index()) {
                *std = entry.not_negative()?;
            }
        }
    }
    let tolerance = table.find("derivatives").map_or(Ok(DEFAULT_TOLERANCE), |entry| entry.not_negative())?;
    Ok((tolerance, stds))
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "values are carried, not computed")]
mod tests {
    use super::*;
    use crate::flight::effect::Effect;

    const TEXT: &str = r#"
name = "test \"one\""
kind = "linear"
[trim]
u = 51.3
w = 1.6
theta = 0.031
rotor_speed = 27.0
[trim.controls]
aileron = 0.01
[derivatives.N]
v = 0.018
"v*|v|" = 0.001
rotor_speed = 0.3
rudder = -1.9
[[effect]]
kind = "actuator_lag"
control = "rudder"
tau = 0.15
"#;

    #[test]
    fn standard_errors_go_with_the_derivatives_and_come_back() {
        let text = TEXT.replace("[derivatives.N]", "[tolerance]\nderivatives = 0.05\n[tolerance.N]\nv = 0.002\n[derivatives.N]");
        let file = ModelFile::parse(&text).unwrap();
        assert_eq!((file.tolerance, file.stds[Axis::N.index()][Variable::V.index()]), (0.05, 0.002));
        assert_eq!(ModelFile::parse(&file.to_toml()).unwrap(), file);
        for wrong in ["[tolerance.K]\nv = 1.0\n", "[tolerance.N]\nvv = 1.0\n", "[tolerance.N]\nv = -1.0\n"] {
            assert!(ModelFile::parse(&format!("{TEXT}\n{wrong}")).is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_file_is_read_as_it_stands() {
        let file = ModelFile::parse(TEXT).unwrap();
        assert_eq!((file.name.as_str(), file.controls, file.tolerance), ("test \"one\"", ControlNames::FixedWing, 0.03));
        let trim = file.linear.trim;
        assert_eq!((trim.u, trim.v, trim.w, trim.theta, trim.rotor_speed), (51.3, 0.0, 1.6, 0.031, Some(27.0)));
        assert_eq!(trim.controls, [0.0, 0.01, 0.0, 0.0]);
        assert_eq!(file.linear.derivative(Axis::N, Variable::Pedal), -1.9);
        assert_eq!(file.linear.rotor_speed, [0.0, 0.0, 0.0, 0.0, 0.0, 0.3]);
        assert_eq!(file.linear.terms.len(), 1);
        assert_eq!(file.effects[0].effect, Effect::ActuatorLag { control: Control::Pedal, tau: 0.15 });
    }

    #[test]
    fn what_is_written_reads_back_the_same() {
        let mut file = ModelFile::parse(TEXT).unwrap();
        *file.linear.derivative_mut(Axis::L, Variable::P) = -1.0 / 3.0 * 1e-9;
        file.tolerance = 0.1;
        assert_eq!(ModelFile::parse(&file.to_toml()).unwrap(), file, "{}", file.to_toml());
    }
}
