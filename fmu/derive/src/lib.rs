//! `#[derive(Variables)]` and `#[derive(Enumeration)]` for `fmu-kit` and `fmu-quantity`.
//!
//! The generated code only walks the fields in order; the meaning of the walk is defined once, in
//! the `Variables` trait of `fmu-quantity`. Each derive exists twice, because generated code names
//! the crate in which it finds that trait: a component depends on `fmu-kit`, mathematics on
//! `fmu-quantity` alone. Those crates re-export theirs as `Variables` and `Enumeration`.

mod attributes;
mod enumeration;
#[cfg(test)]
mod tests;
mod variables;

use proc_macro::TokenStream;
use quote::quote;
use syn::{DeriveInput, parse_macro_input};

/// Makes the fields of a struct FMI variables.
///
#[doc = include_str!("attributes.md")]
#[proc_macro_derive(Variables, attributes(var))]
pub fn derive_variables(input: TokenStream) -> TokenStream {
    let input = parse_macro_input!(input as DeriveInput);
    let derived = variables::derive(&input, &quote!(::fmu_kit));
    derived.unwrap_or_else(syn::Error::into_compile_error).into()
}

/// `Variables` for a crate that depends on `fmu-quantity` instead of `fmu-kit`, which re-exports
/// this as `Variables`.
///
#[doc = include_str!("attributes.md")]
#[proc_macro_derive(QuantityVariables, attributes(var))]
pub fn derive_quantity_variables(input: TokenStream) -> TokenStream {
    let input = parse_macro_input!(input as DeriveInput);
    let derived = variables::derive(&input, &quote!(::fmu_quantity));
    derived.unwrap_or_else(syn::Error::into_compile_error).into()
}

/// Makes a fieldless enum an FMI Enumeration type; its items count from 1 in the order written.
///
/// The doc comments of the enum and its variants are the descriptions. The enum must also derive
/// `Clone`, `Copy` and `Default`.
#[proc_macro_derive(Enumeration)]
pub fn derive_enumeration(input: TokenStream) -> TokenStream {
    let input = parse_macro_input!(input as DeriveInput);
    let derived = enumeration::derive(&input, &quote!(::fmu_kit));
    derived.unwrap_or_else(syn::Error::into_compile_error).into()
}

/// `Enumeration` for a crate that depends on `fmu-quantity` instead of `fmu-kit`, which re-exports
/// this as `Enumeration`.
///
/// The items count from 1 in the order written. The doc comments of the enum and its variants are
/// the descriptions. The enum must also derive `Clone`, `Copy` and `Default`.
#[proc_macro_derive(QuantityEnumeration)]
pub fn derive_quantity_enumeration(input: TokenStream) -> TokenStream {
    let input = parse_macro_input!(input as DeriveInput);
    let derived = enumeration::derive(&input, &quote!(::fmu_quantity));
    derived.unwrap_or_else(syn::Error::into_compile_error).into()
}
