//! Aids: one file a measurement, each with its prediction, its row of H and its noise.
//!
//! In: the state and where the instruments stand. Out: a [`Prediction`].
//! Assumed: the instruments' positions are those of the run. Refused: a flow angle or airspeed below the speed at which
//! it means anything (`None`, and the aid is not fused).

pub mod airspeed;
pub mod altitude;
pub mod attitude;
pub mod flow_angle;
pub mod inertial;
pub mod prediction;

use super::config::Noise;
use super::process::State;
use super::record::Aid;
use crate::flight::run::RunGeometry;
use prediction::{LocalVelocity, Prediction};

/// Prediction of one aid from the state.
pub fn predict(aid: Aid, state: &State, geometry: &RunGeometry, noise: &Noise) -> Option<Prediction> {
    let centre = || LocalVelocity::at([0.0; 3], state, geometry);
    let vane = || LocalVelocity::at(geometry.vane_position_m, state, geometry);
    match aid {
        Aid::Airspeed => airspeed::predict(&centre(), noise).map(|reading| reading.scaled(0, state)),
        Aid::Incidence => flow_angle::predict_incidence(&vane(), noise).map(|reading| reading.scaled(1, state)),
        Aid::Sideslip => flow_angle::predict_sideslip(&vane(), noise).map(|reading| reading.scaled(2, state)),
        Aid::Bank => Some(attitude::predict(0, state, noise.bank_std)),
        Aid::Pitch => Some(attitude::predict(1, state, noise.pitch_std)),
        Aid::Heading => Some(attitude::predict(2, state, noise.heading_std)),
        Aid::Altitude => Some(altitude::predict(state, noise)),
    }
}
