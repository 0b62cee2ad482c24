//! Units of components: the types that variables have by them, and the unit of a derivative.

/// Units with the quantity that they usually measure, for `SimpleType`.
const QUANTITIES: [(&str, &str); 22] = [
    ("1", "Number"),
    ("s", "Time"),
    ("Hz", "Frequency"),
    ("1/s", "Rate"),
    ("m", "Length"),
    ("m2", "Area"),
    ("m3", "Volume"),
    ("m/s", "Velocity"),
    ("m/s2", "Acceleration"),
    ("rad", "Angle"),
    ("deg", "AngleInDegrees"),
    ("rad/s", "AngularVelocity"),
    ("rad/s2", "AngularAcceleration"),
    ("kg", "Mass"),
    ("kg/m3", "Density"),
    ("kg.m2", "MomentOfInertia"),
    ("N", "Force"),
    ("N.m", "Torque"),
    ("Pa", "Pressure"),
    ("V", "Voltage"),
    ("A", "Current"),
    ("K", "Temperature"),
];

/// Name of the type that variables of a unit have.
pub(crate) fn type_name(unit: &str) -> String {
    match QUANTITIES.iter().find(|(known, _)| *known == unit) {
        Some((_, quantity)) => (*quantity).to_owned(),
        None => format!("Value in {unit}"),
    }
}

/// Whether a name is that of such a type, and so no longer free for others.
pub(crate) fn is_type_name(name: &str) -> bool {
    QUANTITIES.iter().any(|(_, quantity)| *quantity == name)
}

/// The unit of a time derivative.
pub(crate) fn per_second(unit: Option<&str>) -> String {
    match unit {
        None | Some("1") => "1/s".to_owned(),
        Some(unit) => match unit.strip_suffix("/s2") {
            Some(start) => format!("{start}/s3"),
            None if unit.ends_with("/s") => format!("{unit}2"),
            None => format!("{unit}/s"),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::per_second;

    #[test]
    fn derivatives_gain_a_second() {
        assert_eq!(per_second(Some("m/s")), "m/s2");
        assert_eq!(per_second(Some("m/s2")), "m/s3");
        assert_eq!(per_second(Some("N")), "N/s");
        assert_eq!(per_second(None), "1/s");
    }
}
