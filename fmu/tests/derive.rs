//! What the derives make of a struct: names, descriptions, inherited units, start values, and the
//! conversion to flat arrays and back.

use fmu_kit::kernel::{Table, TableError};
use fmu_kit::{Count, Declarations, Enumeration, Field, Reader, Start, Variables, Writer};

/// A way of propulsion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Enumeration)]
enum Mode {
    /// Idle.
    #[default]
    Off,
    /// Turning.
    On,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Variables)]
struct Vector {
    /// forward
    #[var(rename = "X")]
    x: f64,
    /// starboard
    y: f64,
}

#[derive(Clone, Debug, Default, PartialEq, Variables)]
struct Everything {
    /// Force on
    /// the hull.
    ///
    /// A second paragraph is for readers of the source.
    #[var(unit = "N", nominal = 100)]
    force: [Vector; 2],
    /// How
    mode: Mode,
    /// Gain
    #[var(min = 0.0, max = 1.0)]
    gain: f64,
    /// Count
    n: i32,
    /// Switch
    r#type: bool,
    /// Text
    label: String,
}

fn declared(value: &Everything) -> Declarations {
    let mut list = Declarations::new();
    value.declare(&Field::default(), &mut list);
    list
}

#[test]
fn names_are_structured_and_zero_based() {
    let list = declared(&Everything::default());
    let names: Vec<&str> = list.iter().map(|d| d.field.name.as_str()).collect();
    assert_eq!(
        names,
        [
            "force[0].X",
            "force[0].y",
            "force[1].X",
            "force[1].y",
            "mode",
            "gain",
            "n",
            "type",
            "label"
        ]
    );
}

#[test]
fn descriptions_join_and_attributes_are_inherited() {
    let list = declared(&Everything::default());
    let leaf = &list[3].field;
    assert_eq!(leaf.description, "Force on the hull 1: starboard");
    assert_eq!((leaf.unit, leaf.nominal, leaf.min), (Some("N"), Some(100.0), None));
    assert_eq!((list[5].field.min, list[5].field.max), (Some(0.0), Some(1.0)));
}

#[test]
fn start_values_are_the_values() {
    let value = Everything { mode: Mode::On, n: 7, label: "a".into(), ..Default::default() };
    let list = declared(&value);
    assert!(matches!(list[4].start, Start::Enumeration { name: "Mode", value: 2, .. }));
    assert_eq!(list[6].start, Start::Integer(7));
    assert_eq!(list[8].start, Start::String("a".into()));
    assert_eq!(Mode::ITEMS, [("Off", "Idle"), ("On", "Turning")]);
    assert_eq!(Mode::from_value(3), None);
}

#[test]
fn values_survive_the_flat_arrays() {
    let count = Everything::COUNT;
    assert_eq!(count, Count { reals: 5, integers: 2, booleans: 1, strings: 1 });
    let value = Everything {
        force: [Vector { x: 1.0, y: 2.0 }, Vector { x: 3.0, y: 4.0 }],
        mode: Mode::On,
        gain: 5.0,
        n: -6,
        r#type: true,
        label: "ü, \"quoted\"".into(),
    };
    let (mut reals, mut integers) = (vec![0.0; count.reals], vec![0; count.integers]);
    let (mut booleans, mut strings) = (vec![false; 1], vec![Default::default(); 1]);
    value.store(&mut Writer {
        reals: &mut reals,
        integers: &mut integers,
        booleans: &mut booleans,
        strings: &mut strings,
    });
    assert_eq!(reals, [1.0, 2.0, 3.0, 4.0, 5.0]);
    let mut reader =
        Reader { reals: &reals, integers: &integers, booleans: &booleans, strings: &strings };
    assert_eq!(Everything::load(&mut reader), value);
}

#[test]
fn zip_reals_pairs_the_numbers_and_leaves_the_rest() {
    let mut a = Everything { gain: 1.0, n: 3, ..Default::default() };
    let b = Everything { gain: 10.0, n: 4, ..Default::default() };
    a.zip_reals(&b, &mut |own, other| *own += 0.5 * other);
    assert_eq!((a.gain, a.n), (6.0, 3));
}

#[derive(Debug, PartialEq, Variables)]
struct Started {
    /// Gain
    #[var(start = 2)]
    gain: f64,
    /// Depth
    depth: f64,
    /// Course
    #[var(start = "BE1")]
    course: String,
    /// Way of propulsion
    #[var(start = Mode::On)]
    mode: Mode,
    /// Limit
    #[var(start = -f64::MAX)]
    limit: f64,
}

#[test]
fn start_values_in_attributes_are_the_default() {
    let course = "BE1".to_owned();
    let expected = Started { gain: 2.0, depth: 0.0, course, mode: Mode::On, limit: -f64::MAX };
    assert_eq!(Started::default(), expected);
}

/// The table of one group of parameters.
fn table(value: &impl Variables) -> Result<Table, TableError> {
    let mut list = Declarations::new();
    value.declare(&Field::default(), &mut list);
    Table::new(list, Vec::new(), Vec::new(), Vec::new())
}

#[derive(Default, Variables)]
struct SameName {
    /// Depth
    z: f64,
    /// Depth again
    #[var(rename = "z")]
    depth: f64,
}

#[derive(Default, Variables)]
struct BadUnit {
    /// Depth
    #[var(unit = "fathom")]
    depth: f64,
}

#[derive(Default, Variables)]
struct BadStart {
    /// Rate
    #[var(unit = "Hz", min = 1.0)]
    rate: f64,
}

#[test]
fn declarations_that_cannot_stand_name_the_variable_and_say_why() {
    let same = table(&SameName::default()).unwrap_err().to_string();
    assert!(same.starts_with("two variables are called \"z\"; nest one of them"), "{same}");
    let unit = table(&BadUnit::default()).unwrap_err().to_string();
    assert!(unit.starts_with("\"depth\": ") && unit.contains("fathom"), "{unit}");
    let start = table(&BadStart::default()).unwrap_err().to_string();
    assert!(start.starts_with("start value 0 of \"rate\" is not within 1"), "{start}");
}
