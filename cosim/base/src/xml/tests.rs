//! What is accepted, and what is refused with its line.

use super::*;

fn parse_str(text: &str) -> Result<Element> {
    parse(text, Path::new("x.xml"))
}

#[test]
fn tree_with_lines_and_namespaces() {
    let root = parse_str(
        "<?xml version='1.0'?>\n<p:a xmlns:p='urn:x'>\n <p:b\n  c='1 &lt; 2'/>\n t&amp;u</p:a>",
    )
    .unwrap();
    assert_eq!((root.namespace.as_str(), root.name.as_str(), root.line), ("urn:x", "a", 2));
    assert_eq!(root.children[0].line, 3);
    assert_eq!(root.children[0].get("c"), Some("1 < 2"));
    assert_eq!(root.text.trim(), "t&u");
}

#[test]
fn refused() {
    let deep = "<a>".repeat(1000);
    let wide = format!("<a {}/>", (0..1000).map(|i| format!("a{i}='' ")).collect::<String>());
    let cases = [
        "<!DOCTYPE a [<!ENTITY b 'c'>]><a>&b;</a>",
        "<a>&b;</a>",
        "<a b='&c;'/>",
        "<a><b></a>",
        "<a>",
        "",
        "<a/><a/>",
        "<p:a/>",
        "<a b='1' b='2'/>",
        &deep,
        &wide,
    ];
    for case in cases {
        let error = parse_str(case).expect_err(case);
        assert!(error.to_string().contains("x.xml:1"), "{error}");
    }
}

#[test]
fn an_error_names_its_line() {
    let error = parse_str("<a>\n\n <b>\n</a>").unwrap_err().to_string();
    assert!(error.contains("x.xml:4"), "{error}");
}
