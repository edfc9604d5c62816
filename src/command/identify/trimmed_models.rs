//! The models beside which test points are shown, each trimmed where a test point was flown.

use super::test_point_result::SimulatedModes;
use crate::command::options::flight_condition::read_model;
use sideslip::dynamics::atmosphere::density_at;
use sideslip::error::Failure;
use sideslip::postflight::identification::test_condition::{PATH_RAD, SPEED_PART, TestCondition};
use sideslip::simulation::flight_model::FlightRequest;
use std::path::PathBuf;

/// Files, or `puma`.
pub(super) struct TrimmedModels<'a> {
    files: &'a [PathBuf],
    density: Option<f64>,
}

impl<'a> TrimmedModels<'a> {
    pub(super) fn new(files: &'a [PathBuf], density: Option<f64>) -> Self {
        TrimmedModels { files, density }
    }

    /// The model in this flight: a Level-1 aircraft trimmed there, or of linear models, which have their own trims, the nearest.
    pub(super) fn at(&self, condition: &TestCondition) -> Result<Option<SimulatedModes>, Failure> {
        let mut nearest: Option<(f64, SimulatedModes)> = None;
        for file in self.files {
            let own = read_model(file, &FlightRequest::default(), "")?;
            let name = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            let (away, simulation) = if own.level1.is_some() {
                let finite = |value: f64| Some(value).filter(|value| value.is_finite());
                let density = self.density.or(finite(condition.density)).or(finite(condition.altitude).map(density_at));
                let climb = Some(condition.climb());
                let asked = FlightRequest { speed: finite(condition.speed), climb, density, ..FlightRequest::default() };
                let trimmed = read_model(file, &asked, "")?;
                let density = density.map(|density| format!(", {density:.3} kg/m^3")).unwrap_or_default();
                (0.0, SimulatedModes::of(format!("{name}{density}"), trimmed.linear().clone()))
            } else {
                let trim = own.linear().trim;
                let path = libm::fabs(trim.flight_path_angle() - condition.path) / PATH_RAD;
                let speed = libm::fabs(trim.airspeed() / condition.speed - 1.0) / SPEED_PART;
                (path + speed, SimulatedModes::of(name, own.linear().clone()))
            };
            if nearest.as_ref().is_none_or(|(known, _)| away < *known) {
                nearest = Some((away, simulation));
            }
        }
        Ok(nearest.map(|(_, simulation)| simulation))
    }
}
