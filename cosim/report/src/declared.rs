//! Results whose truth, estimates and fixes a file declares: under the names by which a report finds
//! them, in its axes and base units.

use std::collections::HashSet;
use std::f64::consts::FRAC_PI_2;

use cosim_core::{Recording, Result};
use cosim_results::roles::{
    Axes, Choice, Declaration, Estimate, Group, POSE, Place, Roles, VELOCITY,
};

/// A value of the report from one of the results: the axis of that, its sign, and what is added.
type Turn = (usize, f64, f64);

const SAME: [Turn; 6] =
    [(0, 1.0, 0.0), (1, 1.0, 0.0), (2, 1.0, 0.0), (3, 1.0, 0.0), (4, 1.0, 0.0), (5, 1.0, 0.0)];
/// Of poses: from east, north, up to north, east, down.
const POSES: [Turn; 6] = [
    (1, 1.0, 0.0),
    (0, 1.0, 0.0),
    (2, -1.0, 0.0),
    (3, 1.0, 0.0),
    (4, -1.0, 0.0),
    (5, -1.0, FRAC_PI_2),
];
/// Of velocities: from forward, port, up to forward, starboard, down.
const VELOCITIES: [Turn; 6] =
    [(0, 1.0, 0.0), (1, -1.0, 0.0), (2, -1.0, 0.0), (3, 1.0, 0.0), (4, -1.0, 0.0), (5, -1.0, 0.0)];

/// Deviations have no sign.
fn deviations(turns: [Turn; 6]) -> [Turn; 6] {
    turns.map(|(axis, ..)| (axis, 1.0, 0.0))
}

/// The results with further columns, and what these are. A column that already has the name of a new
/// one is replaced.
pub(super) fn declared(
    recording: &Recording,
    declaration: &Declaration,
) -> Result<(Recording, Choice)> {
    let roles = Roles::recorded(recording, Some(declaration))?;
    let up = roles.axes == Axes::Enu;
    let (poses, velocities) = if up { (POSES, VELOCITIES) } else { (SAME, SAME) };
    let columns: Vec<&[f64]> = recording.columns().map(|(_, values)| values).collect();
    let mut made: Vec<(String, &str, Vec<f64>)> = Vec::new();
    let mut add = |path: String, axes: &[&str], turns: &[Turn], places: &[Option<Place>]| {
        for (to, (name, (from, sign, more))) in axes.iter().zip(turns).enumerate() {
            let Some((column, factor, offset)) = places[*from].map(Place::numbers) else {
                continue;
            };
            let value = |value: &f64| more + sign * (factor * value + offset);
            let unit = ["m", "rad"][usize::from(to > 2)];
            let unit = if axes == VELOCITY { ["m/s", "rad/s"][usize::from(to > 2)] } else { unit };
            made.push((
                format!("{path}.{name}"),
                unit,
                columns[column].iter().map(value).collect(),
            ));
        }
    };
    let mut choice = Choice::default();
    for body in &roles.bodies {
        let of = |group: &str| format!("{}.{group}", body.name);
        add(of("pose"), &POSE, &poses, &body.pose.places());
        add(of("sigma"), &POSE, &deviations(poses), &body.sigma.places());
        add(of("velocity"), &VELOCITY, &velocities, &body.velocity.places());
        let turns = deviations(velocities);
        add(of("velocity_sigma"), &VELOCITY, &turns, &body.velocity_sigma.places());
        let both = body.covariances.iter().find(|(one, other, _)| (*one, *other) == (0, 1));
        if let Some((.., place)) = both {
            add(of("covariance"), &["x_y"], &SAME[..1], &[Some(*place)]);
        }
        let path = of("pose");
        if body.is_truth {
            choice.truth = Some(path);
        } else {
            let covariance = both.map(|_| of("covariance"));
            let sigma = body.sigma.has([0, 1]).then(|| of("sigma"));
            choice.estimates.push(Estimate { path, sigma, covariance });
        }
    }
    let mut add_position = |path: String, position: &Group<3>| {
        add(path.clone(), &POSE[..3], &poses[..3], &position.places());
        path
    };
    let courses = roles.courses.iter().map(|course| (format!("{}.target", course.name), course));
    let courses = courses.map(|(path, course)| add_position(path, &course.position));
    choice.courses = Some(courses.collect());
    let fixes = roles.sensors.iter().filter(|sensor| sensor.position.has([0, 1]));
    let fixes =
        fixes.map(|sensor| add_position(format!("{}.position", sensor.name), &sensor.position));
    choice.fixes = Some(fixes.collect());
    let new: HashSet<&str> = made.iter().map(|(name, ..)| name.as_str()).collect();
    let kept: Vec<usize> = (0..columns.len())
        .filter(|place| !new.contains(recording.names()[*place].as_str()))
        .collect();
    Ok((recording.with_columns(&kept, made), choice))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn declared_paths_are_turned_north_and_given_base_units() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("roles.toml");
        let text = "axes = 'enu'\n[truth]\npose = { x = 'e', y = 'n', z = 'h', yaw = 'psi' }\n\
            [estimates.nav]\npose = 'nav.pose'\nsigma = 'nav.sigma'\n\
            [courses.leg]\nposition = { x = 'aim.e', y = 'aim.n' }\n\
            [sensors.fix]\nposition = 'gps.position'\n";
        std::fs::write(&file, text).unwrap();
        let columns: [(&str, &str, f64); 13] = [
            ("e", "m", 1.0),
            ("n", "m", 2.0),
            ("h", "m", -3.0),
            ("psi", "deg", 90.0),
            ("nav.pose.x", "m", 4.0),
            ("nav.pose.y", "m", 5.0),
            ("nav.sigma.x", "m", 0.1),
            ("nav.sigma.y", "m", 0.2),
            ("gps.position.x", "m", 6.0),
            ("gps.position.y", "m", 7.0),
            ("aim.e", "m", 9.0),
            ("aim.n", "m", 10.0),
            ("other", "m", 8.0),
        ];
        let names = columns.iter().map(|(name, ..)| (*name).to_owned()).collect();
        let units = columns.iter().map(|(_, unit, _)| (*unit).to_owned()).collect();
        let values = columns.iter().map(|(.., value)| vec![*value]).collect();
        let results = Recording::from_columns(names, vec![0.0], values).with_units(units);
        let declaration = Declaration::read(&file).unwrap();
        let (made, choice) = declared(&results, &declaration).unwrap();
        let value = |name: &str| made.column(name).unwrap()[0];
        assert_eq!(["truth.pose.x", "truth.pose.y", "truth.pose.z"].map(value), [2.0, 1.0, 3.0]);
        // East is 90 degrees from north.
        assert!(value("truth.pose.yaw").abs() < 1e-12);
        assert_eq!(["nav.pose.x", "nav.pose.y"].map(value), [5.0, 4.0]);
        assert_eq!(["nav.sigma.x", "nav.sigma.y"].map(value), [0.2, 0.1]);
        assert_eq!(["fix.position.x", "fix.position.y", "other"].map(value), [7.0, 6.0, 8.0]);
        assert_eq!(["leg.target.x", "leg.target.y"].map(value), [10.0, 9.0]);
        assert_eq!(choice.courses, Some(vec!["leg.target".to_owned()]));
        assert_eq!(choice.truth.as_deref(), Some("truth.pose"));
        assert_eq!(choice.estimates[0].sigma.as_deref(), Some("nav.sigma"));
        assert_eq!(choice.fixes, Some(vec!["fix.position".to_owned()]));
        let units: Vec<(&str, &str)> = made.units().collect();
        assert!(units.contains(&("truth.pose.yaw", "rad")) && units.contains(&("psi", "deg")));
    }
}
