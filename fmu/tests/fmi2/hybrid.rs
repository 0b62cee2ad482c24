//! More components for the tests: a bouncing ball and a limited integrator (state events), a
//! pendulum with its tangent-linear model.

use fmu_kit::{Component, Fault, Info, ParameterError, Resources, Time, Variables};
use serde::{Deserialize, Serialize};

/// Acceleration of gravity (m/s2).
pub const GRAVITY: f64 = 9.81;
/// Share of the speed after a bounce.
pub const RESTITUTION: f64 = 0.8;

#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct Fall {
    /// Height above ground
    #[var(unit = "m")]
    pub height: f64,
    /// Upward speed
    #[var(unit = "m/s")]
    pub speed: f64,
}

#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct BallStates {
    /// State
    pub state: Fall,
}

#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct BallOutputs {
    /// Height above ground
    #[var(unit = "m")]
    pub height: f64,
    /// Bounces so far
    pub bounces: f64,
}

#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Contact {
    bounces: u32,
    resting: bool,
}

pub struct Ball;

impl Component for Ball {
    const INFO: Info = Info::new("Ball", "Bounces until it rests");
    const INDICATORS: &'static [&'static str] = &["height"];
    type Parameters = ();
    type Inputs = ();
    type Outputs = BallOutputs;
    type States = BallStates;
    type Memory = Contact;

    fn new((): &(), _: &Resources) -> Result<Self, ParameterError> {
        Ok(Self)
    }

    fn initial(&self, _: Time, (): &()) -> Result<(BallStates, Contact), Fault> {
        Ok((BallStates { state: Fall { height: 1.0, speed: 0.0 } }, Contact::default()))
    }

    fn derivatives(&self, _: f64, m: &Contact, x: &BallStates, (): &()) -> BallStates {
        let falls = if m.resting { 0.0 } else { 1.0 };
        BallStates { state: Fall { height: falls * x.state.speed, speed: -falls * GRAVITY } }
    }

    fn outputs(&self, _: f64, m: &Contact, x: &BallStates, (): &()) -> BallOutputs {
        BallOutputs { height: x.state.height, bounces: f64::from(m.bounces) }
    }

    fn indicators(&self, _: f64, m: &Contact, x: &BallStates, (): &(), z: &mut [f64]) {
        z[0] = if m.resting { 1.0 } else { x.state.height };
    }

    fn state_event(
        &self,
        _: f64,
        m: &mut Contact,
        x: &mut BallStates,
        (): &(),
    ) -> Result<bool, Fault> {
        if m.resting || x.state.height > 0.0 || x.state.speed >= 0.0 {
            return Ok(false);
        }
        m.bounces += 1;
        x.state = Fall { height: 0.0, speed: -RESTITUTION * x.state.speed };
        m.resting = x.state.speed < 0.05;
        if m.resting {
            x.state.speed = 0.0;
        }
        Ok(true)
    }
}

#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct Level {
    /// Integral of the cosine of time, kept within the limit
    pub level: f64,
}

#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct LevelStates {
    /// State
    pub state: Level,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum Mode {
    #[default]
    Free,
    High,
    Low,
}

/// Where the integrator stops.
pub const LIMIT: f64 = 0.5;

/// Integrates cos(t) within limits; does not wind up.
pub struct Limiter;

impl Component for Limiter {
    const INFO: Info = Info::new("Limiter", "Integrates the cosine of time within limits");
    const INDICATORS: &'static [&'static str] = &["upper", "lower"];
    type Parameters = ();
    type Inputs = ();
    type Outputs = Level;
    type States = LevelStates;
    type Memory = Mode;

    fn new((): &(), _: &Resources) -> Result<Self, ParameterError> {
        Ok(Self)
    }

    fn initial(&self, _: Time, (): &()) -> Result<(LevelStates, Mode), Fault> {
        Ok((LevelStates::default(), Mode::Free))
    }

    fn derivatives(&self, t: f64, m: &Mode, _: &LevelStates, (): &()) -> LevelStates {
        let level = if *m == Mode::Free { t.cos() } else { 0.0 };
        LevelStates { state: Level { level } }
    }

    fn outputs(&self, _: f64, _: &Mode, x: &LevelStates, (): &()) -> Level {
        x.state
    }

    fn indicators(&self, t: f64, m: &Mode, x: &LevelStates, (): &(), z: &mut [f64]) {
        let level = x.state.level;
        z.copy_from_slice(&match m {
            Mode::Free => [LIMIT - level, level + LIMIT],
            Mode::High => [t.cos(), 1.0],
            Mode::Low => [1.0, -t.cos()],
        });
    }

    fn state_event(
        &self,
        t: f64,
        m: &mut Mode,
        x: &mut LevelStates,
        (): &(),
    ) -> Result<bool, Fault> {
        let (rate, level) = (t.cos(), x.state.level);
        let next = match *m {
            Mode::Free if level >= LIMIT && rate > 0.0 => Mode::High,
            Mode::Free if level <= -LIMIT && rate < 0.0 => Mode::Low,
            Mode::High if rate < 0.0 => Mode::Free,
            Mode::Low if rate > 0.0 => Mode::Free,
            same => same,
        };
        x.state.level = level.clamp(-LIMIT, LIMIT);
        let changed = next != *m;
        *m = next;
        Ok(changed)
    }
}

/// Switches back and forth at the same place: a component must not do this.
pub struct Chatterer;

impl Component for Chatterer {
    const INFO: Info = Info::new("Chatterer", "Pushed back and forth about zero");
    const INDICATORS: &'static [&'static str] = &["side"];
    type Parameters = ();
    type Inputs = ();
    type Outputs = Level;
    type States = LevelStates;
    type Memory = bool;

    fn new((): &(), _: &Resources) -> Result<Self, ParameterError> {
        Ok(Self)
    }

    fn initial(&self, _: Time, (): &()) -> Result<(LevelStates, bool), Fault> {
        Ok((LevelStates { state: Level { level: 0.1 } }, false))
    }

    fn derivatives(&self, _: f64, m: &bool, _: &LevelStates, (): &()) -> LevelStates {
        LevelStates { state: Level { level: if *m { 1.0 } else { -1.0 } } }
    }

    fn outputs(&self, _: f64, _: &bool, x: &LevelStates, (): &()) -> Level {
        x.state
    }

    fn indicators(&self, _: f64, _: &bool, x: &LevelStates, (): &(), z: &mut [f64]) {
        z[0] = x.state.level;
    }

    fn state_event(
        &self,
        _: f64,
        m: &mut bool,
        x: &mut LevelStates,
        (): &(),
    ) -> Result<bool, Fault> {
        let below = x.state.level <= 0.0;
        let changed = *m != below;
        *m = below;
        Ok(changed)
    }
}

#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct Swing {
    /// Angle from the vertical
    #[var(unit = "rad")]
    pub angle: f64,
    /// Angular rate
    #[var(unit = "rad/s", nominal = 3.0)]
    pub rate: f64,
}

#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct PendulumStates {
    /// State
    pub state: Swing,
}

#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct Torque {
    /// Torque at the hinge
    pub torque: f64,
}

#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct Bob {
    /// Horizontal place of the bob
    pub x: f64,
    /// Power of the torque
    pub power: f64,
}

#[derive(Clone, Debug, Variables)]
pub struct Hinge {
    /// Angle at the start
    #[var(unit = "rad")]
    pub start: f64,
    /// Quadratic damping
    pub damping: f64,
    /// Whether there is any damping
    pub damped: bool,
}

impl Default for Hinge {
    fn default() -> Self {
        Self { start: 1.0, damping: 0.2, damped: true }
    }
}

/// Starts at its angle and, unlike any pendulum, with the torque as its rate.
pub struct Pendulum(Hinge);

impl Component for Pendulum {
    const INFO: Info =
        Info { integrator_step_s: 0.02, ..Info::new("Pendulum", "A pendulum with a motor") };
    const TANGENT: bool = true;
    type Parameters = Hinge;
    type Inputs = Torque;
    type Outputs = Bob;
    type States = PendulumStates;
    type Memory = ();

    fn new(p: &Hinge, _: &Resources) -> Result<Self, ParameterError> {
        let damping = if p.damped { p.damping } else { 0.0 };
        Ok(Self(Hinge { damping, ..p.clone() }))
    }

    fn initial(&self, _: Time, u: &Torque) -> Result<(PendulumStates, ()), Fault> {
        Ok((PendulumStates { state: Swing { angle: self.0.start, rate: u.torque } }, ()))
    }

    fn derivatives(&self, _: f64, (): &(), x: &PendulumStates, u: &Torque) -> PendulumStates {
        let Swing { angle, rate } = x.state;
        let acceleration = u.torque - 9.0 * angle.sin() - self.0.damping * rate * rate.abs();
        PendulumStates { state: Swing { angle: rate, rate: acceleration } }
    }

    fn outputs(&self, _: f64, (): &(), x: &PendulumStates, u: &Torque) -> Bob {
        Bob { x: x.state.angle.sin(), power: x.state.rate * u.torque }
    }

    fn tangent(
        &self,
        _: f64,
        (): &(),
        x: &PendulumStates,
        u: &Torque,
        dx: &PendulumStates,
        du: &Torque,
    ) -> (PendulumStates, Bob) {
        let (Swing { angle, rate }, d) = (x.state, dx.state);
        let drag = 2.0 * self.0.damping * rate.abs() * d.rate;
        let acceleration = du.torque - 9.0 * angle.cos() * d.angle - drag;
        let states = PendulumStates { state: Swing { angle: d.rate, rate: acceleration } };
        let power = d.rate * u.torque + rate * du.torque;
        (states, Bob { x: angle.cos() * d.angle, power })
    }

    fn initial_tangent(
        &self,
        x: &PendulumStates,
        _: &Torque,
        p: &Hinge,
        dp: &Hinge,
        du: &Torque,
    ) -> (PendulumStates, PendulumStates, Bob) {
        let d_damping = if p.damped { dp.damping } else { 0.0 };
        let rate = x.state.rate;
        let starts = Swing { angle: dp.start, rate: du.torque };
        let slows = Swing { angle: 0.0, rate: -d_damping * rate * rate.abs() };
        (PendulumStates { state: starts }, PendulumStates { state: slows }, Bob::default())
    }
}

#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct Rate {
    /// Rate demanded, kept within 1
    pub rate: f64,
}

/// Integrates a rate that is kept within limits: kinks of an input, and no mode.
pub struct Clipper;

impl Component for Clipper {
    const INFO: Info = Info { integrator_step_s: 0.1, ..Info::new("Clipper", "Clips a rate") };
    const INDICATORS: &'static [&'static str] = &["upper", "lower"];
    const KINKS_OF_INPUTS: bool = true;
    type Parameters = ();
    type Inputs = Rate;
    type Outputs = Level;
    type States = LevelStates;
    type Memory = ();

    fn new((): &(), _: &Resources) -> Result<Self, ParameterError> {
        Ok(Self)
    }

    fn initial(&self, _: Time, _: &Rate) -> Result<(LevelStates, ()), Fault> {
        Ok((LevelStates::default(), ()))
    }

    fn derivatives(&self, _: f64, (): &(), _: &LevelStates, u: &Rate) -> LevelStates {
        LevelStates { state: Level { level: u.rate.clamp(-1.0, 1.0) } }
    }

    fn outputs(&self, _: f64, (): &(), x: &LevelStates, _: &Rate) -> Level {
        x.state
    }

    fn indicators(&self, _: f64, (): &(), _: &LevelStates, u: &Rate, z: &mut [f64]) {
        z.copy_from_slice(&[1.0 - u.rate, 1.0 + u.rate]);
    }
}
