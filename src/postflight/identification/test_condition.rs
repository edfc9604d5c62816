//! Test conditions: airspeed and flight-path angle of each run's trim, and the grouping of runs into test points.
//!
//! Consumes runs; produces the condition of each run's trim, and groups of runs of one test point, the steepest descent first.
//! With u v w from airspeed and flow angles, the flight-path angle is that between velocity and horizon,
//!     sin(gamma) = (u sin(theta) - v sin(phi) cos(theta) - w cos(phi) cos(theta))/V                    (1)
//! and where incidence or pitch was not recorded the climb rate of the altitude in the trim window over the airspeed.
//! Two runs are of one test point where their airspeeds differ by less than [`SPEED_PART`] and their paths by less than
//! [`PATH_RAD`], or where a chain of such pairs links them (single linkage): the order of the runs does not matter. A quantity
//! that a run did not record does not separate it from another.

use super::columns::Columns;
use crate::dynamics::sensors::flow_direction;

/// Largest difference of airspeeds of one test point, relative to the larger.
pub const SPEED_PART: f64 = 0.06;
/// Largest difference of path angles of one test point, rad: two degrees.
pub const PATH_RAD: f64 = 0.035;

/// Flight condition of a trim.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TestCondition {
    /// True airspeed, m/s; NaN where not recorded.
    pub speed: f64,
    /// Flight-path angle, rad, up positive; NaN where it cannot be known.
    pub path: f64,
    /// Altitude, m; NaN where not recorded.
    pub altitude: f64,
    /// Air density, kg/m^3; NaN where not recorded.
    pub density: f64,
}

impl TestCondition {
    /// Condition of a run's trim; NaN of what it did not record.
    pub fn of(run: &Columns) -> Self {
        TestCondition::of_trim(|name| run.trim(name).ok(), || run.trim_slope("altitude"))
    }

    /// Condition from the means of channels in the trim window, and the rate of altitude there, m/s.
    pub fn of_trim(mean: impl Fn(&str) -> Option<f64>, altitude_rate: impl Fn() -> f64) -> Self {
        let trim = |name: &str| mean(name).unwrap_or(f64::NAN);
        let speed = trim("tas");
        let (alpha, beta, theta, phi) = (trim("alpha"), mean("beta").unwrap_or(0.0), trim("theta"), mean("phi").unwrap_or(0.0));
        let [u, v, w] = flow_direction(alpha, beta);
        let ((sin_theta, cos_theta), (sin_phi, cos_phi)) = (libm::sincos(theta), libm::sincos(phi));
        let by_attitude = u * sin_theta - v * sin_phi * cos_theta - w * cos_phi * cos_theta;
        let sine = if by_attitude.is_finite() { by_attitude } else { altitude_rate() / speed };
        TestCondition { speed, path: libm::asin(sine), altitude: trim("altitude"), density: trim("rho") }
    }

    /// Whether two runs are of one test point.
    pub fn is_near(&self, other: &TestCondition) -> bool {
        let far = libm::fabs(self.speed - other.speed) > SPEED_PART * self.speed.max(other.speed);
        !far && !(libm::fabs(self.path - other.path) > PATH_RAD)
    }

    /// Mean of each quantity over the conditions that have it.
    pub fn mean(conditions: &[TestCondition]) -> Self {
        let of = |value: fn(&TestCondition) -> f64| {
            let known = conditions.iter().map(value).filter(|value| value.is_finite());
            let (sum, count) = known.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
            sum / count
        };
        TestCondition { speed: of(|c| c.speed), path: of(|c| c.path), altitude: of(|c| c.altitude), density: of(|c| c.density) }
    }

    /// Climb rate, m/s; level where the path is not known.
    pub fn climb(&self) -> f64 {
        if self.path.is_finite() { self.speed * libm::sin(self.path) } else { 0.0 }
    }
}

/// Indices of the runs by test point, in order of path angle, then airspeed.
pub fn test_points(conditions: &[TestCondition]) -> Vec<Vec<usize>> {
    let mut points: Vec<Vec<usize>> = Vec::new();
    for (place, condition) in conditions.iter().enumerate() {
        let near = |point: &Vec<usize>| point.iter().any(|&other| conditions.get(other).is_some_and(|c| c.is_near(condition)));
        let (with, other_points): (Vec<_>, Vec<_>) = points.into_iter().partition(near);
        let mut joined: Vec<usize> = with.into_iter().flatten().collect();
        joined.push(place);
        joined.sort_unstable();
        points = other_points;
        points.push(joined);
    }
    let mean = |point: &[usize]| -> TestCondition {
        TestCondition::mean(&point.iter().filter_map(|&place| conditions.get(place).copied()).collect::<Vec<_>>())
    };
    points.sort_by(|one, other| {
        let (one, other) = (mean(one), mean(other));
        one.path.total_cmp(&other.path).then(one.speed.total_cmp(&other.speed))
    });
    points
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flight::run::RunGeometry;

    fn at(speed: f64, path: f64) -> TestCondition {
        TestCondition { speed, path, altitude: f64::NAN, density: f64::NAN }
    }

    #[test]
    fn descent_level_and_climb_are_three_points_in_any_order() {
        let runs = [at(51.0, 0.10), at(51.9, -0.098), at(51.4, 0.001), at(50.8, -0.101), at(51.5, 0.097), at(51.0, f64::NAN)];
        // The run of unknown path is near to all: it joins them.
        assert_eq!(test_points(&runs[..5]), [vec![1, 3], vec![2], vec![0, 4]]);
        assert_eq!(test_points(&runs), [vec![0, 1, 2, 3, 4, 5]]);
        // A chain is one point, other speeds are others.
        assert_eq!(test_points(&[at(50.0, 0.0), at(54.0, 0.0), at(52.0, 0.0), at(70.0, 0.0)]), [vec![0, 1, 2], vec![3]]);
    }

    #[test]
    fn the_path_is_that_of_the_velocity() {
        let columns = |names: &[(&str, [f64; 3])]| {
            let columns = names.iter().map(|(name, values)| ((*name).to_owned(), values.to_vec())).collect();
            Columns::new("a".to_owned(), RunGeometry::DEFAULT, vec![0.0, 0.5, 1.0], columns, 2.0).unwrap()
        };
        let banked = columns(&[("tas", [50.0; 3]), ("alpha", [0.03; 3]), ("theta", [0.13; 3]), ("phi", [0.0; 3])]);
        assert!((TestCondition::of(&banked).path - 0.10).abs() < 1e-12);
        let climbing = columns(&[("tas", [50.0; 3]), ("altitude", [100.0, 102.5, 105.0])]);
        assert!((TestCondition::of(&climbing).climb() - 5.0).abs() < 1e-9);
        assert!(TestCondition::of(&columns(&[("tas", [50.0; 3])])).path.is_nan());
    }
}
