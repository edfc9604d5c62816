//! Smoothed states as a run file: CSV that the program reads back, with units in the header.
//!
//! Consumes a run, its samples and their smoothed states; produces one row a state. Airspeed and flow angles are those of the
//! smoothed velocity; channels that are states are free of instrument bias and refer to the centre of mass (the run's instrument
//! positions are written as zero); the other known channels (controls, rotor speed ...) are as sampled.
//!     tas = |(u v w)|,  alpha = atan2(w, u),  beta = asin(v/tas)                                     (1)
//! Quantities that are states only (`u`, `p_dot`, `std_r` ...) are additional columns. A channel that no instrument of the run
//! measures is left out, with its standard deviation, because a reader would take it for a measurement. Numbers read back as the
//! same bits.

use crate::flight::channel::Channel;
use crate::flight::file::run_file::RunInfo;
use crate::flight::sample::Sample;
use crate::io::outputs::json::message_json::{STATE_FIELDS, state_values};
use crate::realtime::estimation::record::StateRecord;
use std::io::{Result, Write};

/// The key of such a run that says what it is.
const SMOOTHED_KEY: &str = "smoothed";

/// Channels that come from a state's velocity, in the order of (1).
const AIR_DATA: [Channel; 3] = [Channel::Tas, Channel::Alpha, Channel::Beta];

struct StateFileColumns {
    /// Which of the channels of (1), and which of the numbers of a state.
    air_data: [bool; AIR_DATA.len()],
    state: [bool; STATE_FIELDS.len()],
    /// Channels as they were sampled.
    sampled: Vec<Channel>,
}

impl StateFileColumns {
    /// Those of a run that samples these channels.
    fn new(sampled: &[Channel]) -> Self {
        let measured = |channel: &Channel| sampled.contains(channel);
        let of_state = |(name, _): (&str, &str)| {
            let of = name.trim_start_matches("std_").trim_start_matches("bias_");
            Channel::from_name(of).is_none_or(|(channel, _)| measured(&channel))
        };
        let is_state = |channel: &Channel| {
            AIR_DATA.contains(channel) || STATE_FIELDS.iter().any(|f| Channel::from_name(f.0).is_some_and(|c| c.0 == *channel))
        };
        StateFileColumns {
            air_data: AIR_DATA.map(|channel| measured(&channel)),
            state: STATE_FIELDS.map(of_state),
            sampled: sampled.iter().copied().filter(|channel| !is_state(channel)).collect(),
        }
    }
}

fn chosen<T>(from: impl IntoIterator<Item = T>, which: &[bool]) -> impl Iterator<Item = T> {
    from.into_iter().zip(which).filter_map(|(entry, chosen)| chosen.then_some(entry))
}

/// Writes the preamble, the header, and a row for each state with the sample that it belongs to; `sampled` are the channels that
/// the run's instruments measure.
///
/// # Errors
/// What the sink returns.
pub fn write<'a>(
    sink: &mut dyn Write,
    run: &RunInfo,
    sampled: &[Channel],
    states: impl IntoIterator<Item = (&'a StateRecord, &'a Sample)>,
) -> Result<()> {
    for line in preamble(run).lines() {
        writeln!(sink, "{}{line}", if line.is_empty() { "#" } else { "# " })?;
    }
    let columns = StateFileColumns::new(sampled);
    let named = |channel: Channel| (channel.name(run.geometry().controls), channel.si_unit());
    let air_data = chosen(AIR_DATA, &columns.air_data).map(named);
    let kept = columns.sampled.iter().copied().map(named);
    write!(sink, "time[s]")?;
    for (name, unit) in air_data.chain(chosen(STATE_FIELDS, &columns.state)).chain(kept) {
        write!(sink, ",{name}[{unit}]")?;
    }
    writeln!(sink)?;
    for (state, sample) in states {
        write!(sink, "{}", state.time_s)?;
        let air_data = chosen(of_velocity(state.velocity), &columns.air_data);
        for value in air_data.chain(chosen(state_values(state), &columns.state)) {
            write!(sink, ",{value}")?;
        }
        for channel in &columns.sampled {
            match sample.get(*channel) {
                Some(value) => write!(sink, ",{value}")?,
                None => write!(sink, ",")?,
            }
        }
        writeln!(sink)?;
    }
    Ok(())
}

/// (1).
fn of_velocity([u, v, w]: [f64; 3]) -> [f64; 3] {
    let tas = libm::sqrt(u * u + v * v + w * w);
    [tas, libm::atan2(w, u), libm::asin(v / tas)]
}

/// The run's keys, with what reads the instruments at the centre of mass.
fn preamble(run: &RunInfo) -> String {
    let mut run = run.clone();
    for key in ["accelerometer_position_m", "vane_position_m"] {
        if run.document().contains_key(key) {
            // A position is a known key, and this one has its type.
            let _ = run.set(&format!("{key}=[0.0, 0.0, 0.0]"));
        }
    }
    let mut text = run.to_toml();
    if !run.document().contains_key(SMOOTHED_KEY) {
        text.push_str(&format!("{SMOOTHED_KEY} = \"over the whole record, at the centre of mass\"\n"));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn air_data_are_those_of_the_velocity() {
        let [tas, alpha, beta] = of_velocity([12.0, 4.0, 3.0]);
        assert!((tas - 13.0).abs() < 1e-12, "{tas}");
        assert!((libm::tan(alpha) - 0.25).abs() < 1e-12 && (libm::sin(beta) * 13.0 - 4.0).abs() < 1e-12, "{alpha} {beta}");
    }

    #[test]
    fn instruments_stand_at_the_centre_of_mass_and_a_second_time_changes_nothing() {
        let run = RunInfo::from_toml("run = \"1/2\"\nvane_position_m = [13.0, 0.0, 1.0]").unwrap();
        let again = RunInfo::from_toml(&preamble(&run)).unwrap();
        assert_eq!((again.geometry().vane_position_m, again.run()), ([0.0; 3], Some("1/2")));
        assert!(!again.document().contains_key("accelerometer_position_m"));
        assert_eq!(preamble(&again), again.to_toml());
    }
}
