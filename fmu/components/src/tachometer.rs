//! Rotor speed sensors: `rexrov::sensors::Tachometer` with FMI variables.

use crate::groups::Thrust;
use crate::instrument::{Instrument, Stamp, Switch};
use crate::sensing::Sensor;
use crate::vehicle_ports::Rotor;
use fmu_kit::{Info, Variables};
use rexrov::ParameterError;
use rexrov::sampling::Rate;
use rexrov::sensors::{self, TachometerMemory, TachometerParameters};
use serde::{Deserialize, Serialize};

/// Parameters of the tachometers.
#[derive(Clone, Debug, Variables)]
pub struct Parameters {
    /// What all sensors have.
    #[var(flatten)]
    pub instrument: Instrument,
    /// Standard deviation
    #[var(unit = "rad/s", min = 0.0)]
    pub sigma: f64,
    /// Thrust over rotor speed squared
    #[var(unit = "N.s2/rad2", min = 1e-12, nominal = 1e-3)]
    pub thrust_gain: f64,
}

impl Default for Parameters {
    fn default() -> Self {
        let p = TachometerParameters::default();
        Self {
            instrument: Instrument::new(p.rate_hz, p.seed),
            sigma: p.sigma,
            thrust_gain: p.thrust_gain,
        }
    }
}

/// True motion.
#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct Vehicle {
    /// Rotor
    pub rotor: [Rotor; 8],
}

/// Inputs.
#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct Inputs {
    /// True motion
    pub vehicle: Vehicle,
    /// Switch.
    #[var(flatten)]
    pub switch: Switch,
}

/// Outputs.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, Variables)]
pub struct Outputs {
    /// Rotor
    pub rotor: [Rotor; 8],
    /// Thruster, if its propeller is sound
    pub thruster: [Thrust; 8],
    /// Newest sample.
    #[var(flatten)]
    pub stamp: Stamp,
}

/// The tachometers of all thrusters.
pub struct Tachometer(sensors::Tachometer);

impl Sensor for Tachometer {
    const INFO: Info =
        crate::info("Tachometer", "Rotor speeds of the thrusters and the thrusts they stand for");
    type Parameters = Parameters;
    type Inputs = Inputs;
    type Outputs = Outputs;
    type Memory = TachometerMemory;

    fn new(p: &Parameters) -> Result<Self, ParameterError> {
        let parameters = TachometerParameters {
            rate_hz: p.instrument.rate_hz,
            seed: p.instrument.seed(),
            sigma: p.sigma,
            thrust_gain: p.thrust_gain,
        };
        sensors::Tachometer::new(&parameters).map(Self)
    }

    fn instrument(p: &Parameters) -> &Instrument {
        &p.instrument
    }

    fn rate(&self) -> Rate {
        self.0.rate
    }

    fn memory(&self) -> TachometerMemory {
        self.0.memory()
    }

    fn sample(&self, stamp: Stamp, memory: &mut TachometerMemory, u: &Inputs) -> Option<Outputs> {
        let sample = self.0.sample(memory, &u.vehicle.rotor.map(|rotor| rotor.speed));
        u.switch.is_on().then(|| Outputs {
            rotor: sample.speed.map(|speed| Rotor { speed }),
            thruster: sample.thrust.map(|thrust| Thrust { thrust }),
            stamp,
        })
    }
}
