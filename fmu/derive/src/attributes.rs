//! Reads doc comments and `#[var(...)]`.

use proc_macro2::{TokenStream, TokenTree};
use quote::quote;
use syn::parse::ParseStream;
use syn::{Attribute, Expr, ExprLit, Lit, LitStr, Result, Token, Type};

/// The contents of `#[var(...)]` on a field.
#[derive(Default)]
pub(crate) struct Var {
    pub(crate) unit: Option<LitStr>,
    pub(crate) rename: Option<LitStr>,
    pub(crate) min: Option<Expr>,
    pub(crate) max: Option<Expr>,
    pub(crate) nominal: Option<Expr>,
    /// Names of the elements of an array: a constant `[Member; N]`.
    pub(crate) elements: Option<TokenStream>,
    /// The member that each element of an array has: a constant `Member`.
    pub(crate) each: Option<TokenStream>,
    /// The type that declares, loads and stores the field, which is converted to and from it.
    pub(crate) via: Option<Type>,
    /// Not a variable: loading gives it its default.
    pub(crate) skip: bool,
    /// Units of members of the field's type, by their names.
    pub(crate) unit_of: Vec<(String, LitStr)>,
    /// The start value; without one it is the `Default` of the field's type.
    pub(crate) start: Option<TokenStream>,
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
                    "unit"
                        | "rename"
                        | "min"
                        | "max"
                        | "nominal"
                        | "start"
                        | "flatten"
                        | "tunable"
                        | "elements"
                        | "each"
                        | "unit_of"
                        | "via"
                        | "skip"
                );
                if !known {
                    return Err(meta.error(format!(
                        "unknown attribute `{name}`: #[var] takes unit, start, min, max, nominal, \
                         rename, flatten, tunable, elements, each, unit_of, via, skip"
                    )));
                }
                match name.as_str() {
                    "flatten" => var.flatten = true,
                    "tunable" => var.tunable = true,
                    "skip" => var.skip = true,
                    "via" => var.via = Some(meta.value()?.parse()?),
                    "unit" => var.unit = Some(meta.value()?.parse()?),
                    "rename" => var.rename = Some(valid_name(meta.value()?.parse()?)?),
                    "min" => var.min = Some(meta.value()?.parse()?),
                    "elements" => var.elements = Some(expression(meta.value()?)?),
                    "each" => var.each = Some(expression(meta.value()?)?),
                    "unit_of" => meta.parse_nested_meta(|member| {
                        let name = member.path.require_ident()?.to_string();
                        var.unit_of.push((name, member.value()?.parse()?));
                        Ok(())
                    })?,
                    "start" => var.start = Some(expression(meta.value()?)?),
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
    let valid = |part: &str| {
        part.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
            && part.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
    };
    if name.value().split('.').all(valid) {
        return Ok(name);
    }
    Err(syn::Error::new(
        name.span(),
        "a variable's name is letters, digits and underscores and does not start with a digit; \
         dots separate the names of groups",
    ))
}

/// Any expression, up to the next comma outside of brackets: the compiler checks it where it is used.
fn expression(input: ParseStream<'_>) -> Result<TokenStream> {
    let mut tokens = TokenStream::new();
    while !input.is_empty() && !input.peek(Token![,]) {
        tokens.extend([input.parse::<TokenTree>()?]);
    }
    if tokens.is_empty() { Err(input.error("expected a value")) } else { Ok(tokens) }
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
