//! Steady-heading sideslips: N_v and L_v from the control positions that hold them.
//!
//! Consumes runs, of which it takes the parts that are steady sideslips; produces the slope of each control against the side
//! velocity v = V sin(beta) with its standard error, and from it static derivatives. Without rates and accelerations
//!     0 = N_v v + sum_c N_c delta_c     0 = L_v v + sum_c L_c delta_c     over the controls c          (1)
//!     N_v = -sum_c N_c d(delta_c)/dv    L_v = -sum_c L_c d(delta_c)/dv                                 (2)
//! with the control derivatives of runs in which the controls moved, var(N_v) = sum (N_c s_c)^2 + d' cov(N) d. A part is steady
//! where over [`WINDOW_S`] mean roll and yaw rate are below [`STILL_RADPS`] and sideslip changes by less than [`STILL_RAD`]
//! between the halves; neighbouring windows of one sideslip are averaged to one point, since their deviations are not
//! independent. Slopes by least squares with two degrees of freedom fewer than points.
//! Source: Padfield et al. 1987, section 4 (N_v and L_v of Fig 20); G. D. Padfield, Helicopter Flight Dynamics, 2nd ed. 2007, ch.
//! 4.
//! Returns the reason for fewer than three points, or sideslips that span less than [`LEAST_SPAN`] of the airspeed.

use super::columns::Columns;

/// Length of a window, s.
pub const WINDOW_S: f64 = 2.0;
/// Mean rate below which a window is steady, rad/s.
pub const STILL_RADPS: f64 = 0.01;
/// Largest change of sideslip within one point, rad.
pub const STILL_RAD: f64 = 0.007;
/// Least span of v, relative to V.
pub const LEAST_SPAN: f64 = 0.04;

/// One steady sideslip.
#[derive(Clone, Debug, PartialEq)]
pub struct Plateau {
    /// Index of the run.
    pub run: usize,
    /// v, m/s.
    pub v: f64,
    /// Mean control positions in the order asked for, rad.
    pub controls: Vec<f64>,
}

/// Steady sideslips and slopes of the controls.
#[derive(Clone, Debug, PartialEq)]
pub struct SteadySideslips {
    /// The steady sideslips.
    pub plateaus: Vec<Plateau>,
    /// d(delta)/dv and its standard error, rad s/m, by control.
    pub slopes: Vec<(f64, f64)>,
}

/// Steady sideslips of these runs, or the reason why there are too few.
pub fn steady_sideslips(runs: &[&Columns], controls: &[String]) -> Result<SteadySideslips, String> {
    let mut plateaus: Vec<Plateau> = Vec::new();
    let mut speed = 0.0_f64;
    for (place, run) in runs.iter().enumerate() {
        let raw = |name: &str| run.raw(name).map_err(|error| error.to_string());
        let (tas, beta, p, r) = (raw("tas")?, raw("beta")?, raw("p")?, raw("r")?);
        let held = controls.iter().map(|name| raw(name)).collect::<Result<Vec<_>, _>>()?;
        let (Some(&first_s), Some(&last_s)) = (run.times_s.first(), run.times_s.last()) else { continue };
        let windows = libm::floor((last_s - first_s) / WINDOW_S) as usize;
        // Sideslip of the last window, and number of windows of its point.
        let mut open: Option<(f64, f64)> = None;
        for window in 0..windows {
            let from_s = first_s + WINDOW_S * window as f64;
            let over = |values: &[f64], from_s: f64, to_s: f64| {
                let known = run.times_s.iter().zip(values).filter(|(t, x)| **t >= from_s && **t < to_s && x.is_finite());
                let (sum, count) = known.fold((0.0, 0.0), |(sum, count), (_, x)| (sum + x, count + 1.0));
                sum / count
            };
            let mean = |values: &[f64]| over(values, from_s, from_s + WINDOW_S);
            let middle_s = from_s + 0.5 * WINDOW_S;
            let drift = over(beta, from_s, middle_s) - over(beta, middle_s, from_s + WINDOW_S);
            let now = mean(beta);
            let steady = mean(p).abs() < STILL_RADPS && mean(r).abs() < STILL_RADPS && drift.abs() < STILL_RAD;
            let values: Vec<f64> = held.iter().map(|values| mean(values)).collect();
            if !steady || !now.is_finite() || values.iter().any(|value| !value.is_finite()) || !mean(tas).is_finite() {
                open = None;
                continue;
            }
            let v = mean(tas) * libm::sin(now);
            speed = speed.max(mean(tas));
            match (open, plateaus.last_mut()) {
                (Some((before, count)), Some(last)) if (now - before).abs() < STILL_RAD => {
                    let join = |old: f64, new: f64| (old * count + new) / (count + 1.0);
                    last.v = join(last.v, v);
                    last.controls.iter_mut().zip(&values).for_each(|(old, new)| *old = join(*old, *new));
                    open = Some((now, count + 1.0));
                }
                _ => {
                    plateaus.push(Plateau { run: place, v, controls: values });
                    open = Some((now, 1.0));
                }
            }
        }
    }
    let (least, most) = plateaus.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), one| (a.min(one.v), b.max(one.v)));
    if plateaus.len() < 3 || !(most - least > LEAST_SPAN * speed) {
        let span = if plateaus.is_empty() { 0.0 } else { most - least };
        return Err(format!(
            "expected three steady sideslips or more over {:.1} m/s of side velocity, found {} over {span:.1} m/s",
            LEAST_SPAN * speed,
            plateaus.len()
        ));
    }
    let slopes = (0..controls.len()).map(|control| slope(&plateaus, control)).collect();
    Ok(SteadySideslips { plateaus, slopes })
}

fn slope(plateaus: &[Plateau], control: usize) -> (f64, f64) {
    let count = plateaus.len() as f64;
    let y = |one: &Plateau| one.controls.get(control).copied().unwrap_or(f64::NAN);
    let (mean_v, mean_y) =
        plateaus.iter().fold((0.0, 0.0), |(sum_v, sum_y), one| (sum_v + one.v / count, sum_y + y(one) / count));
    let (vv, vy) = plateaus.iter().fold((0.0, 0.0), |(vv, vy), one| {
        let v = one.v - mean_v;
        (vv + v * v, vy + v * (y(one) - mean_y))
    });
    let slope = vy / vv;
    let left: f64 = plateaus.iter().map(|one| libm::pow(y(one) - mean_y - slope * (one.v - mean_v), 2.0)).sum();
    (slope, libm::sqrt(left / ((count - 2.0) * vv)))
}

impl SteadySideslips {
    /// (2) with the control derivatives of one axis and their covariance: the static derivative and its standard error.
    pub fn derivative(&self, control: &[f64], cov: impl Fn(usize, usize) -> f64) -> (f64, f64) {
        let (mut value, mut var) = (0.0, 0.0);
        for (i, ((slope, std), effect)) in self.slopes.iter().zip(control).enumerate() {
            value -= effect * slope;
            var += effect * effect * std * std;
            for (j, (other, _)) in self.slopes.iter().enumerate().take(control.len()) {
                var += slope * other * cov(i, j);
            }
        }
        (value, libm::sqrt(var.max(0.0)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flight::run::RunGeometry;

    fn held(beta: &dyn Fn(f64) -> f64) -> Columns {
        let times: Vec<f64> = (0..1200).map(|k| 0.01 * f64::from(k)).collect();
        let column = |of: &dyn Fn(f64) -> f64| times.iter().map(|&t| of(t)).collect::<Vec<f64>>();
        let v = |t: f64| 50.0 * f64::sin(beta(t));
        let columns = vec![
            ("tas".to_owned(), column(&|_| 50.0)),
            ("beta".to_owned(), column(beta)),
            ("p".to_owned(), column(&|_| 0.0)),
            ("r".to_owned(), column(&|_| 0.001)),
            ("pedal".to_owned(), column(&|t| 0.1 + 0.004 * v(t))),
            ("lat_cyclic".to_owned(), column(&|t| -0.02 + 0.003 * v(t))),
        ];
        Columns::new("a".to_owned(), RunGeometry::DEFAULT, times, columns, 1.0).unwrap()
    }

    #[test]
    fn controls_held_against_sideslip_give_the_static_derivatives() {
        // Three levels of four seconds in one run, one in another.
        let steps = held(&|t| {
            if t < 4.0 {
                -0.08
            } else if t < 8.0 {
                0.0
            } else {
                0.06
            }
        });
        let level = held(&|_| 0.1);
        let controls = ["lat_cyclic".to_owned(), "pedal".to_owned()];
        let found = steady_sideslips(&[&steps, &level], &controls).unwrap();
        assert_eq!(found.plateaus.len(), 4, "{found:?}");
        assert!((found.slopes[0].0 - 0.003).abs() < 1e-9 && (found.slopes[1].0 - 0.004).abs() < 1e-9, "{found:?}");
        // N_v = -(2.0*0.003 - 8.0*0.004) = 0.026; its error is that of N_pedal, 0.1*0.004.
        let (value, std) = found.derivative(&[2.0, -8.0], |i, j| if (i, j) == (1, 1) { 0.01 } else { 0.0 });
        assert!((value - 0.026).abs() < 1e-9 && (std - 4e-4).abs() < 1e-9, "{value} {std}");
    }

    #[test]
    fn motion_is_no_steady_sideslip() {
        let controls = ["pedal".to_owned()];
        let swinging = held(&|t| 0.1 * f64::sin(1.5 * t));
        assert!(steady_sideslips(&[&swinging], &controls).unwrap_err().contains("expected three steady sideslips"));
        assert!(steady_sideslips(&[&held(&|_| 0.05)], &controls).unwrap_err().contains("found 1 over 0.0 m/s"));
        assert!(steady_sideslips(&[&swinging], &["rudder".to_owned()]).unwrap_err().contains("`rudder`"));
    }
}
