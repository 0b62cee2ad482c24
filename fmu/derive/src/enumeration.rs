//! `#[derive(Enumeration)]`: a fieldless enum as one variable of an FMI Enumeration type.

use proc_macro2::TokenStream;
use quote::quote;
use syn::{Data, DeriveInput, Error, Fields, Result};

use crate::attributes::description;

pub(crate) fn derive(input: &DeriveInput) -> Result<TokenStream> {
    let Data::Enum(data) = &input.data else {
        return Err(Error::new_spanned(
            &input.ident,
            "Enumeration is for enums; derive Variables for a struct",
        ));
    };
    if let Some(variant) = data.variants.iter().find(|v| !matches!(v.fields, Fields::Unit)) {
        return Err(Error::new_spanned(
            variant,
            "an item of an FMI Enumeration carries no data: leave the fields out",
        ));
    }
    if let Some((_, discriminant)) = data.variants.iter().find_map(|v| v.discriminant.as_ref()) {
        return Err(Error::new_spanned(
            discriminant,
            "items count from 1 in the order written: leave the numbers out",
        ));
    }
    let name = &input.ident;
    let type_name = name.to_string();
    let about = description(&input.attrs);
    let items: Vec<_> = data.variants.iter().map(|variant| &variant.ident).collect();
    let names = items.iter().map(ToString::to_string);
    let descriptions = data.variants.iter().map(|variant| description(&variant.attrs));
    let values: Vec<i32> = (1..).take(items.len()).collect();
    let variables = variables(name);
    Ok(quote! {
        #[automatically_derived]
        impl ::fmu_kit::Enumeration for #name {
            const NAME: &'static str = #type_name;
            const DESCRIPTION: &'static str = #about;
            const ITEMS: &'static [(&'static str, &'static str)] = &[#((#names, #descriptions)),*];

            fn value(self) -> i32 {
                match self { #(Self::#items => #values,)* }
            }

            fn from_value(value: i32) -> ::core::option::Option<Self> {
                match value {
                    #(#values => ::core::option::Option::Some(Self::#items),)*
                    _ => ::core::option::Option::None,
                }
            }
        }
        #variables
    })
}

/// The enum as a leaf: an Integer in the flat arrays.
fn variables(name: &syn::Ident) -> TokenStream {
    quote! {
        #[automatically_derived]
        impl ::fmu_kit::Variables for #name {
            const COUNT: ::fmu_kit::Count = <i32 as ::fmu_kit::Variables>::COUNT;

            fn declare(&self, at: &::fmu_kit::Field, into: &mut ::fmu_kit::Declarations) {
                into.push(::fmu_kit::Declaration {
                    field: ::core::clone::Clone::clone(at),
                    start: ::fmu_kit::Start::Enumeration {
                        name: <Self as ::fmu_kit::Enumeration>::NAME,
                        description: <Self as ::fmu_kit::Enumeration>::DESCRIPTION,
                        items: <Self as ::fmu_kit::Enumeration>::ITEMS,
                        value: ::fmu_kit::Enumeration::value(*self),
                    },
                });
            }

            fn load(from: &mut ::fmu_kit::Reader<'_>) -> Self {
                let value = <i32 as ::fmu_kit::Variables>::load(from);
                <Self as ::fmu_kit::Enumeration>::from_value(value).unwrap_or_default()
            }

            fn store(&self, into: &mut ::fmu_kit::Writer<'_>) {
                ::fmu_kit::Variables::store(&::fmu_kit::Enumeration::value(*self), into);
            }

            fn zip_reals(&mut self, _: &Self, _: &mut impl FnMut(&mut f64, f64)) {}
        }
    }
}
