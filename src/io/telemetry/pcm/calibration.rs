//! From the number of a raw word to engineering units, and back.
//!
//! Consumes the value of a raw word and produces that of the quantity, in the unit of the parameter:
//!
//! | calibration | value |
//! | --- | --- |
//! | identity | the raw number |
//! | polynomial | `c0 + c1 x + c2 x^2 + ...`, inside its range of raw numbers where one is given |
//! | table | the value listed for exactly that raw number; any other has none |
//! | pair-wise linear | on the straight line between the neighbouring pairs |
//!
//! Outside of its range a calibration gives nothing, or a value that is marked as extrapolated: the polynomial itself, or the
//! straight line through the two pairs at that end. These are the conversions of IRIG 106 Chapter 9, group C (coefficients,
//! discrete, pair sets); coefficients of negative powers and derived parameters are not implemented.
//!
//! The inverse serves the encoder. It exists where the calibration is strictly monotone over the raw numbers of the parameter
//! (of a table: where no value is listed twice).

use super::polynomial::{bisect, is_monotone, value};

/// What becomes of a raw number outside of the range.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OutsideRange {
    /// It has no value.
    #[default]
    Refuse,
    /// It has the extrapolated value, marked.
    Flag,
}

/// A calibration.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Calibration {
    /// The raw number.
    #[default]
    Identity,
    /// Coefficients from the constant upwards.
    Polynomial {
        /// The coefficients.
        coefficients: Vec<f64>,
        /// Least and greatest raw number.
        range: Option<(f64, f64)>,
        /// Beyond these.
        outside: OutsideRange,
    },
    /// Raw number and value, raw numbers increasing.
    Table {
        /// The pairs.
        pairs: Vec<(f64, f64)>,
    },
    /// Raw number and value, raw numbers increasing.
    PairWiseLinear {
        /// The pairs.
        pairs: Vec<(f64, f64)>,
        /// Beyond the first and the last.
        outside: OutsideRange,
    },
}

/// Why a calibration cannot be used.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the message of each says what its fields are")]
pub enum CalibrationError {
    #[error("expected 1 to {most} coefficients, found {found}")]
    Coefficients { most: usize, found: usize },
    #[error("expected {least} to {most} pairs, found {found}")]
    Pairs { least: usize, most: usize, found: usize },
    #[error("expected finite numbers, found {found} at number {number}")]
    NotFinite { number: usize, found: f64 },
    #[error("expected raw numbers that increase, found {found} behind {before} at pair {number}")]
    NotIncreasing { number: usize, before: f64, found: f64 },
    #[error("expected a range from a lower to a higher raw number, found {low} to {high}")]
    Range { low: f64, high: f64 },
    #[error("it is not strictly monotone from {low} to {high}, so a value has not one raw number")]
    NotMonotone { low: f64, high: f64 },
}

/// A value in engineering units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CalibratedValue {
    /// The value.
    pub value: f64,
    /// Whether the raw number is outside of the calibration's range.
    pub extrapolated: bool,
}

/// The raw number of a value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InverseValue {
    /// The raw number, not rounded.
    pub raw: f64,
    /// Whether the value is more than half a step of the raw number beyond its last one; of a table, whether it is not listed.
    pub beyond: bool,
}

/// Most coefficients.
const COEFFICIENTS_MAX: usize = 32;
/// Most pairs.
const PAIRS_MAX: usize = 65_536;

impl Calibration {
    /// Whether it can be used.
    ///
    /// # Errors
    /// [`CalibrationError`], the first found.
    pub fn check(&self) -> Result<(), CalibrationError> {
        match self {
            Calibration::Identity => Ok(()),
            Calibration::Polynomial { coefficients, range, .. } => {
                if !(1..=COEFFICIENTS_MAX).contains(&coefficients.len()) {
                    return Err(CalibrationError::Coefficients { most: COEFFICIENTS_MAX, found: coefficients.len() });
                }
                all_finite(coefficients.iter().copied())?;
                match *range {
                    Some((low, high)) if !(low.is_finite() && high.is_finite() && low < high) => {
                        Err(CalibrationError::Range { low, high })
                    }
                    _ => Ok(()),
                }
            }
            Calibration::Table { pairs } => check_pairs(pairs, 1),
            Calibration::PairWiseLinear { pairs, .. } => check_pairs(pairs, 2),
        }
    }

    /// The value of a raw number; `None` where there is none.
    #[must_use]
    #[inline]
    pub fn apply(&self, raw: f64) -> Option<CalibratedValue> {
        let found = match self {
            Calibration::Identity => CalibratedValue { value: raw, extrapolated: false },
            Calibration::Polynomial { coefficients, range, outside } => {
                let extrapolated = range.is_some_and(|(low, high)| !(low..=high).contains(&raw));
                if extrapolated && *outside == OutsideRange::Refuse {
                    return None;
                }
                CalibratedValue { value: value(coefficients, raw), extrapolated }
            }
            Calibration::Table { pairs } => {
                let place = pairs.partition_point(|(listed, _)| *listed < raw);
                let (_, value) = *pairs.get(place).filter(|(listed, _)| *listed <= raw)?;
                CalibratedValue { value, extrapolated: false }
            }
            Calibration::PairWiseLinear { pairs, outside } => {
                let (first, last) = (pairs.first()?.0, pairs.last()?.0);
                let extrapolated = !(first..=last).contains(&raw);
                if extrapolated && *outside == OutsideRange::Refuse {
                    return None;
                }
                let place = pairs.partition_point(|(listed, _)| *listed <= raw).clamp(1, pairs.len() - 1);
                let [from, to] = *pairs.get(place - 1..)?.first_chunk::<2>()?;
                CalibratedValue { value: on_line(from, to, raw), extrapolated }
            }
        };
        found.value.is_finite().then_some(found)
    }

    /// Whether the inverse exists over raw numbers from `low` to `high`.
    ///
    /// # Errors
    /// [`CalibrationError::NotMonotone`] where it does not.
    pub fn check_inverse(&self, low: f64, high: f64) -> Result<(), CalibrationError> {
        let (low, high) = self.usable(low, high);
        let exists = match self {
            Calibration::Identity => true,
            Calibration::Polynomial { coefficients, .. } => is_monotone(coefficients, low, high),
            Calibration::Table { pairs } => {
                let mut values: Vec<f64> = pairs.iter().map(|(_, value)| *value).collect();
                values.sort_by(f64::total_cmp);
                values.windows(2).all(|two| matches!(two, [a, b] if a < b))
            }
            Calibration::PairWiseLinear { pairs, .. } => {
                let rises = |two: &[(f64, f64)]| matches!(two, [a, b] if a.1 < b.1);
                let falls = |two: &[(f64, f64)]| matches!(two, [a, b] if a.1 > b.1);
                pairs.windows(2).all(rises) || pairs.windows(2).all(falls)
            }
        };
        if exists { Ok(()) } else { Err(CalibrationError::NotMonotone { low, high }) }
    }

    /// The raw number, from `low` to `high`, whose value is nearest; right where [`Calibration::check_inverse`] says that
    /// there is one inverse. Nothing is allocated.
    #[must_use]
    pub fn inverse(&self, wanted: f64, low: f64, high: f64) -> Option<InverseValue> {
        if wanted.is_nan() {
            return None;
        }
        let (low, high) = self.usable(low, high);
        let within = |raw: f64| InverseValue { raw: raw.clamp(low, high), beyond: !(low - 0.5..=high + 0.5).contains(&raw) };
        match self {
            Calibration::Identity => Some(within(wanted)),
            Calibration::Table { pairs } => {
                let away = |pair: &(f64, f64)| (pair.1 - wanted).abs();
                let nearest = pairs.iter().min_by(|a, b| away(a).total_cmp(&away(b)))?;
                Some(InverseValue { raw: nearest.0, beyond: away(nearest) > 0.0 })
            }
            Calibration::Polynomial { coefficients, .. } => match coefficients.as_slice() {
                [constant, slope] => Some(within((wanted - constant) / slope)),
                _ => between(|x| value(coefficients, x) - wanted, low, high),
            },
            Calibration::PairWiseLinear { .. } => {
                between(|x| self.apply(x).map_or(f64::NAN, |found| found.value) - wanted, low, high)
            }
        }
    }

    /// The part of the raw numbers that has values.
    fn usable(&self, low: f64, high: f64) -> (f64, f64) {
        let (first, last) = match self {
            Calibration::Polynomial { range: Some(range), outside: OutsideRange::Refuse, .. } => *range,
            Calibration::PairWiseLinear { pairs, outside: OutsideRange::Refuse } => match (pairs.first(), pairs.last()) {
                (Some(first), Some(last)) => (first.0, last.0),
                _ => return (low, high),
            },
            _ => return (low, high),
        };
        (low.max(first), high.min(last))
    }
}

/// The zero of a monotone function, or the end where it is nearer to zero.
fn between(function: impl Fn(f64) -> f64, low: f64, high: f64) -> Option<InverseValue> {
    let (at_low, at_high) = (function(low), function(high));
    if at_low.is_nan() || at_high.is_nan() || !(low <= high) {
        return None;
    }
    if (at_low > 0.0) == (at_high > 0.0) {
        let (raw, at_end, inside) =
            if at_low.abs() <= at_high.abs() { (low, at_low, low + 0.5) } else { (high, at_high, high - 0.5) };
        let half_step = (function(inside.clamp(low, high)) - at_end).abs();
        return Some(InverseValue { raw, beyond: at_end.abs() > half_step });
    }
    Some(InverseValue { raw: bisect(function, low, high), beyond: false })
}

fn on_line(from: (f64, f64), to: (f64, f64), raw: f64) -> f64 {
    from.1 + (to.1 - from.1) * ((raw - from.0) / (to.0 - from.0))
}

fn all_finite(numbers: impl Iterator<Item = f64>) -> Result<(), CalibrationError> {
    match numbers.zip(1..).find(|(number, _)| !number.is_finite()) {
        Some((found, number)) => Err(CalibrationError::NotFinite { number, found }),
        None => Ok(()),
    }
}

fn check_pairs(pairs: &[(f64, f64)], least: usize) -> Result<(), CalibrationError> {
    if !(least..=PAIRS_MAX).contains(&pairs.len()) {
        return Err(CalibrationError::Pairs { least, most: PAIRS_MAX, found: pairs.len() });
    }
    all_finite(pairs.iter().flat_map(|(raw, value)| [*raw, *value]))?;
    for (two, number) in pairs.windows(2).zip(2..) {
        if let [(before, _), (found, _)] = *two
            && !(before < found)
        {
            return Err(CalibrationError::NotIncreasing { number, before, found });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::test_random::Random;
    use super::*;

    fn at(calibration: &Calibration, raw: f64) -> Option<(f64, bool)> {
        calibration.apply(raw).map(|found| (found.value, found.extrapolated))
    }

    fn linear(outside: OutsideRange) -> Calibration {
        Calibration::PairWiseLinear { pairs: vec![(0.0, -10.0), (100.0, 0.0), (200.0, 40.0)], outside }
    }

    #[test]
    fn values_are_those_worked_out_by_hand() {
        let range = Some((0.0, 10.0));
        let coefficients = vec![1.0, 2.0, 0.5];
        let refusing = Calibration::Polynomial { coefficients: coefficients.clone(), range, outside: OutsideRange::Refuse };
        let marking = Calibration::Polynomial { coefficients, range, outside: OutsideRange::Flag };
        assert_eq!(
            (at(&refusing, 4.0), at(&refusing, 10.0), at(&refusing, 10.5)),
            (Some((17.0, false)), Some((71.0, false)), None)
        );
        assert_eq!(at(&marking, 12.0), Some((97.0, true)));
        assert_eq!(at(&Calibration::Identity, 7.0), Some((7.0, false)));
        let table = Calibration::Table { pairs: vec![(0.0, 5.0), (1.0, -1.0), (7.0, 3.0)] };
        assert_eq!(
            (at(&table, 1.0), at(&table, 2.0), at(&table, 8.0), at(&table, -0.0)),
            (Some((-1.0, false)), None, None, Some((5.0, false)))
        );
        let kept = linear(OutsideRange::Refuse);
        assert_eq!(
            (at(&kept, 50.0), at(&kept, 100.0), at(&kept, 150.0)),
            (Some((-5.0, false)), Some((0.0, false)), Some((20.0, false)))
        );
        assert_eq!((at(&kept, 200.0), at(&kept, 201.0), at(&kept, f64::NAN)), (Some((40.0, false)), None, None));
        let wide = linear(OutsideRange::Flag);
        assert_eq!((at(&wide, -50.0), at(&wide, 250.0)), (Some((-15.0, true)), Some((60.0, true))));
    }

    #[test]
    fn the_inverse_brings_every_raw_number_back() {
        let mut random = Random(6);
        let cubic =
            Calibration::Polynomial { coefficients: vec![-20.0, 0.02, 1e-6, 3e-9], range: None, outside: OutsideRange::Refuse };
        let falling = Calibration::Polynomial { coefficients: vec![5.0, -0.25], range: None, outside: OutsideRange::Refuse };
        let square = Calibration::Polynomial {
            coefficients: vec![0.0, 0.0, 1.0],
            range: Some((0.0, 4095.0)),
            outside: OutsideRange::Refuse,
        };
        for (calibration, low, high) in [
            (&cubic, 0.0, 4095.0),
            (&falling, -2048.0, 2047.0),
            (&square, -4096.0, 4095.0),
            (&linear(OutsideRange::Flag), -100.0, 4095.0),
            (&linear(OutsideRange::Refuse), -100.0, 4095.0),
        ] {
            calibration.check().unwrap();
            calibration.check_inverse(low, high).unwrap();
            for _ in 0..2000 {
                let raw = (low + (high - low) * random.unit()).round();
                let Some(found) = calibration.apply(raw) else { continue };
                let back = calibration.inverse(found.value, low, high).unwrap();
                assert!((back.raw - raw).abs() < 1e-6 && !back.beyond, "{calibration:?}: {raw} came back as {back:?}");
            }
        }
        let beyond = |raw| Some(InverseValue { raw, beyond: true });
        assert_eq!(square.inverse(-5.0, -4096.0, 4095.0), beyond(0.0), "beyond the end, the end");
        assert_eq!(falling.inverse(1e6, 0.0, 100.0), beyond(0.0));
        assert_eq!(cubic.inverse(1e9, 0.0, 4095.0), beyond(4095.0));
        let table = Calibration::Table { pairs: vec![(0.0, 5.0), (1.0, -1.0), (7.0, 3.0)] };
        assert_eq!((table.inverse(3.2, 0.0, 7.0), table.check_inverse(0.0, 7.0)), (beyond(7.0), Ok(())));
        assert_eq!(table.inverse(f64::NAN, 0.0, 7.0), None);
    }

    #[test]
    fn mistakes_are_refused() {
        let polynomial = |coefficients: &[f64], range| Calibration::Polynomial {
            coefficients: coefficients.to_vec(),
            range,
            outside: OutsideRange::Refuse,
        };
        let error = |calibration: Calibration| calibration.check().unwrap_err().to_string();
        assert!(error(polynomial(&[], None)).contains("1 to 32 coefficients, found 0"));
        assert!(error(polynomial(&[1.0, f64::NAN], None)).contains("NaN at number 2"));
        assert!(error(polynomial(&[1.0], Some((3.0, 3.0)))).contains("3 to 3"));
        assert!(error(Calibration::Table { pairs: vec![(1.0, 0.0), (1.0, 2.0)] }).contains("1 behind 1 at pair 2"));
        assert!(
            error(Calibration::PairWiseLinear { pairs: vec![(1.0, 0.0)], outside: OutsideRange::Flag }).contains("2 to 65536")
        );
        assert!(polynomial(&[0.0, 0.0, 1.0], None).check_inverse(-8.0, 7.0).is_err());
        assert!(Calibration::Table { pairs: vec![(1.0, 2.0), (3.0, 2.0)] }.check_inverse(0.0, 9.0).is_err());
        let flat = Calibration::PairWiseLinear { pairs: vec![(0.0, 2.0), (3.0, 2.0)], outside: OutsideRange::Flag };
        assert!(flat.check_inverse(0.0, 9.0).is_err());
    }
}
