//! The cells of the campaign: the kinds of missions.

use std::f64::consts::FRAC_1_SQRT_2;

use anyhow::Context;
use rexrov::vehicle::Parameters;

use super::filter::Filter;
use super::system::Steering;

/// Grades of inertial units, as the FMUs name them.
pub(crate) const GRADES: [&str; 3] = ["Adis16448", "Industrial", "Tactical"];
/// The thruster that fails: a horizontal one.
pub(crate) const LOST: usize = 4;
/// Fix and velocity log are off between these instants in the cells named after outages (s).
pub(crate) const OUTAGE: [f64; 2] = [200.0, 260.0];

/// Kinds of damping.
const BOTH: [&str; 2] = ["linear", "quadratic"];

/// The name of a cell of a grade; that of the cheapest is the plain one.
pub(crate) fn of_grade(name: &str, grade: &str) -> String {
    if grade == GRADES[0] { name.to_owned() } else { format!("{name}-{}", grade.to_lowercase()) }
}

/// An input gets a value, or its connection again.
#[derive(Clone, Debug)]
pub(crate) struct Event {
    pub(crate) time: f64,
    pub(crate) input: String,
    pub(crate) value: Option<f64>,
}

/// One kind of mission.
#[derive(Clone, Debug)]
pub(crate) struct Cell {
    pub(crate) name: String,
    pub(crate) course: &'static str,
    pub(crate) grade: &'static str,
    pub(crate) steering: Steering,
    pub(crate) filters: &'static [Filter],
    /// Start values besides those of every cell, `component.variable` and text. `*` stands for each
    /// navigation filter.
    pub(crate) start_values: Vec<(String, String)>,
    pub(crate) events: Vec<Event>,
    /// The measured part besides the whole mission (s); the mission ends with it.
    pub(crate) window: Option<[f64; 2]>,
    /// When the propeller [`LOST`] is lost, without a change of the rotor (s).
    pub(crate) propeller_lost: Option<f64>,
    /// Whether a third of the seeds is enough.
    pub(crate) secondary: bool,
    /// Whether the recorded inputs of the filters are smoothed as well.
    pub(crate) smoothed: bool,
}

impl Cell {
    fn new(name: impl Into<String>, course: &'static str) -> Self {
        Self {
            name: name.into(),
            course,
            grade: GRADES[0],
            steering: Steering::Truth,
            filters: &Filter::BEST,
            start_values: vec![("*.heading_bias_sigma".into(), "0".into())],
            events: Vec::new(),
            window: None,
            propeller_lost: None,
            secondary: false,
            smoothed: false,
        }
    }

    /// The cell's seeds in a campaign with this many.
    pub(crate) fn seeds(&self, most: u32) -> u32 {
        if self.secondary { most.min((most * 3).div_ceil(10).max(6)) } else { most }
    }

    /// The cell of this name.
    pub(crate) fn named(name: &str) -> anyhow::Result<Self> {
        let found = Self::all().into_iter().find(|cell| cell.name == name);
        found.with_context(|| format!("there is no cell {name}"))
    }

    /// The same for other filters, under another name.
    pub(crate) fn variant(self, name: impl Into<String>, filters: &'static [Filter]) -> Self {
        let name = name.into();
        Self { name, filters, secondary: false, ..self }
    }

    /// With a start value.
    pub(crate) fn set(mut self, name: impl Into<String>, value: impl ToString) -> Self {
        self.start_values.push((name.into(), value.to_string()));
        self
    }

    fn at(mut self, time: f64, input: impl Into<String>, value: Option<f64>) -> Self {
        self.events.push(Event { time, input: input.into(), value });
        self
    }

    fn off(self, sensors: &[&str], [from, to]: [f64; 2]) -> Self {
        sensors.iter().fold(Self { window: Some([from, to]), ..self }, |cell, sensor| {
            let switch = format!("{sensor}.off");
            cell.at(from, &switch, Some(1.0)).at(to, switch, None)
        })
    }

    fn outage(name: &str, grade: &'static str) -> Self {
        let cell = Self::new(of_grade(name, grade), "BE3").off(&["fix", "dvl"], OUTAGE);
        Self { grade, secondary: grade != GRADES[0], ..cell }
    }

    /// 0.2 m/s, obliquely to every leg.
    fn current(self) -> Self {
        let axis = 0.2 * FRAC_1_SQRT_2;
        self.set("disturbance.mean_current.north", axis).set("disturbance.mean_current.east", axis)
    }

    /// 0.3 and 0.1 m/s, each for 20 s.
    fn switching(self) -> Self {
        let end = self.window.map_or(0.0, |[_, to]| to);
        (1..)
            .map(|i| 20.0 * f64::from(i))
            .take_while(|time| *time < end)
            .enumerate()
            .fold(self, |cell, (i, time)| {
                cell.at(time, "controller.command.u", (i % 2 == 0).then_some(0.1))
            })
    }

    /// The vehicle's mass and inertia times a factor, with the trim unchanged.
    fn mass(self, factor: f64) -> Self {
        let p = Parameters::default();
        let i = p.inertia;
        let inertia =
            [("xx", i.xx), ("yy", i.yy), ("zz", i.zz), ("xy", i.xy), ("xz", i.xz), ("yz", i.yz)];
        let trim = p.buoyancy_force() + (factor - 1.0) * p.weight();
        let cell = self.set("vehicle.mass", factor * p.mass).set("vehicle.buoyancy", trim);
        inertia.into_iter().fold(cell, |cell, (axis, value)| {
            cell.set(format!("vehicle.inertia.{axis}"), factor * value)
        })
    }

    /// Kinds of damping of a component times a factor.
    pub(crate) fn damping(self, component: &str, kinds: &[&str], factor: f64) -> Self {
        let p = Parameters::default();
        let all = [("linear", p.linear_damping), ("quadratic", p.quadratic_damping)];
        all.into_iter().filter(|(kind, _)| kinds.contains(kind)).fold(
            self,
            |cell, (kind, values)| {
                ["u", "v", "w", "p", "q", "r"].into_iter().zip(values).fold(
                    cell,
                    |cell, (axis, d)| {
                        cell.set(format!("{component}.{kind}_damping.{axis}"), factor * d)
                    },
                )
            },
        )
    }

    /// All added mass of a component times a factor.
    pub(crate) fn added_mass(self, component: &str, factor: f64) -> Self {
        let mass = Parameters::default().symmetric_added_mass();
        let places = (0..6).flat_map(|i| (i..6).map(move |j| (i, j)));
        places.fold(self, |cell, (i, j)| {
            let name = format!("{component}.added_mass.m{}{}", i + 1, j + 1);
            cell.set(name, factor * mass[i][j])
        })
    }

    /// Thrust over rotor speed squared of a component times a factor.
    pub(crate) fn thrust_gain(self, component: &str, factor: f64) -> Self {
        let gain = Parameters::default().propulsion.thrust_gain;
        self.set(format!("{component}.thrust_gain"), factor * gain)
    }

    fn propeller(self, time: f64) -> Self {
        let input = format!("vehicle.thruster[{LOST}].loss");
        Self { propeller_lost: Some(time), secondary: true, ..self }.at(time, input, Some(1.0))
    }

    /// All cells.
    pub(crate) fn all() -> Vec<Self> {
        let listening = |course, secondary| Self {
            filters: &Filter::ALL,
            secondary,
            ..Self::new(course, course)
        };
        let mut cells =
            vec![listening("BE1", true), listening("BE2", true), listening("BE3", false)];
        for course in ["DIVE", "HELIX"] {
            cells.push(Self { secondary: true, ..Self::new(course, course) });
        }
        for course in ["BE1", "BE2", "BE3", "DIVE", "HELIX"] {
            cells.push(Self {
                steering: Steering::Estimate,
                filters: &[Filter::ModelAided],
                secondary: true,
                ..Self::new(format!("loop-{course}"), course)
            });
        }
        let fix_305 = |name: &str| Self::new(name, "BE3").off(&["fix"], [15.0, 320.0]);
        cells.push(Self::new("fix-60", "BE3").off(&["fix"], OUTAGE));
        cells.push(fix_305("fix-305"));
        let biased = fix_305("fix-305-bias")
            .set("ahrs.heading_bias", 1f64.to_radians())
            .set("dvl.scale_error", 0.003)
            .set("*.heading_bias_sigma", 1f64.to_radians());
        cells.push(biased);
        for cell in [Self::new("smoother", "BE3"), Self::outage("smoother-outage", GRADES[0])] {
            cells.push(Self { smoothed: true, secondary: true, ..cell });
        }
        for grade in GRADES {
            cells.push(Self::outage("outage", grade));
            cells.push(Self::outage("outage-current", grade).current());
            cells.push(Self::outage("outage-speed", grade).switching());
            cells.push(Self::outage("outage-mass-20", grade).switching().mass(0.8));
            cells.push(Self::outage("outage-mass+20", grade).switching().mass(1.2));
            cells.push(Self::outage("outage-damping-20", grade).damping("vehicle", &BOTH, 0.8));
            cells.push(Self::outage("outage-damping+20", grade).damping("vehicle", &BOTH, 1.2));
            let stopped = format!("vehicle.thruster[{LOST}].force");
            cells.push(Self::outage("outage-dead", grade).at(100.0, stopped, Some(0.0)));
            cells.push(Self::outage("propeller-before", grade).propeller(100.0));
            cells.push(Self::outage("propeller-during", grade).propeller(230.0));
        }
        cells
    }
}
