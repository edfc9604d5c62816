//! Events of the state estimation in words: one sentence for each kind.

use super::instrument_words::gross_error;
use super::status_text::aid_name;
use crate::flight::channel::ControlNames;
use crate::io::outputs::number::Digits;
use crate::realtime::estimation::record::{Aid, EstimationEvent};
use core::fmt::{self, Display, Formatter};

/// An aid in words with its channel, `sideslip (beta)`.
struct AidLabel(Aid, ControlNames);

impl Display for AidLabel {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let (aid, channel) = (aid_name(self.0), self.0.channel().name(self.1));
        if aid == channel { f.write_str(aid) } else { write!(f, "{aid} ({channel})") }
    }
}

pub(crate) fn estimation_sentence(f: &mut Formatter<'_>, event: &EstimationEvent, controls: ControlNames) -> fmt::Result {
    match *event {
        EstimationEvent::NotFinite { channel } => {
            write!(f, "{} gave no number (NaN or infinity); taken as not sampled", channel.name(controls))
        }
        EstimationEvent::OutOfRange { channel, value } => write!(
            f,
            "{} read {} {}, which no aircraft reaches (wrong unit?); taken as not sampled",
            channel.name(controls),
            Digits(value, 4),
            channel.si_unit()
        ),
        EstimationEvent::TimeNotFinite => f.write_str("a sample's time is no number; the sample was dropped"),
        EstimationEvent::DuplicateTime => f.write_str("a second sample came with the same time; it was dropped"),
        EstimationEvent::TimeWentBack { by_s } => {
            write!(f, "time went back by {} s; the sample was dropped", Digits(by_s, 3))
        }
        EstimationEvent::RatesSilent { seconds } => {
            write!(f, "p, q and r were silent for {} s; the filter starts again with them", Digits(seconds, 3))
        }
        EstimationEvent::Gap { seconds } => {
            write!(f, "nothing came for {} s; the filter starts again", Digits(seconds, 3))
        }
        EstimationEvent::SegmentRestart => f.write_str("time runs on from an earlier instant; a new segment begins"),
        EstimationEvent::Initialised => f.write_str("the filter has a state"),
        EstimationEvent::StatesChosen { set } => {
            f.write_str("states: u v w, phi theta psi, altitude, p q r, p-dot q-dot r-dot, gyro biases")?;
            for (there, name) in set.specific_force.into_iter().zip(["ax", "ay", "az"]) {
                if there {
                    write!(f, ", {name} and its bias")?;
                }
            }
            for (there, name) in set.scale_error.into_iter().zip(["tas", "alpha", "beta"]) {
                if there {
                    write!(f, ", scale of {name}")?;
                }
            }
            Ok(())
        }
        EstimationEvent::LinesNotched { passing_hz } => {
            write!(
                f,
                "the blades' passing at {} Hz and its second harmonic are removed from every channel",
                Digits(passing_hz, 3)
            )
        }
        EstimationEvent::LineFolded => {
            f.write_str("the blades' passing is aliased into the band of the flight motion; it remains in some channel")
        }
        EstimationEvent::NoAccelerometer { channel } => write!(
            f,
            "no accelerometer {}; its specific force is taken to balance gravity, with a large uncertainty",
            channel.name(controls)
        ),
        EstimationEvent::AidMissing { aid } => {
            let aid = AidLabel(aid, controls);
            write!(
                f,
                "the run brings no {aid}: what it alone shows is not estimated (`inspect` lists what each derivative needs)"
            )
        }
        EstimationEvent::AidRejected { aid, test_ratio } => {
            let (aid, ratio) = (AidLabel(aid, controls), Digits(test_ratio, 3));
            write!(
                f,
                "{aid} is left out: it contradicts the motion that gyros and accelerometers measure (test ratio {ratio}, limit 1); \
                 look for its bias, sign, unit or delay with `check`"
            )
        }
        EstimationEvent::AidAccepted { aid } => write!(f, "{} is used again", AidLabel(aid, controls)),
        EstimationEvent::KinematicsDisagree { aid, r_squared } => {
            let (aid, r2) = (AidLabel(aid, controls), Digits(r_squared, 3));
            write!(
                f,
                "{aid} is inconsistent with the motion that gyros and accelerometers measure (R2 {r2}): state where the vane stands \
                 (--set vane_position_m=[x,y,z]), and look for its lag or scale with `check`"
            )
        }
        EstimationEvent::InnovationsTooLarge { aid, mean_nis } => {
            let (aid, times) = (AidLabel(aid, controls), Digits(libm::sqrt(mean_nis), 3));
            write!(
                f,
                "{aid} scatters {times} times as much as its noise explains (gusts, vibration, coarse steps or a loose instrument): \
                 standard deviations of the state are too small; look at the channel, and run `check`"
            )
        }
        EstimationEvent::TrimNotSteady { rate_rms } => write!(
            f,
            "the aircraft was not in steady flight at the start, where its trim is taken (body rates {} rad/s rms), and derivatives are \
             about that trim: begin where the flight is steady (--from S), or take another --trim-window",
            Digits(rate_rms, 3)
        ),
        EstimationEvent::StandsStill { channel } => {
            write!(
                f,
                "{} stands still while the aircraft moves (frozen, clipped or dead); it is left out: check the instrument and its wiring",
                channel.name(controls)
            )
        }
        EstimationEvent::GrossError { error, r_squared } => {
            let corrected = Digits(r_squared, 3);
            write!(f, "it reads like {}: corrected, it agrees with the kinematics (R2 {corrected})", gross_error(error))
        }
        EstimationEvent::NumericBreakdown => f.write_str(
            "the state estimate broke down on numbers it cannot hold and starts again; look at the samples before (`inspect`)",
        ),
    }
}
