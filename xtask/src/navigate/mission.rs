//! One mission of a cell: the start values of a seed, what happens when, what is recorded.

use cosim::observe::{RunInfo, Stop};
use cosim::{Controls, Manipulator, Observer, Overrides, Recording, Run, Summary, System, Time};
use rexrov::guidance::Course;
use rexrov::sensors::{Gaussian, ImuGrade};

use super::cell::{Cell, Event};
use super::filter::Filter;

/// Time between recorded rows (s).
pub(crate) const INTERVAL: f64 = 0.1;
/// Standard deviation of the position that a filter starts with, north and east (m).
const START_SIGMA: f64 = 0.5;
/// What draws random numbers.
const RANDOM: [&str; 7] = ["imu", "ahrs", "dvl", "fix", "pressure", "tachometer", "disturbance"];
/// An attitude reference that says 50 times a second what 0.01 rad say 10 times a second.
const AHRS_HZ: f64 = 50.0;
const HEADING_SIGMA: f64 = 0.0224;
/// Cycles of a filter: every sensor samples at multiples of their period.
const FILTER_HZ: f64 = 50.0;
/// Beams that make the noise of a velocity log the same along all axes, in degrees: 1 / sqrt(3) is
/// their cosine.
const EVEN_BEAMS: f64 = 54.735_610_317_245_35;
/// Signals of the truth and of the guidance.
const TRUTH: [&str; 14] = [
    "vehicle.pose.x",
    "vehicle.pose.y",
    "vehicle.pose.z",
    "vehicle.pose.roll",
    "vehicle.pose.pitch",
    "vehicle.pose.yaw",
    "vehicle.velocity.u",
    "vehicle.velocity.v",
    "vehicle.velocity.w",
    "vehicle.specific_force.x",
    "vehicle.specific_force.y",
    "vehicle.specific_force.z",
    "pursuit.vertical_track",
    "pursuit.finished",
];
/// Signals of each filter.
const ESTIMATE: [&str; 13] = [
    "pose.x",
    "pose.y",
    "pose.z",
    "pose.yaw",
    "sigma.x",
    "sigma.y",
    "sigma.z",
    "sigma.yaw",
    "covariance.*",
    "nis.*",
    "count.*.used",
    "thruster[?].loss",
    "health",
];

/// The course by its name.
pub(crate) fn course(name: &str) -> anyhow::Result<Course> {
    let found = Course::BUILT_IN.iter().find(|(built_in, _)| *built_in == name);
    let (_, text) = found.ok_or_else(|| anyhow::anyhow!("there is no course {name}"))?;
    Ok(Course::parse(text)?)
}

/// Standard deviation of roll and pitch that belongs to a grade (rad).
pub(crate) fn tilt_sigma(grade: &str) -> f64 {
    let grade = match grade {
        "Industrial" => ImuGrade::Industrial,
        "Tactical" => ImuGrade::Tactical,
        _ => ImuGrade::Adis16448,
    };
    grade.noise().attitude_sigma
}

/// Flies a seed of a cell.
pub(crate) fn fly(base: &System, cell: &Cell, seed: u32) -> anyhow::Result<(Recording, Summary)> {
    let system = base.with(&overrides(cell, seed)?)?;
    let (mut recording, mut arrival) = (Recording::new(), Arrival::default());
    let mut events = Events::new(&cell.events)?;
    let run = Run::new(&system).observe(&mut recording).observe(&mut arrival);
    let summary = run.manipulate(&mut events).go()?;
    Ok((recording, summary))
}

fn overrides(cell: &Cell, seed: u32) -> anyhow::Result<Overrides> {
    let stop = match cell.window {
        Some([_, end]) => end,
        None => (4.0 / 3.0 * course(cell.course)?.length() / 0.3).ceil(),
    };
    let filters = || cell.filters.iter().map(|filter| filter.component());
    let recorded =
        filters().flat_map(|f| ESTIMATE.iter().map(move |signal| format!("{f}.{signal}")));
    let mut o = Overrides::new()
        .stop_time(stop)
        .output_interval(INTERVAL)
        .output_variables(TRUTH)
        .output_variables(recorded)
        .start_value("pursuit.course", cell.course)
        .start_value("imu.grade", cell.grade)
        .start_value("ahrs.rate_hz", AHRS_HZ)
        .start_value("ahrs.heading_sigma", HEADING_SIGMA)
        .start_value("ahrs.tilt_sigma", tilt_sigma(cell.grade))
        .start_value("dvl.beam_angle_deg", EVEN_BEAMS)
        .step("ahrs", 1.0 / AHRS_HZ);
    for component in RANDOM {
        o = o.start_value(format!("{component}.seed"), seed);
    }
    // The same for all filters: their comparison is one of pairs.
    let mut start = Gaussian::new(u64::from(seed), START_STREAM);
    let [north, east] = [(); 2].map(|()| START_SIGMA * start.draw());
    for filter in cell.filters {
        let f = filter.component();
        o = o
            .start_value(format!("{f}.initial.pose.x"), north)
            .start_value(format!("{f}.initial.pose.y"), east)
            .start_value(format!("{f}.heading_sigma"), HEADING_SIGMA);
        if !filter.is_paper() {
            o = o
                .start_value(format!("{f}.imu_grade"), cell.grade)
                .start_value(format!("{f}.rate_hz"), FILTER_HZ)
                .step(f, 1.0 / FILTER_HZ);
        }
    }
    for (name, value) in &cell.start_values {
        match name.strip_prefix("*.") {
            None => o = o.start_value(name, value),
            Some(name) => {
                for filter in cell.filters.iter().filter(|f| !f.is_paper()) {
                    o = o.start_value(format!("{}.{name}", filter.component()), value);
                }
            }
        }
    }
    Ok(o)
}

/// A stream of random numbers that no component draws from.
const START_STREAM: u64 = 9000;

/// Ends a mission once its course is finished.
#[derive(Default)]
struct Arrival {
    column: Option<usize>,
    finished: bool,
}

impl Observer for Arrival {
    fn start(&mut self, info: &RunInfo<'_>) -> cosim::Result<()> {
        self.column = info.columns.iter().position(|c| c.name == "pursuit.finished");
        Ok(())
    }

    fn sample(&mut self, _: Time, values: &[f64]) -> cosim::Result<()> {
        self.finished = self.column.and_then(|i| values.get(i)).is_some_and(|f| *f >= 0.5);
        Ok(())
    }

    fn finish(&mut self) -> cosim::Result<()> {
        Ok(())
    }

    fn stop(&self) -> Option<Stop> {
        self.finished.then_some(Stop::Enough)
    }
}

/// What happens, in the order of time.
struct Events(Vec<(Time, Event)>);

impl Events {
    fn new(events: &[Event]) -> cosim::Result<Self> {
        let timed = events.iter().map(|event| {
            Ok((Time::from_seconds(event.time, "the time of an event")?, event.clone()))
        });
        let mut events: Vec<_> = timed.collect::<cosim::Result<_>>()?;
        // The next one is at the end.
        events.sort_by_key(|(time, _)| std::cmp::Reverse(*time));
        Ok(Self(events))
    }
}

impl Manipulator for Events {
    fn next(&self) -> Option<Time> {
        self.0.last().map(|(time, _)| *time)
    }

    fn act(&mut self, now: Time, controls: &mut Controls<'_>) -> cosim::Result<()> {
        while let Some((_, event)) = self.0.pop_if(|(time, _)| *time <= now) {
            match event.value {
                Some(value) => controls.set(&event.input, value)?,
                None => controls.release(&event.input)?,
            }
        }
        Ok(())
    }
}

/// The columns of a filter in a recording.
pub(crate) fn column<'a>(
    recording: &'a Recording,
    filter: Filter,
    signal: &str,
) -> anyhow::Result<&'a [f64]> {
    Ok(recording.column(&format!("{}.{signal}", filter.component()))?)
}
