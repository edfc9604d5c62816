//! On any grid of times the smoothing kernel gives back straight lines and their slopes.

use proptest::prelude::*;
use sideslip::num::kernel::weights;

proptest! {
    #![proptest_config(super::cases(256))]

    #[test]
    fn its_weights_have_the_moments_of_a_smoother_and_of_a_slope(
        intervals in prop::collection::vec(prop_oneof![4 => 1e-3..0.05_f64, 1 => 1e-6..0.2_f64], 2..120),
        within in 0.0..1.0_f64,
        width in 0.05..1.0_f64,
        origin in -100.0..100.0_f64,
    ) {
        let mut times = vec![origin];
        for interval in &intervals {
            times.push(times[times.len() - 1] + interval);
        }
        let length = times[times.len() - 1] - origin;
        let half_width = 0.5 * width * length;
        let centre = origin + half_width + within * (length - 2.0 * half_width);
        let (mut smooth, mut slope) = (vec![f64::NAN; times.len()], vec![f64::NAN; times.len()]);
        let covered = times[0] <= centre - half_width && times[times.len() - 1] >= centre + half_width;
        let answered = weights(&times, centre, half_width, 1.0, &mut smooth, &mut slope);
        prop_assert_eq!(answered, covered);
        if !answered {
            return Ok(());
        }
        let sum = |weights: &[f64], power: i32| -> f64 {
            weights.iter().zip(&times).map(|(weight, time)| weight * ((time - centre) / half_width).powi(power)).sum()
        };
        // Times of about 100 s are known to 1e-14 s; beside intervals of 1e-6 s that is 1e-8 of a slope's weight.
        let largest = slope.iter().fold(0.0, |largest: f64, weight| largest.max(weight.abs()));
        prop_assert!((sum(&smooth, 0) - 1.0).abs() < 1e-9, "sum of weights {}", sum(&smooth, 0));
        prop_assert!(sum(&smooth, 1).abs() < 1e-9, "first moment {}", sum(&smooth, 1));
        prop_assert!(sum(&slope, 0).abs() < 1e-12 * largest * times.len() as f64);
        prop_assert!((sum(&slope, 1) * half_width - 1.0).abs() < 1e-9, "slope of a line {}", sum(&slope, 1) * half_width);
        prop_assert!(smooth.iter().all(|&weight| weight > -1e-9), "a smoother's weights are not negative");
        // Nothing outside the support counts, but for the ends of the two intervals that it cuts.
        let outside = |time: f64| (time - centre).abs() > half_width;
        for i in 1..times.len() - 1 {
            let one_side = (times[i - 1] > centre) == (times[i + 1] > centre);
            if outside(times[i - 1]) && outside(times[i]) && outside(times[i + 1]) && one_side {
                prop_assert_eq!((smooth[i], slope[i]), (0.0, 0.0));
            }
        }
    }
}
