//! `#[derive(Variables)]`: each function of the trait, field by field.

use proc_macro2::TokenStream;
use quote::quote;
use syn::ext::IdentExt;
use syn::{Data, DeriveInput, Error, Field, Fields, Ident, Result, Type};

use crate::attributes::{Var, description, option};

/// Number types that an author may try but that FMI 2.0 does not have.
const NO_SUCH_TYPE: [&str; 13] = [
    "f32", "i8", "i16", "i64", "i128", "isize", "u8", "u16", "u32", "u64", "u128", "usize", "char",
];

/// The impl of `Variables` in the crate `root`.
pub(crate) fn derive(input: &DeriveInput, root: &TokenStream) -> Result<TokenStream> {
    let fields = fields(input)?;
    let name = &input.ident;
    let vars = fields.iter().map(|f| Var::parse(&f.attrs)).collect::<Result<Vec<_>>>()?;
    let default = default(name, &fields, &vars);
    let mut walks = Vec::new();
    for (field, var) in fields.iter().zip(vars) {
        walks.push(walk(field, var, root)?);
    }
    let each =
        |part: fn(&Walk) -> &TokenStream| walks.iter().map(part).cloned().collect::<TokenStream>();
    let (count, declare, load) = (each(|w| &w.count), each(|w| &w.declare), each(|w| &w.load));
    let (store, zip) = (each(|w| &w.store), each(|w| &w.zip));
    Ok(quote! {
        #default

        #[automatically_derived]
        impl #root::Variables for #name {
            const COUNT: #root::Count = #root::Count::NONE #count;

            fn declare(&self, at: &#root::Field, into: &mut #root::Declarations) {
                #declare
            }

            #[inline(always)]
            fn load(from: &mut #root::Reader<'_>) -> Self {
                Self { #load }
            }

            #[inline(always)]
            fn store(&self, into: &mut #root::Writer<'_>) {
                #store
            }

            #[inline(always)]
            fn zip_reals(&mut self, other: &Self, f: &mut impl FnMut(&mut f64, f64)) {
                #zip
            }
        }
    })
}

/// The part of each function that concerns one field.
struct Walk {
    count: TokenStream,
    declare: TokenStream,
    load: TokenStream,
    store: TokenStream,
    zip: TokenStream,
}

fn walk(field: &Field, var: Var, root: &TokenStream) -> Result<Walk> {
    let (ident, own) = (&field.ident, &field.ty);
    if var.skip {
        let load = quote!(#ident: ::core::default::Default::default(),);
        let nothing = TokenStream::new;
        return Ok(Walk {
            count: nothing(),
            declare: nothing(),
            load,
            store: nothing(),
            zip: nothing(),
        });
    }
    let Some(via) = var.via.clone() else {
        return Ok(Walk {
            count: quote!(.plus(<#own as #root::Variables>::COUNT)),
            declare: declare(field, var, &quote!(&self.#ident), root)?,
            load: quote!(#ident: <#own as #root::Variables>::load(from),),
            store: quote!(#root::Variables::store(&self.#ident, into);),
            zip: quote!(#root::Variables::zip_reals(&mut self.#ident, &other.#ident, f);),
        });
    };
    let seen = |whose: TokenStream| quote!(<#via as ::core::convert::From<#own>>::from(::core::clone::Clone::clone(&#whose.#ident)));
    let (mine, theirs) = (seen(quote!(self)), seen(quote!(other)));
    let back = quote!(<#own as ::core::convert::From<#via>>::from);
    Ok(Walk {
        count: quote!(.plus(<#via as #root::Variables>::COUNT)),
        declare: declare(field, var, &quote!(&#mine), root)?,
        load: quote!(#ident: #back(<#via as #root::Variables>::load(from)),),
        store: quote!(#root::Variables::store(&#mine, into);),
        zip: quote! {
            let mut seen = #mine;
            #root::Variables::zip_reals(&mut seen, &#theirs, f);
            self.#ident = #back(seen);
        },
    })
}

fn fields(input: &DeriveInput) -> Result<Vec<&Field>> {
    if let Some(generic) = input.generics.params.first() {
        return Err(Error::new_spanned(
            generic,
            "Variables cannot be derived for a generic struct: an FMU has one fixed table",
        ));
    }
    match &input.data {
        Data::Struct(data) if matches!(data.fields, Fields::Named(_)) => {
            Ok(data.fields.iter().collect())
        }
        Data::Enum(_) => Err(Error::new_spanned(
            &input.ident,
            "an enum is one variable, not a group: derive Enumeration instead",
        )),
        _ => Err(Error::new_spanned(
            &input.ident,
            "Variables needs a struct with named fields: the names are the FMI names",
        )),
    }
}

/// `Default` from the start values, if any field has one.
fn default(name: &Ident, fields: &[&Field], vars: &[Var]) -> Option<TokenStream> {
    vars.iter().find(|var| var.start.is_some())?;
    let values = fields.iter().zip(vars).map(|(field, var)| {
        let ident = &field.ident;
        match &var.start {
            Some(start) => quote!(#ident: ::core::convert::Into::into(#start)),
            None => quote!(#ident: ::core::default::Default::default()),
        }
    });
    Some(quote! {
        #[automatically_derived]
        impl ::core::default::Default for #name {
            fn default() -> Self {
                Self { #(#values,)* }
            }
        }
    })
}

fn declare(
    field: &Field,
    var: Var,
    value: &TokenStream,
    root: &TokenStream,
) -> Result<TokenStream> {
    let ident = field.ident.as_ref();
    if var.via.is_none() {
        check(&field.ty, &var)?;
    }
    let rust_name = ident.map(|ident| ident.unraw().to_string()).unwrap_or_default();
    let (name, description) = if var.flatten {
        (String::new(), String::new())
    } else {
        let name = var.rename.as_ref().map_or(rust_name, syn::LitStr::value);
        (name, description(&field.attrs))
    };
    let (unit, tunable) = (option(var.unit.as_ref()), var.tunable);
    let unit_of = var.unit_of.iter().map(|(name, unit)| quote!((#name, #unit)));
    let [min, max, nominal] =
        [var.min, var.max, var.nominal].map(|number| option(number.map(|n| quote!((#n) as f64))));
    let place = quote! {
        at.member(&#root::Member {
            name: #name,
            description: #description,
            unit: #unit,
            unit_of: &[#(#unit_of),*],
            min: #min,
            max: #max,
            nominal: #nominal,
            tunable: #tunable,
        })
    };
    Ok(match (var.elements, var.each) {
        (Some(members), _) => quote!(#place.elements(#value, &#members, into);),
        (None, Some(member)) => quote!(#place.each(#value, &#member, into);),
        (None, None) => quote!(#root::Variables::declare(#value, &#place, into);),
    })
}

/// Rejects types whose name shows a mistake.
fn check(ty: &Type, var: &Var) -> Result<()> {
    let innermost = innermost(ty);
    if matches!(innermost, Type::Array(_)) {
        return Err(Error::new_spanned(
            ty,
            "a matrix would be named m[1,2], and a comma breaks CSV headers: use a struct of rows",
        ));
    }
    let Type::Path(path) = innermost else {
        return Err(Error::new_spanned(ty, unsupported("this type")));
    };
    let Some(last) = path.path.segments.last() else {
        return Ok(());
    };
    let name = last.ident.to_string();
    let has_arguments = !last.arguments.is_empty() && name != "Text";
    if NO_SUCH_TYPE.contains(&name.as_str()) || has_arguments {
        return Err(Error::new_spanned(ty, unsupported(&format!("`{name}`"))));
    }
    match var.numeric() {
        Some(attribute) if ["bool", "String", "Text"].contains(&name.as_str()) => {
            Err(Error::new_spanned(
                ty,
                format!("`{attribute}` makes no sense for `{name}`: only numbers have it"),
            ))
        }
        _ => Ok(()),
    }
}

fn innermost(ty: &Type) -> &Type {
    match ty {
        Type::Array(array) => &array.elem,
        other => other,
    }
}

fn unsupported(what: &str) -> String {
    format!(
        "{what} is no kind of FMI variable: use f64, i32, bool, String, Text<N>, an enum deriving \
         Enumeration, a struct deriving Variables, or an array [T; N] of these"
    )
}
