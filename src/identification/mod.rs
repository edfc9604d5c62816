//! Identification after the flight: which linear model several runs are flights of, by output error over all of them.
//!
//! In: runs as they were recorded, and which of their channels are states, inputs and outputs. Out: derivatives with standard
//! errors (Cramer-Rao, and corrected for the colour of the residuals), the modes of the identified model with theirs, and how
//! well it predicts runs that were not used.
//! Assumed: small deviations from each run's own trim; a control moves in a straight line from sample to sample; rows of the
//! attitudes are kinematics, and what gravity and the flight speed do to the velocities is known.
//! Refused: a state or input that was not recorded, an equation without what it needs, runs that are no flights of one trim.

pub mod columns;
pub mod datum;
pub mod disturbed;
pub mod doubts;
pub mod effective_damping;
pub mod follower;
pub mod held;
pub mod identify;
pub mod kinematics;
mod lateness;
pub mod linear;
pub mod live;
mod live_fit;
pub mod manoeuvres;
pub mod prediction;
pub mod record;
pub mod responses;
pub mod roots;
pub mod start;
pub mod steady_sideslip;
mod suspected;
pub mod test_point;
pub mod velocity;
pub mod vibration;
