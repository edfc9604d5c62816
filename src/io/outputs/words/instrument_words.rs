//! The check of instruments in words: why a run is fit or not, what is not observable, what separates two explanations.

use crate::flight::channel::{Channel, ControlNames};
use crate::postflight::reconstruction::record::{
    AgreementScope, ChannelError, InstrumentErrorKind, MeanForceContradiction, NotObservable, Separation, UnreportedReason,
    VerdictReason, WiringError, WiringFinding,
};
use crate::realtime::estimation::record::GrossError;

fn name(channel: Channel) -> &'static str {
    channel.name(ControlNames::Rotorcraft)
}

fn names(channels: &[Channel]) -> String {
    channels.iter().map(|&channel| name(channel)).collect::<Vec<_>>().join(" ")
}

/// Why a run is fit, fit once corrected, or not fit for identification.
pub fn verdict_reason(reason: &VerdictReason) -> String {
    let because = |frozen: &Option<Channel>| {
        frozen.map_or(String::new(), |channel| format!(", for {} stands still (frozen, clipped or zeroed)", name(channel)))
    };
    match reason {
        VerdictReason::TooShort { length_s, least_s, frozen } => {
            format!("too short: {length_s:.1} s, at least {least_s:.0} s are needed{}", because(frozen))
        }
        VerdictReason::NoRates(missing) => {
            format!("no angular rate {}: no other channel determines the rotation", names(missing))
        }
        VerdictReason::ClockBackwards { backwards, samples } => {
            format!("its clock does not go forward at {backwards} of {samples} samples")
        }
        VerdictReason::RateTooLow { rate_hz, least_hz } => {
            format!("angular rates at {rate_hz:.1} Hz: at least {least_hz:.0} Hz are needed")
        }
        VerdictReason::MeanNormalForce(found) => {
            format!("az is {found:.2} m/s^2 on average, expected near -9.81 (z points down): its sign or its unit is wrong")
        }
        VerdictReason::NoOutputs => "no attitude and no air data to compare the rates with".to_owned(),
        VerdictReason::Gaps { count, length_s, frozen } => {
            format!("{count} gaps in {length_s:.0} s: no stretch is long enough{}", because(frozen))
        }
        VerdictReason::NoExcitation(most) => format!("no excitation: no angular rate moves more than {most:.4} rad/s rms"),
        VerdictReason::Gross { either, shown, before, after } => {
            let either: Vec<String> = either.iter().map(|one| gross_error(one)).collect();
            format!(
                "reads like {}: corrected, {} follows from the other channels (R2 {after:.2} instead of {before:.2})",
                either.join(" or "),
                name(*shown)
            )
        }
        VerdictReason::Jump { channel, time_s, by } => format!(
            "{} jumps by {by:.3} {} at {time_s:.2} s, which no aircraft does: cut the record there",
            name(*channel),
            channel.si_unit()
        ),
        VerdictReason::OutOfRange(channel, part) => format!(
            "{} is beyond what any aircraft reaches at {:.0} % of its samples: its unit, or its instrument",
            name(*channel),
            100.0 * part
        ),
        VerdictReason::NotFollowed => "the kinematics cannot follow its motion".to_owned(),
        VerdictReason::Wiring(finding) => wiring_finding(*finding),
        VerdictReason::ImplausibleScale(channel, factor) => format!(
            "{} contradicts the others in a way that no error of an instrument explains (a scale factor of {factor:.2} would fit \
             best): a jump, damaged samples, or another channel",
            name(*channel)
        ),
        VerdictReason::FlowAngleContradicted(angle, r2) => format!(
            "the rate of {} contradicts the accelerometers and gyros (R2 {r2:.3}), corrected or not: a channel with its sign \
             reversed or recorded under another's name, damaged samples, or air too rough",
            name(*angle)
        ),
        VerdictReason::FlowAngleNotFollowed(angle, r2) => format!(
            "the rate of {} does not follow from the accelerometers and gyros (R2 {r2:.3}), corrected or not, or the air is too \
             rough",
            name(*angle)
        ),
        VerdictReason::Agree(scope) => format!("its instruments agree with each other{}", agreement_scope(scope)),
        VerdictReason::ErrorsFound(count) => format!("{count} instrument error(s) found"),
        VerdictReason::Outlier { alone, unexplained, reason } => {
            let with = if *alone { "itself alone" } else { "the runs it agrees with" };
            let why = if *unexplained { " and no cause of it found (do not pool it with them)" } else { "" };
            format!("an outlier among the runs, checked with {with}{why}: {}", verdict_reason(reason))
        }
    }
}

fn agreement_scope(scope: &AgreementScope) -> String {
    match scope {
        AgreementScope::Whole => String::new(),
        AgreementScope::AttitudeAndRates => " (attitude and rates only)".to_owned(),
        AgreementScope::RoughAir(contradictions) => {
            let all: Vec<String> = contradictions.iter().map(mean_force).collect();
            let but = if all.is_empty() { String::new() } else { format!("; but {}", all.join("; ")) };
            format!(" (attitude and rates only: the air is too rough for the rest{but})")
        }
    }
}

fn mean_force(one: &MeanForceContradiction) -> String {
    format!(
        "{} is {:.2} m/s^2 on average where {}, turn and flow give {:.2}{}",
        name(one.channel),
        one.mean,
        name(one.attitude),
        one.expected,
        if one.reversed { ", as with its sign reversed" } else { "" }
    )
}

pub(super) fn gross_error(error: &GrossError) -> String {
    match *error {
        GrossError::Turned(these) => format!("{} with its sign reversed", names(these)),
        GrossError::Unit(these, unit, _) => format!("{} in {unit}", names(these)),
        GrossError::Swapped([a, b]) => format!("{} and {} exchanged", name(a), name(b)),
    }
}

fn wiring_error(error: WiringError) -> String {
    match error {
        WiringError::Turned(channel) => format!("{} with its sign reversed", name(channel)),
        WiringError::Exchanged => "ax and ay under each other's names".to_owned(),
    }
}

/// How a wiring error explains a run.
pub fn wiring_finding(finding: WiringFinding) -> String {
    match finding {
        WiringFinding::Better(error) => format!(
            "it reads like one with {}: all channels then agree far better than with any errors of instruments",
            wiring_error(error)
        ),
        WiringFinding::AsWell(error) => format!(
            "it may be {}: all channels then agree as well as with errors of instruments, and the two are not distinguishable",
            wiring_error(error)
        ),
        WiringFinding::MakesBias(WiringError::Turned(_), channel) => format!(
            "{} reads like one with its sign reversed: its bias would be twice its mean, and the two are not distinguishable",
            name(channel)
        ),
        WiringFinding::MakesBias(WiringError::Exchanged, _) => "ax and ay read like each other, exchanged: the bias would be \
             the difference of their means, and the two are not distinguishable"
            .to_owned(),
    }
}

/// What cannot be known of a run's instruments.
pub fn not_observable(one: &NotObservable) -> String {
    match one {
        NotObservable::NotMeasured(channels) => format!("{}: not measured", names(channels)),
        NotObservable::VelocityUndetermined(accelerometers) => {
            let missing = if *accelerometers { "accelerometers" } else { "airspeed" };
            format!(
                "tas alpha beta altitude: without {missing} the velocity is not determined; only attitude and rates are compared"
            )
        }
        NotObservable::Unreported { error, value, std, reason } => {
            let unit = unit(error);
            format!("{}: {value:.3} +- {std:.3}{unit} would fit, but {}", error_name(error), unreported_reason(*reason))
        }
        NotObservable::NotExcited(error) => format!("{}: not excited by this motion", error_name(error)),
        NotObservable::InsufficientMotion(error) => {
            format!("{}: its axis moves too little compared with the others", error_name(error))
        }
        NotObservable::BelowLimit(error, least) => format!(
            "{}: less than {least:.2}{} could not be detected, this motion excites it too little",
            error_name(error),
            unit(error)
        ),
        NotObservable::Gusts => {
            "errors of tas alpha beta ax ay az and positions: the air is too rough, gusts have the same effect".to_owned()
        }
        NotObservable::HeadingBias => "psi bias: the initial heading is unknown".to_owned(),
        NotObservable::Altitude => {
            "altitude: vertical wind and static pressure have the same effect as errors of its instrument".to_owned()
        }
        NotObservable::Controls => {
            "controls: their sign, scale and delay are in no kinematic equation; `diagnose` compares them with a model".to_owned()
        }
    }
}

/// `ax bias 0.30 m/s^2`; `None` for what has no detection limit.
pub fn detection_limit(one: &NotObservable) -> Option<String> {
    let NotObservable::BelowLimit(error, least) = one else { return None };
    Some(format!("{} {least:.2}{}", error_name(error), unit(error)))
}

fn unreported_reason(reason: UnreportedReason) -> String {
    match reason {
        UnreportedReason::InsufficientMotion(part) => {
            format!("its axis moves too little compared with the others ({:.0} % of the busiest)", 100.0 * part)
        }
        UnreportedReason::Misalignment => "with its bias it may be a misalignment of the accelerometers".to_owned(),
        UnreportedReason::Gusts => "the air is too rough in this run".to_owned(),
        UnreportedReason::ImplausibleScale => "no instrument has such a factor".to_owned(),
    }
}

fn unit(error: &ChannelError) -> String {
    match error.kind {
        InstrumentErrorKind::Bias => error.channel.map_or(String::new(), |channel| format!(" {}", channel.si_unit())),
        InstrumentErrorKind::Timing => " s".to_owned(),
        InstrumentErrorKind::Scale => String::new(),
        _ => " m".to_owned(),
    }
}

fn error_name(error: &ChannelError) -> String {
    let channel = error.channel.map_or("", name);
    let axis = |axis: usize| ["x", "y", "z"].get(axis).copied().unwrap_or("");
    match error.kind {
        InstrumentErrorKind::Bias => format!("{channel} bias"),
        InstrumentErrorKind::Scale => format!("{channel} scale"),
        InstrumentErrorKind::Timing => format!("{channel} lag or skew"),
        InstrumentErrorKind::AlphaPlace(a) => format!("position of the alpha vane alone, {}", axis(a)),
        InstrumentErrorKind::BetaPlace(a) => format!("position of the beta vane alone, {}", axis(a)),
        InstrumentErrorKind::VanePlace(a) => format!("vane position {}", axis(a)),
        InstrumentErrorKind::AccelerometerPlace(a) => format!("accelerometer position {}", axis(a)),
        InstrumentErrorKind::Flow(_) | InstrumentErrorKind::Misalignment(_) => String::new(),
    }
}

/// What to fly or to measure so that two explanations of one error are distinguished.
pub const fn separation(pair: Separation) -> &'static str {
    match pair {
        Separation::LagOrSkew => "lag or skew: a sharper input, with edges above 1 Hz (a lag attenuates them, a skew does not)",
        Separation::VaneOrAccelerometers => {
            "vane or accelerometers: measure the two positions; or climbs and banks, which altitude and airspeed respond to"
        }
        Separation::PositionOrDelay => "position or delay: the same input at another speed (a lever arm adds r/V)",
        Separation::ScaleOrScale => "one scale factor or another: steady turns against flat sideslips, with the heading measured",
        Separation::BiasOrBias => "one bias or another: the trim of a model, or steady flight at several bank and pitch angles",
        Separation::BiasOrScale => "bias or scale factor: larger changes of the quantity itself",
        Separation::OtherInput => "a larger input on the other axis, or the same one again",
    }
}
