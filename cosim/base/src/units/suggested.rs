//! Units suggested by names, if no description defines them.
//!
//! Names in marine notation (SNAME 1950, Fossen 2011) and the usual suffixes imply the unit of most
//! variables; for others the unit is unknown.

/// Suffixes and their units.
const SUFFIXES: [(&str, &str); 8] = [
    ("_hz", "Hz"),
    ("_deg", "deg"),
    ("_rad", "rad"),
    ("_m", "m"),
    ("_s", "s"),
    ("_n", "N"),
    ("_m_s", "m/s"),
    ("_rad_s", "rad/s"),
];

/// The unit suggested by a name.
pub fn suggested(name: &str) -> Option<&'static str> {
    let (group, leaf) = name.rsplit_once('.').unwrap_or(("", name));
    let leaf = leaf.split('[').next().unwrap_or(leaf);
    let small = leaf.to_ascii_lowercase();
    // The longest suffix: `_m_s` also ends in `_s`.
    let ends = SUFFIXES.iter().filter(|(end, _)| small.ends_with(end));
    if let Some((_, unit)) = ends.max_by_key(|(end, _)| end.len()) {
        return Some(unit);
    }
    let within = |word: &str| group.split(['.', '_', '[']).any(|part| part == word);
    if within("nis") || within("count") {
        return Some("1");
    }
    if within("covariance") || within("cov") {
        return None;
    }
    let rate = within("acceleration") || within("force");
    Some(match leaf {
        "roll" | "pitch" | "yaw" | "heading" => "rad",
        "u" | "v" | "w" if rate => "m/s2",
        "u" | "v" | "w" => "m/s",
        "p" | "q" | "r" if rate => "rad/s2",
        "p" | "q" | "r" => "rad/s",
        "x" | "y" | "z" | "north" | "east" | "down" => {
            let place = ["pose", "position", "sigma", "fix", "target", "reference", "setpoint"];
            let place = place.into_iter().any(within);
            let speed = within("velocity") || within("current");
            match (rate, speed, place) {
                (true, ..) => "m/s2",
                (_, true, _) => "m/s",
                (_, _, true) => "m",
                _ => return None,
            }
        }
        "depth" | "altitude" => "m",
        "force" | "thrust" | "X" | "Y" | "Z" => "N",
        "K" | "M" | "N" => "N.m",
        "stamp" | "time" => "s",
        "valid" | "health" => "1",
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_suggest_units() {
        for (name, unit) in [
            ("vehicle.pose.x", Some("m")),
            ("vehicle.pose.yaw", Some("rad")),
            ("filter.sigma.x", Some("m")),
            ("filter.velocity_sigma.u", Some("m/s")),
            ("filter.innovation.fix.x", Some("m")),
            ("filter.acceleration.u", Some("m/s2")),
            ("imu.specific_force.x", Some("m/s2")),
            ("plant.thruster[3].thrust", Some("N")),
            ("gps.rate_hz", Some("Hz")),
            ("nav.speed_m_s", Some("m/s")),
            ("filter.covariance.x_y", None),
            ("a.b.x", None),
            ("pressure", None),
        ] {
            assert_eq!(suggested(name), unit, "{name}");
        }
    }
}
