//! Piecewise linear functions of time, and the exact operations of a control path on them.
//!
//! Consumes breakpoints (time s, value) in increasing time; before the first and after the last the value is held.
//! Every operation gives a piecewise linear function again:
//!     dead zone   y = x - clamp(x, -h, h)                                                (1)
//!     delay       y(t) = x(t - d)                                                        (2)
//!     rate limit  y' = R sign(x - y) until y meets x, then y = x while |x'| <= R         (3)
//!     sum         y = x + k z                                                            (4)
//! Refused: times that do not increase, numbers that are not finite.

/// A piecewise linear function of time.
#[derive(Clone, Debug, PartialEq)]
pub struct History {
    points: Vec<(f64, f64)>,
}

/// Breakpoints that are no function of time.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the message of each says what its fields are")]
pub enum HistoryError {
    #[error("no value at all")]
    Empty,
    #[error("value {value} at {time_s} s is not finite")]
    NotFinite { time_s: f64, value: f64 },
    #[error("time goes from {before_s} s to {time_s} s")]
    TimeOrder { before_s: f64, time_s: f64 },
}

impl History {
    /// The same value at all times.
    pub fn constant(value: f64) -> Self {
        History { points: vec![(0.0, value)] }
    }

    /// Straight lines through these (time s, value).
    ///
    /// # Errors
    /// [`HistoryError`] with the first breakpoint that is wrong.
    pub fn through(points: Vec<(f64, f64)>) -> Result<Self, HistoryError> {
        if points.is_empty() {
            return Err(HistoryError::Empty);
        }
        for &(time_s, value) in &points {
            if !time_s.is_finite() || !value.is_finite() {
                return Err(HistoryError::NotFinite { time_s, value });
            }
        }
        for (&(before_s, _), &(time_s, _)) in points.iter().zip(points.iter().skip(1)) {
            if time_s <= before_s {
                return Err(HistoryError::TimeOrder { before_s, time_s });
            }
        }
        Ok(History { points })
    }

    /// The breakpoints.
    pub fn points(&self) -> &[(f64, f64)] {
        &self.points
    }

    /// Times of the breakpoints, s.
    pub fn times(&self) -> impl Iterator<Item = f64> {
        self.points.iter().map(|&(time_s, _)| time_s)
    }

    /// The value at a time, s.
    pub fn at(&self, time_s: f64) -> f64 {
        self.before(self.points.partition_point(|&(t, _)| t <= time_s), time_s)
    }

    /// The value at a time, s, the first breakpoint after it given.
    fn before(&self, after: usize, time_s: f64) -> f64 {
        let before = after.checked_sub(1).and_then(|place| self.points.get(place));
        match (before, self.points.get(after)) {
            (Some(&(t0, x0)), Some(&(t1, x1))) => x0 + (x1 - x0) * ((time_s - t0) / (t1 - t0)),
            (Some(&(_, x)), None) | (None, Some(&(_, x))) => x,
            (None, None) => 0.0,
        }
    }

    /// As [`History::at`] for times that do not go back; `after`, zero at first, remembers the place.
    pub(crate) fn at_next(&self, time_s: f64, after: &mut usize) -> f64 {
        while self.points.get(*after).is_some_and(|&(t, _)| t <= time_s) {
            *after += 1;
        }
        self.before(*after, time_s)
    }

    /// The lines through the values at these increasing times: what a recording sampled then would show.
    pub fn sampled(&self, times_s: &[f64]) -> Self {
        let mut after = 0;
        let points: Vec<(f64, f64)> = times_s.iter().map(|&time_s| (time_s, self.at_next(time_s, &mut after))).collect();
        if points.is_empty() { self.clone() } else { History { points } }
    }

    /// `x + offset`.
    pub fn shifted(mut self, offset: f64) -> Self {
        self.points.iter_mut().for_each(|(_, value)| *value += offset);
        self
    }

    /// Equation (2), seconds.
    pub fn delayed(mut self, delay_s: f64) -> Self {
        self.points.iter_mut().for_each(|(time_s, _)| *time_s += delay_s);
        self
    }

    /// Equation (4).
    pub fn plus(&self, gain: f64, other: &History) -> Self {
        let mut times: Vec<f64> = self.times().chain(other.times()).collect();
        times.sort_by(f64::total_cmp);
        times.dedup();
        History { points: times.into_iter().map(|time_s| (time_s, self.at(time_s) + gain * other.at(time_s))).collect() }
    }

    /// Equation (1), with breakpoints where the dead zone is entered and left.
    pub fn with_dead_zone(&self, half_width: f64) -> Self {
        let narrowed = |x: f64| x - x.clamp(-half_width, half_width);
        let mut lines = Lines::default();
        for (place, &(t1, x1)) in self.points.iter().enumerate() {
            if let Some(&(t0, x0)) = place.checked_sub(1).and_then(|before| self.points.get(before)) {
                let mut crossings: Vec<f64> = [-half_width, half_width]
                    .into_iter()
                    .filter(|edge| (x0 - edge) * (x1 - edge) < 0.0)
                    .map(|edge| t0 + (t1 - t0) * ((edge - x0) / (x1 - x0)))
                    .collect();
                crossings.sort_by(f64::total_cmp);
                crossings.into_iter().filter(|&t| t < t1).for_each(|t| lines.add(t, 0.0));
            }
            lines.add(t1, narrowed(x1));
        }
        History { points: lines.points }
    }

    /// Equation (3), with breakpoints where the limit takes hold and where it lets go.
    pub fn with_rate_limit(&self, rate: f64) -> Self {
        let mut limiter = RateLimiter::new(rate);
        let mut limited = limiter.follow(self);
        // Past the last breakpoint the input is held and the output still catches up.
        limited.points.extend(limiter.catches_up());
        limited
    }

    /// The part up to that time, which becomes its last breakpoint; what is held before the first stays so.
    pub(crate) fn until(&self, end_s: f64) -> Self {
        let mut points: Vec<(f64, f64)> = self.points.iter().copied().take_while(|&(time_s, _)| time_s < end_s).collect();
        points.push((end_s, self.at(end_s)));
        History { points }
    }

    /// The part between two times, which become its first and last breakpoints.
    pub(crate) fn within(&self, start_s: f64, end_s: f64) -> Self {
        let inside = |&&(time_s, _): &&(f64, f64)| time_s > start_s && time_s < end_s;
        let first = self.points.partition_point(|&(time_s, _)| time_s <= start_s);
        let mut points = vec![(start_s, self.at(start_s))];
        points.extend(self.points.iter().skip(first).take_while(inside));
        points.push((end_s, self.at(end_s)));
        History { points }
    }

    /// Adds to each breakpoint what `by` says of its time, s.
    pub(crate) fn bent_by(mut self, by: impl Fn(f64) -> f64) -> Self {
        self.points.iter_mut().for_each(|(time_s, value)| *value += by(*time_s));
        self
    }

    /// Goes on as the other does after this one's last breakpoint.
    pub(crate) fn append(&mut self, other: &History) {
        let last_s = self.points.last().map_or(f64::NEG_INFINITY, |&(time_s, _)| time_s);
        self.points.extend(other.points.iter().filter(|&&(time_s, _)| time_s > last_s));
    }
}

/// Equation (3) as its input comes in, piece after piece.
#[derive(Clone, Debug)]
pub(crate) struct RateLimiter {
    rate: f64,
    /// Time, input and output at the end of what came in.
    last: Option<(f64, f64, f64)>,
}

impl RateLimiter {
    pub(crate) fn new(rate: f64) -> Self {
        RateLimiter { rate, last: None }
    }

    /// The output over the next piece of input; the first piece starts settled, each later one where the last ended.
    pub(crate) fn follow(&mut self, piece: &History) -> History {
        let mut lines = Lines::default();
        for &(t1, x1) in &piece.points {
            let Some((mut t, mut x, mut y)) = self.last else {
                lines.add(t1, x1);
                self.last = Some((t1, x1, x1));
                continue;
            };
            if t1 <= t {
                lines.add(t, y);
                continue;
            }
            let slope = (x1 - x) / (t1 - t);
            // At most one meeting a line where the input is slow, two where the input overtakes.
            while t < t1 {
                let error = x - y;
                if error == 0.0 && slope.abs() <= self.rate {
                    (t, x, y) = (t1, x1, x1);
                    break;
                }
                let toward = if error == 0.0 { slope.signum() } else { error.signum() };
                let closing = self.rate - slope * toward;
                let meets = if error != 0.0 && closing > 0.0 { t + error.abs() / closing } else { f64::INFINITY };
                if meets < t1 {
                    x += slope * (meets - t);
                    (t, y) = (meets.max(t), x);
                    lines.add(t, y);
                } else {
                    y += toward * self.rate * (t1 - t);
                    (t, x) = (t1, x1);
                }
            }
            lines.add(t1, y);
            self.last = Some((t, x, y));
        }
        History { points: lines.points }
    }

    /// Where the output meets an input that is held from now on, if it has not.
    fn catches_up(&self) -> Option<(f64, f64)> {
        let (t, x, y) = self.last?;
        ((x - y).abs() > 0.0).then(|| (t + (x - y).abs() / self.rate, x))
    }
}

/// Breakpoints gathered in increasing time; one that would stand at its neighbour's time is left out.
#[derive(Default)]
struct Lines {
    points: Vec<(f64, f64)>,
}

impl Lines {
    fn add(&mut self, time_s: f64, value: f64) {
        if self.points.last().is_none_or(|&(last, _)| time_s > last) {
            self.points.push((time_s, value));
        }
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "values are carried, or exact in binary")]
mod tests {
    use super::*;

    fn zigzag() -> History {
        History::through(vec![(0.0, 0.0), (1.0, 3.0), (1.5, -2.0), (4.0, -2.0), (4.25, 1.0), (7.0, 0.5)]).unwrap()
    }

    #[test]
    fn values_lie_on_the_lines_and_are_held_outside() {
        let x = zigzag();
        assert_eq!([x.at(-1.0), x.at(0.5), x.at(1.0), x.at(1.25), x.at(9.0)], [0.0, 1.5, 3.0, 0.5, 0.5]);
        let mut after = 0;
        for time_s in [-1.0, 0.0, 0.0, 0.3, 1.0, 1.2, 4.1, 4.1, 7.0, 9.0] {
            assert_eq!(x.at_next(time_s, &mut after), x.at(time_s));
        }
        assert_eq!(x.clone().delayed(0.5).at(1.5), 3.0);
        assert_eq!(x.plus(2.0, &x).at(1.25), 1.5);
        assert_eq!(x.sampled(&[0.5, 1.0]).points(), [(0.5, 1.5), (1.0, 3.0)]);
    }

    #[test]
    fn what_is_no_function_of_time_is_refused() {
        assert_eq!(History::through(vec![]), Err(HistoryError::Empty));
        assert_eq!(History::through(vec![(1.0, 0.0), (1.0, 1.0)]), Err(HistoryError::TimeOrder { before_s: 1.0, time_s: 1.0 }));
        assert!(matches!(History::through(vec![(0.0, f64::NAN)]), Err(HistoryError::NotFinite { .. })));
    }

    #[test]
    fn the_dead_zone_is_exact_everywhere() {
        let x = zigzag();
        let y = x.with_dead_zone(0.75);
        for step in 0..=800 {
            let t = f64::from(step) * 0.01;
            let wanted = x.at(t) - x.at(t).clamp(-0.75, 0.75);
            assert!((y.at(t) - wanted).abs() < 1e-12, "{t}: {} is not {wanted}", y.at(t));
        }
    }

    #[test]
    fn pieces_put_together_are_the_whole() {
        let x = zigzag();
        let cuts = [0.3, 1.0, 1.2, 3.9, 6.0, 8.0];
        for rate in [0.7, 4.0] {
            let mut limiter = RateLimiter::new(rate);
            let mut y = limiter.follow(&x.until(cuts[0]));
            for cut in cuts.windows(2) {
                y.append(&limiter.follow(&x.within(cut[0], cut[1])));
            }
            let whole = x.with_rate_limit(rate);
            for step in 0..=800 {
                let t = f64::from(step) * 0.01;
                assert!((y.at(t) - whole.at(t)).abs() < 1e-12, "rate {rate}, {t}");
            }
        }
        assert_eq!(x.within(1.0, 1.25).points(), [(1.0, 3.0), (1.25, 0.5)]);
        assert_eq!(x.until(1.25).points(), [(0.0, 0.0), (1.0, 3.0), (1.25, 0.5)]);
    }

    #[test]
    fn the_rate_limit_agrees_with_small_steps() {
        let x = zigzag();
        for rate in [0.7, 1.0, 4.0, 20.0] {
            let y = x.with_rate_limit(rate);
            let (step, mut slow) = (1e-5, 0.0);
            for count in 1..=1_200_000 {
                let t = f64::from(count) * step;
                slow += (x.at(t) - slow).clamp(-rate * step, rate * step);
                if count % 1000 == 0 {
                    assert!((y.at(t) - slow).abs() < 1e-3, "rate {rate}, {t}: {} is not {slow}", y.at(t));
                }
            }
        }
        assert_eq!(x.with_rate_limit(20.0), x);
    }
}
