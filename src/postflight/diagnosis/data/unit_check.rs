//! Channels that read as if in another unit than their header says, where kinematics cannot tell.
//!
//! Consumes a run and how a problem is posed of it; produces the channels and the unit. With the n readings of them taken k
//! times, k taking that unit to SI,
//!     C(k) = cost of the model as it is - 2 n ln k                                                     (1)
//! (n of what is measured of the motion; what moves the aircraft has no density, n = 0) has to fall by [`FALLS`], and has to rise
//! again to either side of k: a control that does nothing, or a tenth of what it should, is none in degrees.
//! The rotor's speed is in rpm where the model's trim says so, within [`NEAR`].
//! Rates, attitude, one vane and accelerometers are judged by the kinematics alone (`instrument_check`), an airspeed in knots is
//! told as its factor.

use super::run_data::{
    ALPHA_OUTPUT, ALTITUDE_OUTPUT, INPUTS, MESH_RATE_HZ, OUTPUT_CHANNELS, OUTPUTS, ROTOR, RunData, input_channel,
};
use crate::flight::channel::Channel;
use crate::flight::control::CONTROLS;
use crate::flight::model::Trim;
use crate::flight::signal::series::Series;
use crate::flight::unit::{DEGREE, FOOT, RPM};
use crate::postflight::diagnosis::likelihood::normal_equations::{Detail, linearise};
use crate::postflight::diagnosis::likelihood::problem::DiagnosisProblem;

/// What (1) falls by.
const FALLS: f64 = 100.0;
/// To either side of k.
const BESIDE: [f64; 2] = [0.7, 1.4];
/// Angles of controls and vanes that stay below are none in degrees, or so small that it matters little.
const SMALL: f64 = 0.2;
/// A rotor's speed is that of the trim, in part.
const NEAR: f64 = 0.2;

/// Channels, the unit that they may be in, and its size in SI.
struct UnitHypothesis {
    inputs: Vec<usize>,
    outputs: Vec<usize>,
    unit: &'static str,
    si: f64,
}

/// The channels of a run that read as if in another unit, and that unit.
pub(crate) fn unit_check(
    run: &RunData,
    trim: &Trim,
    pose: &impl Fn(RunData) -> DiagnosisProblem,
) -> Option<(Vec<Channel>, &'static str)> {
    if let Some((rotor, at_trim)) = run.inputs[ROTOR].as_ref().zip(trim.rotor_speed)
        && libm::fabs(RPM * rotor.average() / at_trim - 1.0) < NEAR
    {
        return Some((vec![Channel::RotorSpeed], "rpm"));
    }
    let cost = |run: RunData| {
        let problem = pose(run);
        linearise(&problem, &problem.null_hypothesis(), &[], Detail::Cost).map_or(f64::INFINITY, |local| local.cost)
    };
    let as_said = cost(run.clone());
    let mut best: Option<(f64, UnitHypothesis)> = None;
    for reading in unit_hypotheses(run) {
        let count = reading.count(run);
        let taken = |factor: f64| cost(reading.times(run, factor)) - 2.0 * count * libm::log(factor);
        let there = taken(reading.si);
        let less = there < as_said - FALLS && best.as_ref().is_none_or(|(least, _)| there < *least);
        if less && BESIDE.iter().all(|beside| taken(beside * reading.si) > there) {
            best = Some((there, reading));
        }
    }
    best.map(|(_, reading)| (reading.channels(), reading.unit))
}

/// What a run may have in another unit.
fn unit_hypotheses(run: &RunData) -> Vec<UnitHypothesis> {
    let largest =
        |series: Option<&Series>| series.map_or(0.0, |one| one.samples().fold(0.0, |most, (_, x)| libm::fabs(x).max(most)));
    let degrees = |inputs: Vec<usize>, outputs: Vec<usize>| UnitHypothesis { inputs, outputs, unit: "deg", si: DEGREE };
    let moved: Vec<usize> = (0..CONTROLS).filter(|&place| largest(run.inputs[place].as_ref()) > SMALL).collect();
    // Any of them together: beside another that is in degrees too, one put right may lead nowhere.
    let together = |chosen: usize| moved.iter().copied().filter(|place| chosen & (1 << place) != 0).collect::<Vec<usize>>();
    let chosen = (1..1usize << CONTROLS).filter(|chosen| together(*chosen).len() == chosen.count_ones() as usize);
    let mut all: Vec<UnitHypothesis> = chosen.map(|chosen| degrees(together(chosen), Vec::new())).collect();
    let vanes: Vec<usize> =
        (ALPHA_OUTPUT..ALPHA_OUTPUT + 2).filter(|&place| largest(run.outputs[place].as_ref()) > SMALL).collect();
    if vanes.len() == 2 {
        all.push(degrees(Vec::new(), vanes));
    }
    if run.outputs[ALTITUDE_OUTPUT].is_some() {
        all.push(UnitHypothesis { inputs: Vec::new(), outputs: vec![ALTITUDE_OUTPUT], unit: "ft", si: FOOT });
    }
    all
}

impl UnitHypothesis {
    /// The run with these readings so many times what they are.
    fn times(&self, run: &RunData, factor: f64) -> RunData {
        let mut other = run.clone();
        let times = |series: &mut Option<Series>, noise: &mut f64| {
            *series = series.as_ref().map(|one| one.mapped(|value| factor * value));
            *noise *= factor;
        };
        for place in (0..INPUTS).filter(|place| self.inputs.contains(place)) {
            times(&mut other.inputs[place], &mut other.input_noise[place]);
        }
        for place in (0..OUTPUTS).filter(|place| self.outputs.contains(place)) {
            times(&mut other.outputs[place], &mut other.output_noise[place]);
        }
        other.lay_mesh(MESH_RATE_HZ);
        other
    }

    /// n of (1).
    fn count(&self, run: &RunData) -> f64 {
        let readings = run.readings(&[0.0; OUTPUTS]);
        let at = |node: usize| readings.at(node).iter().filter(|one| self.outputs.contains(&one.output)).count();
        (0..run.mesh.nodes).map(at).sum::<usize>() as f64
    }

    fn channels(&self) -> Vec<Channel> {
        let of_outputs = self.outputs.iter().map(|&place| OUTPUT_CHANNELS[place]);
        self.inputs.iter().map(|&place| input_channel(place)).chain(of_outputs).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flight::derivative::{AXES, VARIABLES};
    use crate::flight::run::RunGeometry;
    use crate::io::outputs::words::set_aside::reason;
    use crate::postflight::diagnosis::likelihood::aircraft::Aircraft;
    use crate::postflight::diagnosis::likelihood::likelihood_tests::flown;

    /// What is said of the flight with these channels so many times what they are.
    fn said(channels: &[Channel], factor: f64) -> Option<(String, &'static str)> {
        let (model, mut samples) = flown(Vec::new());
        for sample in &mut samples {
            for &channel in channels {
                if let Some(value) = sample.get(channel) {
                    sample.set(channel, factor * value);
                }
            }
        }
        let run = RunData::of("one", &samples, RunGeometry::DEFAULT).unwrap();
        let pose = |run| DiagnosisProblem::new(Aircraft::of(&model), Vec::new(), vec![run], 0.03, &[[0.0; VARIABLES]; AXES]);
        let (channels, unit) = unit_check(&run, &model.linear().trim, &pose)?;
        Some((channels.iter().map(|one| one.name(run.geometry.controls)).collect::<Vec<_>>().join(", "), unit))
    }

    fn told(names: &str, unit: &'static str) -> Option<(String, &'static str)> {
        Some((names.to_owned(), unit))
    }

    #[test]
    fn another_unit_is_told() {
        assert_eq!(said(&[Channel::Pedal], 1.0 / DEGREE), told("pedal", "deg"));
        assert_eq!(said(&[Channel::LonCyclic], 1.0 / DEGREE), told("lon_cyclic", "deg"));
        assert_eq!(said(&[Channel::Alpha, Channel::Beta], 1.0 / DEGREE), told("alpha, beta", "deg"));
        assert_eq!(said(&[Channel::Altitude], 1.0 / FOOT), told("altitude", "ft"));
        assert_eq!(said(&[Channel::RotorSpeed], 1.0 / RPM), told("rotor_speed", "rpm"));
        assert_eq!(said(&[Channel::Pedal, Channel::LonCyclic], 1.0 / DEGREE), told("lon_cyclic, pedal", "deg"));
        assert_eq!(said(&Channel::CONTROLS, 1.0 / DEGREE), told("lon_cyclic, lat_cyclic, collective, pedal", "deg"));
    }

    /// What is wrong with a control is no unit: a factor, a control that does nothing, one that is recorded much too large.
    #[test]
    fn other_faults_are_no_unit() {
        assert_eq!(said(&[], 1.0), None);
        for factor in [0.0, 0.1, 0.5, 1.5, 3.0, 10.0, 25.0, 120.0] {
            assert_eq!(said(&[Channel::Pedal], factor), None, "pedal {factor}");
        }
        for factor in [0.5, 2.0] {
            assert_eq!(said(&[Channel::Altitude], factor), None, "altitude {factor}");
            assert_eq!(said(&[Channel::RotorSpeed], factor), None, "rotor speed {factor}");
        }
    }

    #[test]
    fn a_time_that_goes_back_is_refused() {
        let (_, mut samples) = flown(Vec::new());
        samples.swap(400, 401);
        let refused = reason(&RunData::of("one", &samples, RunGeometry::DEFAULT).unwrap_err());
        assert_eq!(refused, "sample 402: expected a time not before 3.1328 s, found 3.1250 s");
    }
}
