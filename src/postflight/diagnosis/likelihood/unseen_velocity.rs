//! Velocities that no instrument shows: held near the trim's.
//!
//! Consumes the filter's state, covariance and sensitivities at a node; corrects them. Of a model without an axis the force
//! along it is white noise of a large density. Where no accelerometer measures that force and no vane shows the velocity, nothing
//! bounds v or w: the filter's state walks off until the equations of motion refuse it. In a flight near its trim the velocity
//! is the trim's within `DEVIATION`; that knowledge acts as a reading at each node, which has no part in the likelihood:
//!     z = v_trim, s = P_vv + DEVIATION^2, corrections as in (2) and (3) of `filter`                          (1)

use super::covariance::correct;
use super::noise_score::NoiseScore;
use super::run_model::RunModel;
use super::sensitivity::correct_sensitivities;
use super::state::{FilterState, NOISES, STATES, StateMatrix, VELOCITY};
use crate::flight::derivative::Axis;
use crate::flight::signal::series::Series;
use crate::postflight::diagnosis::data::run_data::{FLOW_OUTPUTS, MEASURED_FORCE};

/// Standard deviation of the velocity about the trim's, m/s.
const DEVIATION: f64 = 2.0;

/// Which of v and w neither the model, an accelerometer nor a vane tells.
pub(crate) fn unseen(run: &RunModel<'_>) -> Vec<usize> {
    let has = |series: &[Option<Series>], place: usize| series.get(place).is_some_and(Option::is_some);
    let record = run.record;
    let is_unseen = |&(place, axis): &(usize, Axis)| {
        let is_shown = has(&record.outputs, FLOW_OUTPUTS[place]) || has(&record.inputs, MEASURED_FORCE + place);
        run.model.is_unmodelled(axis) && !is_shown
    };
    [(1, Axis::Y), (2, Axis::Z)].into_iter().filter(is_unseen).map(|(place, _)| VELOCITY + place).collect()
}

/// (1) for one velocity; `d` the sensitivities, [states x width], of the first `n` states. `None` where the state is no number.
pub(crate) fn hold(
    place: usize,
    run: &RunModel<'_>,
    (x, p): (&mut FilterState, &mut StateMatrix),
    (d, width): (&mut [f32], usize),
    noise_score: Option<&mut NoiseScore>,
    n: usize,
) -> Option<()> {
    let trim = [run.trim.u, run.trim.v, run.trim.w].get(place - VELOCITY).copied()?;
    let s = p[place][place] + DEVIATION * DEVIATION;
    if !(s.is_finite() && s > 0.0) {
        return None;
    }
    let v = trim - x[place];
    let ph: FilterState = core::array::from_fn(|i| if i < n { p[i][place] } else { 0.0 });
    let gain = ph.map(|ph| ph / s);
    if width > 0 {
        let own: Vec<f32> = d.iter().skip(place * width).take(width).copied().collect();
        correct_sensitivities(d, &own, &gain);
    }
    if let Some(noise_score) = noise_score {
        let mut h = [0.0; STATES];
        h[place] = 1.0;
        noise_score.correct(&h, &gain, (v, s), &mut [(0.0, 0.0); NOISES], n);
    }
    correct(x, p, (&gain, &ph), v, n);
    x.iter().all(|x| x.is_finite()).then_some(())
}
