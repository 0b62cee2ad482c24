//! `#[derive(Variables)]` and `#[derive(Enumeration)]` for `fmu-kit`.
//!
//! The generated code only walks the fields in order; the meaning of the walk is defined once, in
//! the `Variables` trait of `fmu-kit`.

mod attributes;
mod enumeration;
#[cfg(test)]
mod tests;
mod variables;

use proc_macro::TokenStream;
use syn::{DeriveInput, parse_macro_input};

/// Makes the fields of a struct FMI variables.
///
/// Fields are `f64`, `i32`, `bool`, `String`, an enum deriving `Enumeration`, a struct deriving
/// `Variables`, or an array of these. The first paragraph of a field's doc comment is its
/// description. `#[var(...)]` on a field takes
///
/// * `unit = "m/s"`, `min = 0.0`, `max = 1.0`, `nominal = 100.0`: also apply to the leaves below
/// * `start = 60.0`: the start value, a literal or a path; if any field has one, the derive writes
///   `Default` for the struct
/// * `rename = "X"`: the FMI name, if it is not a Rust field name
/// * `flatten`: the members join the enclosing struct without a prefix
#[proc_macro_derive(Variables, attributes(var))]
pub fn derive_variables(input: TokenStream) -> TokenStream {
    let input = parse_macro_input!(input as DeriveInput);
    variables::derive(&input).unwrap_or_else(syn::Error::into_compile_error).into()
}

/// Makes a fieldless enum an FMI Enumeration type; its items count from 1 in the order written.
///
/// The doc comments of the enum and its variants are the descriptions. The enum must also derive
/// `Clone`, `Copy` and `Default`.
#[proc_macro_derive(Enumeration)]
pub fn derive_enumeration(input: TokenStream) -> TokenStream {
    let input = parse_macro_input!(input as DeriveInput);
    enumeration::derive(&input).unwrap_or_else(syn::Error::into_compile_error).into()
}
