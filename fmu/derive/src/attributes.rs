//! Reads doc comments and `#[var(...)]`.

use proc_macro2::TokenStream;
use quote::quote;
use syn::{Attribute, Expr, ExprLit, Lit, LitStr, Result};

/// The contents of `#[var(...)]` on a field.
#[derive(Default)]
pub(crate) struct Var {
    pub(crate) unit: Option<LitStr>,
    pub(crate) rename: Option<LitStr>,
    pub(crate) min: Option<Expr>,
    pub(crate) max: Option<Expr>,
    pub(crate) nominal: Option<Expr>,
    /// The start value; without one it is the `Default` of the field's type.
    pub(crate) start: Option<Expr>,
    /// The members count as members of the enclosing struct; the field adds no name and no text.
    pub(crate) flatten: bool,
    /// A parameter that may change while the simulation runs.
    pub(crate) tunable: bool,
}

impl Var {
    pub(crate) fn parse(attributes: &[Attribute]) -> Result<Self> {
        let mut var = Self::default();
        for attribute in attributes.iter().filter(|attribute| attribute.path().is_ident("var")) {
            attribute.parse_nested_meta(|meta| {
                let name = meta.path.get_ident().map(ToString::to_string).unwrap_or_default();
                let known = matches!(
                    name.as_str(),
                    "unit" | "rename" | "min" | "max" | "nominal" | "start" | "flatten" | "tunable"
                );
                if !known {
                    return Err(meta.error(format!(
                        "unknown attribute `{name}`: #[var] takes unit, start, min, max, nominal, \
                         rename, flatten, tunable"
                    )));
                }
                match name.as_str() {
                    "flatten" => var.flatten = true,
                    "tunable" => var.tunable = true,
                    "unit" => var.unit = Some(meta.value()?.parse()?),
                    "rename" => var.rename = Some(valid_name(meta.value()?.parse()?)?),
                    "min" => var.min = Some(meta.value()?.parse()?),
                    "start" => var.start = Some(meta.value()?.parse()?),
                    "max" => var.max = Some(meta.value()?.parse()?),
                    _ => var.nominal = Some(meta.value()?.parse()?),
                }
                Ok(())
            })?;
        }
        Ok(var)
    }

    /// The first attribute that is only for numbers, if one was given.
    pub(crate) fn numeric(&self) -> Option<&'static str> {
        let given = [
            ("min", self.min.is_some()),
            ("max", self.max.is_some()),
            ("nominal", self.nominal.is_some()),
            ("unit", self.unit.is_some()),
        ];
        given.into_iter().find(|(_, is_given)| *is_given).map(|(name, _)| name)
    }
}

/// Structured names are parts joined by dots, and FMPy's CSV reader splits at commas.
fn valid_name(name: LitStr) -> Result<LitStr> {
    let text = name.value();
    let starts_well = text.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_');
    if starts_well && text.chars().all(|c| c.is_ascii_alphanumeric() || c == '_') {
        return Ok(name);
    }
    Err(syn::Error::new(
        name.span(),
        "a variable's name is letters, digits and underscores and does not start with a digit",
    ))
}

/// `Some(value)` or `None` as tokens of the generated code.
pub(crate) fn option<T: quote::ToTokens>(value: Option<T>) -> TokenStream {
    match value {
        Some(value) => quote!(::core::option::Option::Some(#value)),
        None => quote!(::core::option::Option::None),
    }
}

/// The first paragraph of the doc comment in one line, without its final full stop.
pub(crate) fn description(attributes: &[Attribute]) -> String {
    let mut paragraph: Vec<String> = Vec::new();
    for line in attributes.iter().filter_map(doc_line) {
        let line = line.trim();
        if line.is_empty() {
            if paragraph.is_empty() {
                continue;
            } else {
                break;
            }
        }
        paragraph.push(line.to_owned());
    }
    paragraph.join(" ").trim_end_matches('.').to_owned()
}

fn doc_line(attribute: &Attribute) -> Option<String> {
    let pair = attribute.meta.require_name_value().ok().filter(|pair| pair.path.is_ident("doc"))?;
    match &pair.value {
        Expr::Lit(ExprLit { lit: Lit::Str(text), .. }) => Some(text.value()),
        _ => None,
    }
}
