//! The whole aircraft: loads of all components summed and divided by mass and inertia.
//!
//! Consumes velocity through the air (m/s, body axes), angular rates, blade pitch, rotor speed, density and the rotor's states;
//! produces specific force (m/s^2) and angular acceleration (rad/s^2). With the sums X Y Z L M N of the components,
//!     a = (X, Y, Z)/m                                                                                  (1)
//!     L^ = L + (I_yy - I_zz) q r + I_xz p q     N^ = N + (I_xx - I_yy) p q - I_xz q r     D = I_xx I_zz - I_xz^2
//!     dp/dt = (I_zz L^ + I_xz N^)/D     dr/dt = (I_xx N^ + I_xz L^)/D                                  (2)
//!     dq/dt = [M + (I_zz - I_xx) p r + I_xz (r^2 - p^2)]/I_yy                                          (3)
//! Where rotor speed is a state, the torque on the fuselage is that of the rotor shaft instead of the aerodynamic torque Q_m. Of
//! the engine torque Q_e the tail rotor, geared by g, takes g Q_t; the difference to the aerodynamic torque accelerates the
//! rotor:
//!     N_h = Q_e - g Q_t = Q_m + (Q_e - Q_R)     Q_R = Q_m + g Q_t                                       (4)
//! With `engine` (1) the angular momentum of fuselage and rotor, I_zz r - sigma I (Omega - sigma r), then changes by aerodynamic
//! moments only. The equations of motion are in `motion`, for both kinds of model.

use super::actuator::Actuator;
use super::engine::Engine;
use super::fin::Fin;
use super::flapping::Flap;
use super::fuselage::Fuselage;
use super::hub::{Hub, HubPosition};
use super::inflow::{InflowGuess, uniform};
use super::internal_states::Options;
use super::rotor::{MainRotor, ReadyRotor, RotorPoint, RotorStates};
use super::tail_rotor::{ReadyTail, TailRotor};
use super::tailplane::Tailplane;
use crate::flight::control::{CONTROLS, Control};
use crate::flight::derivative::AXES;

/// Mass, inertia and centre of mass, SI.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MassProperties {
    /// Mass, kg.
    pub mass: f64,
    /// Moment of inertia about x, kg m^2.
    pub ixx: f64,
    /// About y.
    pub iyy: f64,
    /// About z.
    pub izz: f64,
    /// Product of inertia.
    pub ixz: f64,
    /// Centre of mass ahead of the main hub's foot point, m.
    pub cg_forward: f64,
}

/// Half widths of the differences of a linearisation with finite perturbations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Perturbation {
    /// Velocities, m/s.
    pub velocity: f64,
    /// Rates, rad/s.
    pub rate: f64,
    /// Controls, rad.
    pub control: f64,
}

/// A Level-1 aircraft.
#[derive(Clone, Debug, PartialEq)]
#[expect(missing_docs, reason = "fields are what their names say")]
pub struct Level1 {
    /// Mass and inertia.
    pub body: MassProperties,
    /// Which geometry the hub has.
    pub hub: Hub,
    pub main_rotor: MainRotor,
    pub tail_rotor: TailRotor,
    pub fin: Fin,
    pub tailplane: Tailplane,
    pub fuselage: Fuselage,
    /// Engine and governor.
    pub engine: Engine,
    /// Actuators by control place.
    pub actuators: [Actuator; CONTROLS],
    /// Finite perturbations.
    pub perturbation: Perturbation,
    /// What is a state, and how it is linearised.
    pub options: Options,
}

/// What the aircraft meets at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Situation {
    /// Velocity u, v, w through the air, m/s.
    pub velocity: [f64; 3],
    /// Rates p, q, r, rad/s.
    pub rates: [f64; 3],
    /// Blade pitch by control place, rad.
    pub blade: [f64; CONTROLS],
    /// Speed of the main rotor, rad/s.
    pub rotor_speed: f64,
    /// Air density, kg/m^3.
    pub density: f64,
}

/// What the aircraft does about it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AircraftResponse {
    /// Specific force (m/s^2) and angular acceleration (rad/s^2) by axis.
    pub accelerations: [f64; AXES],
    /// Torque that both rotors take, at the main rotor, N m.
    pub torque: f64,
    /// Thrust of the main rotor along its shaft, N.
    pub thrust: f64,
    /// Flap in the rotor's own (anticlockwise) hub axes, rad.
    pub flap: Flap,
    /// lambda0.
    pub inflow: f64,
    pub(crate) rotor: RotorPoint,
    pub(crate) inflows: InflowGuess,
}

/// An aircraft with constants derived from its data, computed once for a flight.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Equations<'a> {
    aircraft: &'a Level1,
    pub(crate) place: HubPosition,
    rotor: ReadyRotor,
    tail: ReadyTail,
    /// Arms of fin and tailplane behind the centre of mass, m.
    fin_arm: f64,
    plane_arm: f64,
    /// 1/m, 1/I_yy.
    per_mass: f64,
    per_iyy: f64,
    /// I_xx, I_xz and I_zz over D.
    inverse: [f64; 3],
}

impl Level1 {
    pub(crate) fn place(&self) -> HubPosition {
        let (sin, cos) = libm::sincos(self.main_rotor.shaft_tilt);
        HubPosition {
            geometry: self.hub,
            sigma: self.main_rotor.direction,
            height: self.main_rotor.height,
            cg_forward: self.body.cg_forward,
            tilt: (cos, sin),
        }
    }

    /// Everything that is not the motion at once: the plain model, whatever the options.
    pub fn respond(&self, situation: &Situation) -> AircraftResponse {
        self.equations().sum(situation, RotorStates::default(), None, InflowGuess::NONE)
    }

    pub(crate) fn equations(&self) -> Equations<'_> {
        let body = &self.body;
        let d = body.ixx * body.izz - body.ixz * body.ixz;
        Equations {
            aircraft: self,
            place: self.place(),
            rotor: self.main_rotor.ready(),
            tail: self.tail_rotor.ready(self.tail_rotor.aft + body.cg_forward),
            fin_arm: self.fin.aft + body.cg_forward,
            plane_arm: self.tailplane.aft + body.cg_forward,
            per_mass: 1.0 / body.mass,
            per_iyy: 1.0 / body.iyy,
            inverse: [body.ixx / d, body.ixz / d, body.izz / d],
        }
    }

    /// c of [`crate::flight::effect::Effect::RotorReaction`] where rotor speed is a state: (2) of the shaft's torque by (4), the
    /// shaft tilted as the hub's (4) has it.
    pub fn reaction(&self) -> f64 {
        let (MassProperties { ixx, izz, ixz, .. }, (sin, cos)) = (self.body, libm::sincos(self.main_rotor.shaft_tilt));
        let yaw = (ixx * cos - ixz * sin) / (ixx * izz - ixz * ixz);
        if self.options.governed { self.main_rotor.direction * self.engine.inertia * yaw } else { 0.0 }
    }
}

impl Equations<'_> {
    /// (1) to (3), with the torque that the engine delivers (4); inflow iterations start from `guess`.
    // Inlined so that a call without guesses leaves their refinement out: a sixth of the instructions.
    #[inline(always)]
    pub(crate) fn sum(
        &self,
        met: &Situation,
        states: RotorStates,
        delivered: Option<f64>,
        guess: InflowGuess,
    ) -> AircraftResponse {
        let Situation { velocity, rates, blade, rotor_speed, density } = *met;
        let [p, q, r] = rates;
        let Equations { aircraft: Level1 { body, tail_rotor, fin, tailplane, fuselage, .. }, place, .. } = self;
        let pitch = [blade[Control::Collective.index()], blade[Control::LonCyclic.index()], blade[Control::LatCyclic.index()]];
        let (hub, pedal) = (place.motion(velocity, rates), blade[Control::Pedal.index()]);
        let flow = self.rotor.flow(&hub, pitch, (rotor_speed, density), states);
        let tail_flow = |induced: f64| self.tail.flow(velocity, rates, pedal, (rotor_speed, density, induced));
        let (inflow, tail_flow, tail_inflow) = if states.inflow.is_none() && !self.tail.in_downwash() {
            let tail_flow = tail_flow(0.0);
            let [main, tail] = uniform([self.rotor.balance(&flow), tail_flow.balance], [guess.main, guess.tail]);
            (main, tail_flow, tail)
        } else {
            let inflow = states.inflow.unwrap_or_else(|| self.rotor.balance(&flow).uniform(guess.main));
            let tail_flow = tail_flow(self.rotor.induced(&flow, inflow));
            (inflow, tail_flow, tail_flow.balance.uniform(guess.tail))
        };
        let (rotor, tail) = (self.rotor.loads(&flow, inflow), self.tail.loads(&tail_flow, tail_inflow));
        let torque = rotor.torque + tail_rotor.gearing * tail.torque;
        let mut at_hub = rotor.loads;
        if let Some(delivered) = delivered {
            at_hub.moment[2] += delivered - torque;
        }
        let ([mut x, mut y, mut z], [mut l, mut m, mut n]) = place.at_centre_of_mass(at_hub);

        y += tail.side_force;
        l += tail_rotor.height * tail.side_force;
        n -= self.tail.arm * tail.side_force;

        let side = fin.side_force(velocity, rates, density, self.fin_arm);
        y += side;
        l += fin.height * side;
        n -= self.fin_arm * side;

        let plane = tailplane.normal_force(velocity, q, (density, rotor.induced), self.plane_arm);
        z += plane;
        m += self.plane_arm * plane;

        let (force, moment) = fuselage.loads(velocity, (density, rotor.induced));
        x += force[0];
        y += force[1];
        z += force[2];
        l += moment[0];
        m += moment[1];
        n += moment[2];

        l += (body.iyy - body.izz) * q * r + body.ixz * p * q;
        n += (body.ixx - body.iyy) * p * q - body.ixz * q * r;
        m += (body.izz - body.ixx) * p * r + body.ixz * (r * r - p * p);
        let (per_mass, [ixx, ixz, izz]) = (self.per_mass, self.inverse);
        AircraftResponse {
            accelerations: [x * per_mass, y * per_mass, z * per_mass, izz * l + ixz * n, m * self.per_iyy, ixx * n + ixz * l],
            torque,
            thrust: -rotor.loads.force[2],
            flap: rotor.flap,
            inflow: rotor.inflow,
            inflows: InflowGuess { main: rotor.inflow, tail: tail.inflow },
            rotor,
        }
    }
}
