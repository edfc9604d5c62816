//! The flight condition that a recorded run begins in.

use sideslip::flight::channel::Channel;
use sideslip::postflight::identification::test_condition::TestCondition;
use sideslip::postflight::recorded_run::RecordedRun;

/// What is a run's trim, s.
const TRIM_S: f64 = 1.0;

/// Where a run was flown, by its first second.
pub(crate) fn condition_of(run: &RecordedRun) -> TestCondition {
    let begin_s = run.samples.first().map_or(0.0, |first| first.time_s);
    let trim = || run.samples.iter().take_while(|sample| sample.time_s <= begin_s + TRIM_S);
    let values = |channel: Channel| -> Vec<(f64, f64)> {
        trim().filter_map(|sample| Some((sample.time_s, sample.get(channel).filter(|value| value.is_finite())?))).collect()
    };
    let mean = |name: &str| {
        let values = values(Channel::from_name(name)?.0);
        (!values.is_empty()).then(|| values.iter().map(|(_, value)| value).sum::<f64>() / values.len() as f64)
    };
    let altitude_rate = || {
        let values = values(Channel::Altitude);
        let ends = values.first().zip(values.last());
        ends.map_or(f64::NAN, |((from_s, from), (to_s, to))| (to - from) / (to_s - from_s))
    };
    TestCondition::of_trim(mean, altitude_rate)
}
