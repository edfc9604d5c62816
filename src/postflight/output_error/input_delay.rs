//! Delayed inputs, and their derivatives by the delay.
//!
//! Consumes times in s, an input and its delay tau in s; produces
//!     u_d(t) = u(t - tau),   du_d/dtau = -u'(t - tau)                                               (1)
//! at the record's own times, linear between them; before the first sample the input is constant.
//! Numerics: the corner of a delayed line lies between samples, where a straight line stands for it: an error within one
//! interval.

/// (1) for one input: values and their derivatives by the delay.
pub fn delayed_input(times_s: &[f64], input: &[f64], delay_s: f64) -> (Vec<f64>, Vec<f64>) {
    let mut segment = 0;
    let pairs = times_s.iter().map(|t| {
        let asked = t - delay_s;
        while segment + 2 < times_s.len() && times_s.get(segment + 1).is_some_and(|&next| next <= asked) {
            segment += 1;
        }
        let ends = (times_s.get(segment), times_s.get(segment + 1), input.get(segment), input.get(segment + 1));
        let (Some(t0), Some(t1), Some(u0), Some(u1)) = ends else { return (input.first().copied().unwrap_or(f64::NAN), 0.0) };
        if asked <= *t0 && segment == 0 {
            return (*u0, 0.0);
        }
        if asked >= *t1 {
            return (*u1, 0.0);
        }
        let slope = (u1 - u0) / (t1 - t0);
        (u0 + slope * (asked - t0), -slope)
    });
    pairs.unzip()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ramp_is_moved_and_its_ends_are_held() {
        let times: Vec<f64> = (0..6).map(|k| 0.1 * f64::from(k)).collect();
        let ramp: Vec<f64> = times.iter().map(|t| 2.0 * t).collect();
        let (late, change) = delayed_input(&times, &ramp, 0.15);
        for (k, expected) in [0.0, 0.0, 0.1, 0.3, 0.5, 0.7].iter().enumerate() {
            assert!((late[k] - expected).abs() < 1e-12, "{late:?}");
        }
        assert_eq!((change[0], change[1]), (0.0, 0.0));
        assert!(change[2..].iter().all(|slope| (slope + 2.0).abs() < 1e-12));
        let (same, _) = delayed_input(&times, &ramp, 0.0);
        assert!(same.iter().zip(&ramp).all(|(a, b)| (a - b).abs() < 1e-15));
        let (early, _) = delayed_input(&times, &ramp, -1.0);
        assert!(early.iter().all(|u| (u - 1.0).abs() < 1e-12));
    }
}
