//! The model of the live diagnosis: from the options to a diagnosis that follows the samples.

use super::flight_condition::{number, read_model};
use crate::command::recordings::run_condition::condition_of;
use sideslip::error::Failure;
use sideslip::flight::run::RunGeometry;
use sideslip::live::diagnosis::{LiveDiagnosis, ModelOf};
use sideslip::postflight::identification::test_condition::{SPEED_PART, TestCondition};
use sideslip::postflight::recorded_run::RecordedRun;
use sideslip::simulation::flight_model::{FlightModel, FlightRequest};
use std::path::{Path, PathBuf};

/// Options of the diagnosis beside a flight.
#[derive(clap::Args)]
pub(crate) struct LiveDiagnosisOptions {
    /// Diagnose this model (TOML file, or puma) during the flight: errors and causes appear at the end of each manoeuvre
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,
    /// Air density for a Level-1 model, kg/m^3 [default: the model file's]; its airspeed and climb are those flown
    #[arg(long, value_name = "KG/M3", requires = "model", value_parser = number("kg/m^3"))]
    density: Option<f64>,
}

#[derive(Clone)]
pub(crate) struct LiveDiagnosisModel {
    path: PathBuf,
    density: Option<f64>,
    model: FlightModel,
}

impl LiveDiagnosisOptions {
    /// The model file.
    pub(crate) fn file(&self) -> Option<PathBuf> {
        self.model.clone()
    }

    /// Reads the model, where one is given.
    pub(crate) fn read(&self) -> Result<Option<LiveDiagnosisModel>, Failure> {
        self.model.as_ref().map(|path| LiveDiagnosisModel::read(path, self.density)).transpose()
    }

    /// The same options for a call of another command.
    pub(crate) fn call(&self) -> Vec<String> {
        let mut call: Vec<String> = Vec::new();
        if let Some(model) = &self.model {
            call.extend(["--model".to_owned(), model.display().to_string()]);
        }
        call.extend(self.density.iter().map(|density| format!("--density={density}")));
        call
    }
}

impl LiveDiagnosisModel {
    /// Reads a model; of one that is trimmed where the flight is, the density of the air.
    pub(crate) fn read(path: &Path, density: Option<f64>) -> Result<Self, Failure> {
        let model = read_model(path, &FlightRequest { density, ..FlightRequest::default() }, "")?;
        Ok(LiveDiagnosisModel { path: path.to_path_buf(), density, model })
    }

    /// What follows a run whose instruments are there.
    pub(crate) fn live(&self, geometry: RunGeometry) -> LiveDiagnosis {
        let LiveDiagnosisModel { path, density, model } = self.clone();
        let model_of: ModelOf = if model.level1.is_some() {
            Box::new(move |runs| trimmed(&path, density, runs))
        } else {
            Box::new(move |runs| Ok((model.clone(), where_it_holds(&model, runs)?)))
        };
        LiveDiagnosis::new(model_of, geometry)
    }
}

/// A Level-1 model in the trim of the newest manoeuvre and of all that were flown near it.
fn trimmed(path: &Path, density: Option<f64>, runs: &[RecordedRun]) -> Result<(FlightModel, Vec<usize>), String> {
    let conditions: Vec<TestCondition> = runs.iter().map(condition_of).collect();
    let newest = conditions.last().ok_or("no manoeuvre")?;
    let near: Vec<usize> =
        (0..runs.len()).filter(|&place| conditions.get(place).is_some_and(|one| one.is_near(newest))).collect();
    let mean = TestCondition::mean(&near.iter().filter_map(|&place| conditions.get(place)).copied().collect::<Vec<_>>());
    if !mean.speed.is_finite() {
        return Err("expected an airspeed to trim the model at, found no samples of `tas`".to_owned());
    }
    let climb = Some(mean.climb()).filter(|climb| climb.is_finite());
    let asked = FlightRequest { speed: Some(mean.speed), climb, density, ..FlightRequest::default() };
    let model = read_model(path, &asked, "").map_err(|failure| failure.to_string())?;
    Ok((model, near))
}

/// Manoeuvres at the airspeed of a linear model's trim.
fn where_it_holds(model: &FlightModel, runs: &[RecordedRun]) -> Result<Vec<usize>, String> {
    let own = model.linear().trim.airspeed();
    let flown: Vec<f64> = runs.iter().map(|run| condition_of(run).speed).collect();
    let holds = |speed: f64| !(own > 0.0 && libm::fabs(speed - own) > SPEED_PART * own.max(speed));
    let near: Vec<usize> = (0..runs.len()).filter(|&place| flown.get(place).is_some_and(|&speed| holds(speed))).collect();
    // The newest is what findings are about.
    match flown.last() {
        Some(&speed) if !holds(speed) => {
            Err(format!("flown at {speed:.1} m/s, outside the validity of the model, which is of {own:.1} m/s"))
        }
        _ => Ok(near),
    }
}
