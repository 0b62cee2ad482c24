//! What the derive makes of a struct in a crate that knows only quantities: named elements of
//! arrays, merged groups, units that depend on the place, converted and omitted fields.

use fmu_quantity::{
    Count, Declarations, Enumeration, Field, Member, Reader, Start, Variables, Writer,
};

const BODY: [Member; 2] = [Member::new("x", "forward"), Member::new("y", "starboard").unit("km")];
const FORCE: Member = Member::new("force", "force").unit("N").min(-1.0).max(1.0).nominal(0.5);

/// A kind of sensor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Enumeration)]
enum Kind {
    /// with a coil
    #[default]
    Coil,
    /// with light
    Optical,
}

#[derive(Clone, Copy, Debug, PartialEq, Variables)]
struct Noise {
    /// density
    #[var(min = 0.0, start = 0.1)]
    density: f64,
    /// standard deviation
    sigma: f64,
    /// correlation time
    #[var(unit = "s")]
    time: f64,
}

/// A symmetric matrix of two rows by its upper triangle.
#[derive(Clone, Copy, Debug, Variables)]
struct Triangle {
    #[var(flatten, elements = [Member::new("xx", ""), Member::new("xy", ""), Member::new("yy", "")])]
    elements: [f64; 3],
}

impl From<[[f64; 2]; 2]> for Triangle {
    fn from([[xx, xy], [_, yy]]: [[f64; 2]; 2]) -> Self {
        Self { elements: [xx, xy, yy] }
    }
}

impl From<Triangle> for [[f64; 2]; 2] {
    fn from(Triangle { elements: [xx, xy, yy] }: Triangle) -> Self {
        [[xx, xy], [xy, yy]]
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Variables)]
struct Sensor {
    /// Kind
    kind: Kind,
    /// Place
    #[var(rename = "mounting", unit = "m", elements = BODY, start = [1.0, 2.0])]
    position: [f64; 2],
    /// Gyro
    #[var(unit = "rad/s", unit_of(density = "rad/(s.Hz0.5)"))]
    gyro: Noise,
    /// Gyro: largest value
    #[var(rename = "gyro.range", unit = "rad/s")]
    range: f64,
    /// Thruster
    #[var(rename = "thruster", each = FORCE)]
    thrust: [f64; 2],
    /// Inertia
    #[var(unit = "kg.m2", via = Triangle)]
    inertia: [[f64; 2]; 2],
    #[var(skip)]
    cached: Option<u64>,
}

fn declared(sensor: &Sensor) -> Declarations {
    let mut list = Declarations::new();
    sensor.declare(&Field::default(), &mut list);
    list
}

#[test]
fn elements_and_groups_have_the_declared_names_units_and_bounds() {
    let list = declared(&Sensor::default());
    let all: Vec<_> = list
        .iter()
        .map(|d| (d.field.name.as_str(), d.field.description.as_str(), d.field.unit.unwrap_or("")))
        .collect();
    assert_eq!(
        all,
        [
            ("kind", "Kind", ""),
            ("mounting.x", "Place: forward", "m"),
            ("mounting.y", "Place: starboard", "km"),
            ("gyro.density", "Gyro: density", "rad/(s.Hz0.5)"),
            ("gyro.sigma", "Gyro: standard deviation", "rad/s"),
            ("gyro.time", "Gyro: correlation time", "s"),
            ("gyro.range", "Gyro: largest value", "rad/s"),
            ("thruster[0].force", "Thruster 0: force", "N"),
            ("thruster[1].force", "Thruster 1: force", "N"),
            ("inertia.xx", "Inertia", "kg.m2"),
            ("inertia.xy", "Inertia", "kg.m2"),
            ("inertia.yy", "Inertia", "kg.m2"),
        ]
    );
    let bounds = |i: usize| (list[i].field.min, list[i].field.max, list[i].field.nominal);
    assert_eq!(bounds(3), (Some(0.0), None, None));
    assert_eq!(bounds(8), (Some(-1.0), Some(1.0), Some(0.5)));
    assert_eq!(list[2].start, Start::Real(2.0));
    assert_eq!(list[3].start, Start::Real(0.1));
}

#[test]
fn a_walk_without_names_has_everything_else() {
    let (named, mut nameless) = (declared(&Sensor::default()), Declarations::new());
    Sensor::default().declare(&Field::nameless(), &mut nameless);
    assert_eq!(named.len(), nameless.len());
    for (a, b) in named.iter().zip(&nameless) {
        assert!(b.field.name.is_empty() && b.field.description.is_empty());
        assert_eq!((a.field.unit, a.field.min, &a.start), (b.field.unit, b.field.min, &b.start));
    }
}

#[test]
fn values_pass_through_flat_arrays_except_omitted_ones() {
    let sensor = Sensor {
        kind: Kind::Optical,
        thrust: [0.25, 0.75],
        inertia: [[3.0, 4.0], [4.0, 5.0]],
        cached: Some(1),
        ..Sensor::default()
    };
    assert_eq!(Sensor::COUNT, Count { reals: 11, integers: 1, ..Count::NONE });
    let (mut reals, mut integers) = ([0.0; 11], [0; 1]);
    let mut into = Writer { reals: &mut reals, integers: &mut integers, ..Writer::default() };
    sensor.store(&mut into);
    assert_eq!(reals, [1.0, 2.0, 0.1, 0.0, 0.0, 0.0, 0.25, 0.75, 3.0, 4.0, 5.0]);
    let mut from = Reader { reals: &reals, integers: &integers, ..Reader::default() };
    assert_eq!(Sensor::load(&mut from), Sensor { cached: None, ..sensor });
}

#[test]
fn numbers_of_converted_fields_are_paired_too() {
    let mut a = Sensor { inertia: [[1.0, 2.0], [2.0, 3.0]], ..Sensor::default() };
    let b = Sensor { inertia: [[10.0, 20.0], [20.0, 30.0]], ..Sensor::default() };
    a.zip_reals(&b, &mut |own, other| *own += other);
    assert_eq!(a.inertia, [[11.0, 22.0], [22.0, 33.0]]);
    assert_eq!(a.position, [2.0, 4.0]);
}
