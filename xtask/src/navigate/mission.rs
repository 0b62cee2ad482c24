//! One mission of a cell: the start values of a seed, the events, the recorded variables.

use cosim::observe::{RunInfo, Stop};
use cosim::{Controls, Manipulator, Observer, Overrides, Recording, Run, Summary, System, Time};
use rexrov::guidance::Course;
use rexrov::sensors::{Gaussian, ImuGrade};

use super::cell::{Cell, Event};
use super::filter::Filter;
use super::smoother::INPUTS;

/// Time between recorded rows (s).
pub(crate) const INTERVAL: f64 = 0.1;
/// Standard deviation of the position that a filter starts with, north and east (m).
const START_SIGMA: f64 = 0.5;
/// Components that draw random numbers.
const RANDOM: [&str; 7] = ["imu", "ahrs", "dvl", "fix", "pressure", "tachometer", "disturbance"];
/// An attitude reference at 50 Hz with the same information as 0.01 rad at 10 Hz.
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

/// What is kept of a mission.
pub(crate) struct Flight {
    /// Truth and estimates, one row per [`INTERVAL`].
    pub(crate) recording: Recording,
    pub(crate) summary: Summary,
    /// The same with a row for each cycle of the filters and with their inputs, in cells that are
    /// smoothed.
    pub(crate) heard: Option<Recording>,
}

/// Flies a seed of a cell.
pub(crate) fn fly(base: &System, cell: &Cell, seed: u32) -> anyhow::Result<Flight> {
    let system = base.with(&overrides(cell, seed)?)?;
    let (mut recording, mut arrival) = (Recording::new(), Arrival::default());
    let mut events = Events::new(&cell.events)?;
    let run = Run::new(&system).observe(&mut recording).observe(&mut arrival);
    let summary = run.manipulate(&mut events).go()?;
    let heard = cell.smoothed.then(|| recording.clone());
    let recording = if cell.smoothed { every(&recording, row_stride()) } else { recording };
    Ok(Flight { recording, summary, heard })
}

/// Cycles of a filter between two rows.
fn row_stride() -> usize {
    (INTERVAL * FILTER_HZ).round() as usize
}

/// Every n-th row of a recording.
fn every(recording: &Recording, stride: usize) -> Recording {
    let thinned = |column: &[f64]| column.iter().step_by(stride).copied().collect::<Vec<_>>();
    let columns = recording.columns().map(|(_, column)| thinned(column)).collect();
    Recording::from_columns(recording.names().to_vec(), thinned(recording.time()), columns)
}

/// The row of an instant.
pub(crate) fn row(time: f64) -> usize {
    (time / INTERVAL).round() as usize
}

fn overrides(cell: &Cell, seed: u32) -> anyhow::Result<Overrides> {
    let stop = match cell.window {
        // A smoother looks back at the window from after it.
        Some([_, end]) if !cell.smoothed => end,
        _ => (4.0 / 3.0 * course(cell.course)?.length() / 0.3).ceil(),
    };
    let filters = || cell.filters.iter().map(|filter| filter.component());
    let inputs: &[&str] = if cell.smoothed { &INPUTS } else { &[] };
    let recorded = filters()
        .flat_map(|f| ESTIMATE.iter().chain(inputs).map(move |signal| format!("{f}.{signal}")));
    let mut o = Overrides::new()
        .stop_time(stop)
        .output_interval(if cell.smoothed { 1.0 / FILTER_HZ } else { INTERVAL })
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
    for filter in cell.filters {
        let f = filter.component();
        for (name, value) in filter_parameters(cell, *filter, seed) {
            o = o.start_value(format!("{f}.{name}"), value);
        }
        if !filter.is_paper() {
            o = o.step(f, 1.0 / FILTER_HZ);
        }
    }
    for (name, value) in &cell.start_values {
        if !name.starts_with("*.") {
            o = o.start_value(name, value);
        }
    }
    Ok(o)
}

/// Parameters of a filter, by their names in its FMU.
pub(crate) fn filter_parameters(cell: &Cell, filter: Filter, seed: u32) -> Vec<(String, String)> {
    // The same for all filters, because they are compared in pairs.
    let mut start = Gaussian::new(u64::from(seed), START_STREAM);
    let [north, east] = [(); 2].map(|()| START_SIGMA * start.draw());
    let mut parameters = vec![
        ("initial.pose.x".to_owned(), north.to_string()),
        ("initial.pose.y".to_owned(), east.to_string()),
        ("heading_sigma".to_owned(), HEADING_SIGMA.to_string()),
    ];
    if !filter.is_paper() {
        parameters.push(("imu_grade".to_owned(), cell.grade.to_owned()));
        parameters.push(("rate_hz".to_owned(), FILTER_HZ.to_string()));
        let common = cell.start_values.iter();
        parameters.extend(common.filter_map(|(name, value)| {
            Some((name.strip_prefix("*.")?.to_owned(), value.clone()))
        }));
    }
    parameters
}

/// A stream of random numbers that no component uses.
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

/// The events, in order of time.
struct Events(Vec<(Time, Event)>);

impl Events {
    fn new(events: &[Event]) -> cosim::Result<Self> {
        let timed = events.iter().map(|event| {
            Ok((cosim::time::from_seconds(event.time, "the time of an event")?, event.clone()))
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
