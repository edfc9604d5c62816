//! What the kinematics confirm: sign and unit of ax and ay, the sign of the incidence, and the unit of the airspeed.
//!
//! Consumes the increments of the outputs over every window; produces a [`Confirmation`] of each instrument from slopes b of
//! measured increments on kinematic ones (`kinematic_slope`), which are 1 where the instrument reads right:
//! - ax and ay from their own shares in airspeed and sideslip;
//! - the airspeed V from three that all grow as V reads too large: the airspeed itself on the work of force and gravity, and
//!   incidence and sideslip, less what rotation makes of them, on acceleration over V. Their mean, weighted by
//!   1/(var b + `MODEL_STD`^2), is the scale of the airspeed.
//!
//! Positive evidence is asked for, because a wrong sign or unit of these leaves the other outputs in agreement. Moving air adds
//! to the measured increments and makes the standard errors larger; a vane whose position is not known makes b another number.

use super::gross_error::GrossError;
use super::kinematic_agreement::{AccelerationIncrements, Increments, OUTPUTS};
use super::kinematic_slope::{KinematicSlope, Slope};
use crate::flight::channel::Channel;
use crate::flight::unit::STANDARD_GRAVITY;

/// Time constant of forgetting, s.
const MEMORY_S: f64 = 30.0;
/// Largest standard error of a slope that confirms an accelerometer, and least squared correlation of one of ay or the airspeed.
const KNOWN: f64 = 0.45;
const CORRELATED: f64 = 0.25;
/// Deviation from 1 of a slope that confirms, in standard errors; for ay with what an arm that is not quite known adds.
const AROUND_ONE: f64 = 2.0;
const AY_AROUND_ONE: f64 = 3.0;
const ARM: f64 = 0.25;
/// Standard error of a slope of ay up to which moving air may hide it (in g it is ten times as large), and below which a slope
/// within so many of them of zero is zero.
const AY_UNKNOWN: f64 = 2.6;
const AY_WELL_KNOWN: f64 = 0.12;
const ZERO_WITHIN: f64 = 2.5;
/// Standard error above which a slope does not tell ay from a reversed one: 1 and -1 are 2.5 of them apart.
const AY_TELLS_SIGN: f64 = 0.8;
/// Slope of an accelerometer in ft/s^2, and standard errors by which that of an ax and of an ay that is confirmed exceeds it.
const IN_FEET: f64 = 0.3048;
const AX_FROM_FEET: f64 = 2.0;
const AY_FROM_FEET: f64 = 3.0;
/// Standard errors between the slope and -1, of a reversed accelerometer, that confirm ax: other instruments hardly show it.
const FROM_REVERSED: f64 = 5.0;
/// Limit of the deviation from 1 within which an airspeed's slope is that of the right unit and of still air.
const RIGHT: f64 = 0.4;
/// What the place of a vane and the lag of a pitot tube add to the standard error of a slope.
const MODEL_STD: f64 = 0.1;
/// Standard errors above zero of a slope that tells a scale: one of air that moves is not.
const TELLS: f64 = 2.0;
/// Standard errors within which a slope is that of an error, and beyond which it is not that of a right instrument.
const SHOWS_WITHIN: f64 = 3.0;
const SHOWS_BEYOND: f64 = 2.0;
/// An airspeed is confirmed where its scale is by two standard errors below the first limit (1 m/s is 1.94 kn), and contradicted
/// where it is by 2.5 outside of the interval. Moving air lowers the slopes: one by two standard errors above the lower limit
/// is not that of an airspeed in m/s taken for one in knots.
const CONFIRMED: f64 = 1.6;
const CONFIRMED_ABOVE: f64 = 0.55;
const CONTRADICTED: [f64; 2] = [0.72, 1.3];
const CONFIRMED_BY: f64 = 2.0;
/// Standard error of a scale above which the air hides it, where it may be right.
const SCALE_KNOWN: f64 = 0.25;
const CONTRADICTED_BY: f64 = 2.5;
/// Standard errors between the scale of an airspeed in still air and 1 from which on the difference is an error of its
/// derivatives, and what the place of a vane adds to the standard error of a slope then.
const SCALE_OFF_BY: f64 = 2.0;
const SCALE_MODEL_STD: f64 = 0.05;
/// Least slope of an aircraft that follows the air: what its vanes measure then is against the force.
const FOLLOWS_AIR: f64 = -0.4;
/// Standard errors below it, and above 1, of a slope that contradicts.
const BELOW: f64 = 1.5;
const ABOVE: f64 = 2.5;
/// Relative error of what is derived from an ay in g, a reversed one, and an airspeed in knots.
const BY_STANDARD_GRAVITY: f64 = STANDARD_GRAVITY - 1.0;
const BY_REVERSAL: f64 = 2.0;
const BY_KNOTS: f64 = 0.944;
/// Squared correlation of increments in air that hardly moves.
const STILL_AIR: f64 = 0.5;

/// What the kinematics tell about sign and unit of an instrument.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Confirmation {
    /// They contradict, do not show its readings in the motion (another channel's, or far too small), or tell too little where
    /// only they could.
    #[default]
    Doubted,
    /// They do not contradict: moving air may hide an error.
    Plausible {
        /// How wrong a derivative may be by it, relative to the derivative.
        relative_error: f64,
    },
    /// There is nothing to compare with.
    NotComparable,
    /// They are right.
    Confirmed,
}

impl Confirmation {
    /// The channels that need it, in the order of every list of confirmations.
    pub const CHANNELS: [Channel; 5] = [Channel::Ax, Channel::Ay, Channel::Az, Channel::Tas, Channel::Alpha];

    /// Whether it speaks for the instrument more than another one does.
    pub fn tells_more_than(self, other: Confirmation) -> bool {
        match (self, other) {
            (Confirmation::Plausible { relative_error: now }, Confirmation::Plausible { relative_error: before }) => now < before,
            _ => self == Confirmation::Confirmed,
        }
    }

    /// Its place in a list of confirmations.
    pub fn place(channel: Channel) -> Option<usize> {
        Confirmation::CHANNELS.iter().position(|one| *one == channel)
    }
}

/// What a contradiction of the airspeed is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AirspeedContradiction {
    /// The airspeed: two kinds of increments that follow the kinematics say so.
    Airspeed,
    /// The airspeed, another instrument, or the air.
    Unknown,
}

/// The slopes of one flight.
#[derive(Clone, Debug)]
pub struct InstrumentSlopes {
    airspeed: KinematicSlope,
    /// Shares of ax in airspeed and of ay in sideslip.
    shares: [KinematicSlope; 2],
    /// Incidence and sideslip on acceleration.
    flow_angles: [KinematicSlope; 2],
}

impl InstrumentSlopes {
    /// Without windows.
    pub const NEW: InstrumentSlopes = InstrumentSlopes {
        airspeed: KinematicSlope::ZERO,
        shares: [KinematicSlope::ZERO; 2],
        flow_angles: [KinematicSlope::ZERO; 2],
    };

    /// The window that ends with the next bin: all increments, and those of incidence and sideslip by acceleration.
    pub fn window(&mut self, increments: &Increments, by_acceleration: AccelerationIncrements) {
        self.airspeed.window(increments[0], MEMORY_S);
        for (axis, slope) in self.shares.iter_mut().enumerate() {
            slope.window(increments[OUTPUTS + axis], MEMORY_S);
        }
        for (slope, one) in self.flow_angles.iter_mut().zip(by_acceleration) {
            slope.window(one, MEMORY_S);
        }
    }

    /// Sign and unit of ax and ay. Without confirmation ax is doubted: it hardly moves the airspeed, and nothing else shows its
    /// errors. ay is confirmed only where the sideslip agrees with the kinematics as a whole; where the air hides its share it is
    /// plausible.
    pub fn accelerometers(&self, sideslip_agrees: bool) -> [Confirmation; 2] {
        let [ax, ay] = &self.shares;
        let ax = if ax.early_slope().is_some_and(|slope| confirms_ax(&slope)) {
            Confirmation::Confirmed
        } else {
            Confirmation::Doubted
        };
        let ay = match ay.early_slope() {
            None if ay.has_begun() => Confirmation::Doubted,
            None => Confirmation::NotComparable,
            Some(slope) if sideslip_agrees && confirms_ay(&slope) => Confirmation::Confirmed,
            Some(slope) if is_hidden_by_air(&slope) => Confirmation::Plausible { relative_error: hidden_error_of_ay(&slope) },
            Some(_) => Confirmation::Doubted,
        };
        [ax, ay]
    }

    /// Sign of the incidence: confirmed where its increments follow from acceleration. An aircraft that follows the air has them
    /// of the opposite sign, weakly correlated, so that no slope of weak correlation tells.
    pub fn incidence(&self) -> Confirmation {
        let [incidence, _] = &self.flow_angles;
        match incidence.early_slope() {
            None if !incidence.has_begun() => Confirmation::NotComparable,
            Some(slope) if tells(&slope) && slope.correlation_squared > STILL_AIR => Confirmation::Confirmed,
            _ => Confirmation::Doubted,
        }
    }

    /// Unit of the airspeed; plausible where nothing can be compared, or the air hides it.
    pub fn airspeed(&self) -> Confirmation {
        let compared = || self.flow_angles.iter().chain([&self.airspeed]);
        if compared().all(|slope| slope.early_slope().is_none()) {
            return if compared().any(KinematicSlope::has_begun) { Confirmation::Doubted } else { Confirmation::NotComparable };
        }
        if let Some(relative_error) = self.airspeed_scale_error() {
            return Confirmation::Plausible { relative_error };
        }
        match scale(self.airspeed_slopes(KinematicSlope::early_slope), MODEL_STD, tells_scale) {
            None => Confirmation::Plausible { relative_error: BY_KNOTS },
            Some((scale, std)) if scale + CONFIRMED_BY * std < CONFIRMED => {
                if scale - CONFIRMED_BY * std > CONFIRMED_ABOVE {
                    Confirmation::Confirmed
                } else {
                    Confirmation::Plausible { relative_error: libm::hypot(scale - 1.0, std) }
                }
            }
            Some((scale, std)) if std > SCALE_KNOWN && scale - CONFIRMED_BY * std < CONTRADICTED[1] => {
                Confirmation::Plausible { relative_error: libm::hypot(scale - 1.0, std) }
            }
            Some(_) => Confirmation::Doubted,
        }
    }

    /// Whether the airspeed reads in another unit, or too much or too little by far.
    pub fn airspeed_contradiction(&self) -> Option<AirspeedContradiction> {
        let [too_little, too_much] = CONTRADICTED;
        let reads_too_much = |(scale, std): (f64, f64)| scale - CONTRADICTED_BY * std > too_much;
        let slopes = self.airspeed_slopes(KinematicSlope::slope);
        let still = scale(slopes, MODEL_STD, is_of_still_air);
        // Air that moves lowers a slope: only one of still air tells that the airspeed reads too little.
        if still.is_some_and(|(scale, std)| reads_too_much((scale, std)) || scale + CONTRADICTED_BY * std < too_little) {
            // One kind of increments alone may be contradicted by an accelerometer or a vane.
            let kinds = slopes.iter().flatten().filter(|slope| is_of_still_air(slope)).count();
            return Some(if kinds > 1 { AirspeedContradiction::Airspeed } else { AirspeedContradiction::Unknown });
        }
        scale(slopes, MODEL_STD, tells_scale).filter(|found| reads_too_much(*found)).map(|_| AirspeedContradiction::Unknown)
    }

    /// By how much the airspeed reads too much or too little, relative to the truth, where increments in still air show it: the
    /// wrong factor of an instrument, or the indicated for the true airspeed.
    pub fn airspeed_scale_error(&self) -> Option<f64> {
        let (scale, std) = scale(self.airspeed_slopes(KinematicSlope::slope), SCALE_MODEL_STD, is_of_still_air)?;
        ((scale - 1.0).abs() > SCALE_OFF_BY * std).then(|| (scale - 1.0).abs())
    }

    fn airspeed_slopes(&self, of: fn(&KinematicSlope) -> Option<Slope>) -> [Option<Slope>; 3] {
        [of(&self.airspeed), of(&self.flow_angles[0]), of(&self.flow_angles[1])]
    }

    /// Whether the airspeed's own slope is known to be that of the right unit and of still air.
    pub fn airspeed_is_right(&self) -> bool {
        self.airspeed.slope().is_some_and(|slope| (slope.value - 1.0).abs() + 2.0 * slope.std < RIGHT)
    }

    /// Whether the slope of an instrument alone shows that error of it too; always for errors of which no slope is.
    pub fn shows(&self, error: &GrossError) -> bool {
        let (slope, expected) = match error {
            GrossError::Unit([Channel::Tas], _, size) => (self.airspeed.slope(), 1.0 / size),
            GrossError::Turned([Channel::Ay]) => (self.shares[1].slope(), -1.0),
            GrossError::Unit([Channel::Ay], _, size) => (self.shares[1].slope(), *size),
            _ => return true,
        };
        slope.is_some_and(|Slope { value, std, .. }| {
            let std = libm::hypot(std, MODEL_STD * value.abs().max(1.0));
            (value - expected).abs() < SHOWS_WITHIN * std && (value - 1.0).abs() > SHOWS_BEYOND * std
        })
    }
}

fn confirms_ax(slope: &Slope) -> bool {
    let Slope { value, std, .. } = *slope;
    let exceeds = |other: f64, errors: f64| value - other > errors * std;
    std < KNOWN && (value - 1.0).abs() < AROUND_ONE * std && exceeds(-1.0, FROM_REVERSED) && exceeds(IN_FEET, AX_FROM_FEET)
}

fn confirms_ay(slope: &Slope) -> bool {
    let Slope { value, std, correlation_squared } = *slope;
    let around_one = (value - 1.0).abs() < AY_AROUND_ONE * std + ARM;
    std < KNOWN && around_one && value - IN_FEET > AY_FROM_FEET * std && correlation_squared > CORRELATED
}

/// Whether the readings of ay are not in the motion: their slope is zero, as of another channel's readings, or they are so small
/// that it could be anything.
fn is_not_seen(slope: &Slope) -> bool {
    let Slope { value, std, .. } = *slope;
    std >= AY_UNKNOWN || std < AY_WELL_KNOWN && value.abs() < ZERO_WITHIN * std
}

/// Whether a slope of ay is one that moving air leaves: of readings that are seen, around 1 or not known to be positive, and no
/// further below that of an aircraft which follows the air than it may be by chance; where it is too uncertain to tell 1 from -1
/// and the increments hardly correlate, any below (the Navion's, in gusts of 1 m/s, are -1 to -6 +- 1).
fn is_hidden_by_air(slope: &Slope) -> bool {
    let Slope { value, std, .. } = *slope;
    let around_one = (value - 1.0).abs() < AY_AROUND_ONE * std + ARM;
    let may_be_of_air = value > FOLLOWS_AIR - BELOW * std || std > AY_TELLS_SIGN && slope.correlation_squared < STILL_AIR;
    !is_not_seen(slope) && (around_one || !tells(slope)) && may_be_of_air && value < 1.0 + ABOVE * std
}

/// The largest relative error by ay that its slope leaves. Moving air lowers the slope: to around 1 that of an ay in g, 9.81,
/// where the increments hardly correlate; that of a reversed one is none above that of an aircraft which follows the air, and
/// one that hardly exceeds that of an ay in ft/s^2 may be its slope.
fn hidden_error_of_ay(slope: &Slope) -> f64 {
    if slope.correlation_squared < STILL_AIR {
        BY_STANDARD_GRAVITY
    } else if slope.value - ABOVE * slope.std < -FOLLOWS_AIR {
        BY_REVERSAL
    } else if slope.value - AY_FROM_FEET * slope.std < IN_FEET {
        1.0 - IN_FEET
    } else {
        0.0
    }
}

/// Whether a slope is known to be positive: one of air that moves is not.
fn tells(slope: &Slope) -> bool {
    slope.value > TELLS * slope.std
}

/// Whether a slope is that of air which hardly moves.
fn is_of_still_air(slope: &Slope) -> bool {
    tells(slope) && slope.correlation_squared > STILL_AIR
}

/// Whether a slope tells the scale of the airspeed: the response to gusts correlates weakly.
fn tells_scale(slope: &Slope) -> bool {
    tells(slope) && slope.correlation_squared > CORRELATED
}

/// Weighted mean of the slopes that are used, and its standard error, with their scatter where that is larger.
fn scale(slopes: [Option<Slope>; 3], model_std: f64, is_used: impl Fn(&Slope) -> bool) -> Option<(f64, f64)> {
    let telling = || {
        let known = slopes.iter().flatten().filter(|slope| is_used(slope));
        known.map(|slope| (slope.value, 1.0 / (slope.std * slope.std + model_std * model_std)))
    };
    let (count, weights) = telling().fold((0.0, 0.0), |(count, sum), (_, weight)| (count + 1.0, sum + weight));
    if !(weights > 0.0) {
        return None;
    }
    let mean = telling().map(|(value, weight)| weight * value).sum::<f64>() / weights;
    let scatter = telling().map(|(value, weight)| weight * (value - mean) * (value - mean)).sum::<f64>();
    let excess = if count > 1.0 { (scatter / (count - 1.0)).max(1.0) } else { 1.0 };
    Some((mean, libm::sqrt(excess / weights)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::realtime::estimation::screening::kinematic_agreement::COMPARED;

    /// Slopes after so many windows in which every output follows its kinematics times a factor, beside a part of air.
    fn after(factor: f64, windows: usize, air: f64) -> InstrumentSlopes {
        let mut slopes = InstrumentSlopes::NEW;
        for i in 0..windows {
            let (k, air) = (libm::sin(0.2 * i as f64), air * libm::cos(0.13 * i as f64));
            let one = Some((factor * k + air, k));
            slopes.window(&[one; COMPARED], [one; 2]);
        }
        slopes
    }

    const AIR: f64 = 0.2;

    #[test]
    fn a_sign_and_a_unit_are_confirmed_where_they_are_right() {
        use Confirmation::{Confirmed, Doubted};
        let right = after(1.0, 200, AIR);
        assert_eq!(right.accelerometers(true), [Confirmed; 2]);
        assert_eq!(
            right.accelerometers(false),
            [Confirmed, Confirmation::Plausible { relative_error: 0.0 }],
            "the sideslip does not bear ay out"
        );
        assert!(right.airspeed() == Confirmed && right.incidence() == Confirmed && right.airspeed_contradiction().is_none());
        // Reversed, in g, and what the kinematics say hardly appears in the readings: air that moves, or a wrong unit.
        for wrong in [-1.0, 9.8, 0.1] {
            let [ax, ay] = after(wrong, 200, AIR).accelerometers(true);
            assert!(ax != Confirmed && ay != Confirmed, "{wrong}");
        }
        for contradicting in [-1.0, 9.8] {
            assert_eq!(after(contradicting, 200, AIR).accelerometers(true), [Doubted; 2], "{contradicting}");
        }
        // As of an aircraft that follows the air.
        let hidden = |relative_error: f64| Confirmation::Plausible { relative_error };
        assert_eq!(after(-0.4, 200, AIR).accelerometers(true)[1], hidden(BY_REVERSAL));
        assert_eq!(after(-0.4, 200, 0.4).accelerometers(true)[1], hidden(BY_STANDARD_GRAVITY), "hardly correlated");
        for few in [after(1.0, 40, 4.0 * AIR), after(-1.0, 40, 0.5 * AIR), after(1.0, 15, 0.5 * AIR)] {
            assert!(few.accelerometers(true) == [Doubted; 2] && few.airspeed_contradiction().is_none(), "too few windows");
        }
        let exact = after(1.0, 40, 0.5 * AIR);
        let [_, ay] = exact.accelerometers(true);
        assert!(ay == Confirmed && exact.airspeed() == Confirmed && exact.incidence() == Confirmed);
        let none = InstrumentSlopes::NEW;
        assert_eq!((none.airspeed(), none.incidence()), (Confirmation::NotComparable, Confirmation::NotComparable));
    }

    #[test]
    fn an_airspeed_in_another_unit_is_contradicted_and_a_reversed_incidence_not_confirmed() {
        for (factor, contradicted) in [(1.0, false), (1.944, true), (3.6, true), (0.514, true)] {
            let slopes = after(factor, 200, 0.1);
            assert_eq!(slopes.airspeed_contradiction().is_some(), contradicted, "{factor}");
            assert!(contradicted != (slopes.airspeed() == Confirmation::Confirmed) || factor < 1.0, "{factor}");
        }
        // A fifth too much or too little is no other unit, but an error of what the airspeed makes.
        for factor in [0.8, 1.2] {
            let Confirmation::Plausible { relative_error } = after(factor, 200, 0.05).airspeed() else { panic!("{factor}") };
            assert!((relative_error - 0.2).abs() < 0.02, "{factor}: {relative_error}");
        }
        assert_eq!(after(1.0, 200, 0.05).airspeed_scale_error(), None);
        assert_eq!(after(-1.0, 200, AIR).incidence(), Confirmation::Doubted);
        // Air that moves more than the aircraft hides the airspeed, and says nothing against it.
        let hidden = after(1.0, 200, 3.0);
        assert!(hidden.airspeed() != Confirmation::Confirmed && hidden.airspeed_contradiction().is_none());
    }

    #[test]
    fn an_error_is_shown_by_the_slope_of_its_instrument() {
        let error = |wanted: fn(&GrossError) -> bool| GrossError::ALL.iter().find(|error| wanted(error)).unwrap();
        let knots = error(|error| matches!(error, GrossError::Unit([Channel::Tas], "kn", _)));
        let reversed = error(|error| matches!(error, GrossError::Turned([Channel::Ay])));
        assert!(after(1.944, 200, 0.1).shows(knots) && !after(1.0, 200, 0.1).shows(knots));
        assert!(after(-1.0, 200, 0.1).shows(reversed) && !after(1.0, 200, 0.1).shows(reversed));
        assert!(
            InstrumentSlopes::NEW.shows(error(|error| matches!(error, GrossError::Turned([Channel::P])))),
            "no slope is of p"
        );
    }
}
