//! The messages for invalid declarations: each points at the offending place and says what to do.

use crate::{enumeration, variables};
use quote::quote;

/// Derives for the source and splits the error: the text it points at, and its message.
fn refusal(source: &str) -> (String, String) {
    let input = syn::parse_str(source).unwrap();
    let derived = match source.contains("enum Items") {
        true => enumeration::derive(&input, &quote!(::fmu_kit)),
        false => variables::derive(&input, &quote!(::fmu_kit)),
    };
    let error = derived.unwrap_err();
    let (start, end) = (error.span().start(), error.span().end());
    assert_eq!(start.line, end.line);
    let line = source.lines().nth(start.line - 1).unwrap();
    (line[start.column..end.column].to_owned(), error.to_string())
}

fn field(declaration: &str) -> (String, String) {
    refusal(&format!("struct Parameters {{\n    good: f64,\n    {declaration},\n}}"))
}

#[test]
fn types_that_are_no_variables_are_pointed_at_with_those_that_are() {
    for (declaration, place, what) in [
        ("speed: f32", "f32", "`f32`"),
        ("n: usize", "usize", "`usize`"),
        ("list: Vec<f64>", "Vec", "`Vec`"),
        ("maybe: Option<i32>", "Option", "`Option`"),
        ("pair: (f64, f64)", "(", "this type"),
        ("values: [u8; 3]", "[", "`u8`"),
    ] {
        let (at, message) = field(declaration);
        assert!(at.starts_with(place), "{declaration}: {at}");
        assert_eq!(
            message,
            format!(
                "{what} is no kind of FMI variable: use f64, i32, bool, String, Text<N>, an enum deriving \
                 Enumeration, a struct deriving Variables, or an array [T; N] of these"
            )
        );
    }
    let (at, message) = field("inertia: [[f64; 3]; 3]");
    assert!(at.starts_with('[') && message.ends_with("use a struct of rows"), "{at}: {message}");
}

#[test]
fn attributes_that_make_no_sense_are_pointed_at() {
    let (at, message) = field("#[var(units = \"m\")] depth: f64");
    assert_eq!(at, "units");
    assert!(message.starts_with("unknown attribute `units`: #[var] takes unit, start, min"));
    let (at, message) = field("#[var(rename = \"a,b\")] depth: f64");
    assert_eq!(at, "\"a,b\"");
    assert!(message.starts_with("a variable's name is letters, digits and underscores"));
    let (at, _) = field("#[var(rename = \"gyro..range\")] depth: f64");
    assert_eq!(at, "\"gyro..range\"");
    let (_, message) = field("#[var(start = , unit = \"m\")] depth: f64");
    assert!(message.ends_with("expected a value"), "{message}");
    let (at, message) = field("#[var(min = 0.0)] on: bool");
    assert_eq!(at, "bool");
    assert_eq!(message, "`min` makes no sense for `bool`: only numbers have it");
    let (at, message) = field("#[var(unit = \"m\")] name: String");
    assert_eq!(at, "String");
    assert!(message.starts_with("`unit` makes no sense"));
}

#[test]
fn structs_and_enums_of_the_wrong_kind_are_pointed_at() {
    for (source, place, advice) in [
        ("enum Mode { On, Off }", "Mode", "derive Enumeration instead"),
        ("struct Pair(f64, f64);", "Pair", "the names are the FMI names"),
        ("struct Of<T> { value: T }", "T", "one fixed table"),
        ("struct Items { on: bool } // enum Items", "Items", "derive Variables for a struct"),
        ("enum Items { On(f64), Off }", "On", "leave the fields out"),
        ("enum Items { On = 3, Off }", "3", "leave the numbers out"),
    ] {
        let (at, message) = refusal(source);
        assert!(at.starts_with(place), "{source}: {at}");
        assert!(message.ends_with(advice), "{source}: {message}");
    }
}
