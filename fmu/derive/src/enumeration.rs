//! `#[derive(Enumeration)]`: a fieldless enum as one variable of an FMI Enumeration type.

use proc_macro2::TokenStream;
use quote::quote;
use syn::{Data, DeriveInput, Error, Fields, Result};

use crate::attributes::description;

/// The impl of `Enumeration` and `Variables` in the crate `root`.
pub(crate) fn derive(input: &DeriveInput, root: &TokenStream) -> Result<TokenStream> {
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
    let variables = variables(name, root);
    Ok(quote! {
        #[automatically_derived]
        impl #root::Enumeration for #name {
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
fn variables(name: &syn::Ident, root: &TokenStream) -> TokenStream {
    quote! {
        #[automatically_derived]
        impl #root::Variables for #name {
            const COUNT: #root::Count = <i32 as #root::Variables>::COUNT;

            fn declare(&self, at: &#root::Field, into: &mut #root::Declarations) {
                into.push(#root::Declaration {
                    field: ::core::clone::Clone::clone(at),
                    start: #root::Start::Enumeration {
                        name: <Self as #root::Enumeration>::NAME,
                        description: <Self as #root::Enumeration>::DESCRIPTION,
                        items: <Self as #root::Enumeration>::ITEMS,
                        value: #root::Enumeration::value(*self),
                    },
                });
            }

            #[inline]
            fn load(from: &mut #root::Reader<'_>) -> Self {
                let value = <i32 as #root::Variables>::load(from);
                <Self as #root::Enumeration>::from_value(value).unwrap_or_default()
            }

            #[inline]
            fn store(&self, into: &mut #root::Writer<'_>) {
                #root::Variables::store(&#root::Enumeration::value(*self), into);
            }

            #[inline]
            fn zip_reals(&mut self, _: &Self, _: &mut impl FnMut(&mut f64, f64)) {}
        }
    }
}
