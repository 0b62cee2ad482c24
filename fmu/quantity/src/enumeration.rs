//! Enumeration parameters: a fieldless Rust enum as an FMI Enumeration type.

/// A fieldless enum as an FMI Enumeration; derive it.
///
/// Items are numbered from 1 in the order written. Names are the Rust names of the variants,
/// descriptions their doc comments, and the start value is the value of the field.
pub trait Enumeration: Copy + Default {
    /// Name of the type, as in `TypeDefinitions`.
    const NAME: &'static str;
    /// Description of the type.
    const DESCRIPTION: &'static str;
    /// Name and description of each item, in the order of their values 1, 2, 3 …
    const ITEMS: &'static [(&'static str, &'static str)];

    /// The item's FMI value, from 1.
    fn value(self) -> i32;

    /// The item of an FMI value, if there is one.
    fn from_value(value: i32) -> Option<Self>;
}
