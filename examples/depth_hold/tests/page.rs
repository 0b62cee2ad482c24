//! The page about this example shows its complete code and nothing else.

const PAGE: &str = include_str!("../../../docs/write-your-own-component.md");
const COMPONENT: &str = include_str!("../src/lib.rs");

#[test]
fn the_page_shows_the_code() {
    for code in [COMPONENT, include_str!("../src/main.rs")] {
        assert!(PAGE.contains(&format!("```rust\n{code}```\n")), "not on the page:\n{code}");
    }
}

#[test]
fn a_component_is_under_sixty_lines_of_code() {
    let is_code = |line: &&str| !line.trim().is_empty() && !line.trim().starts_with("//");
    let lines = COMPONENT.lines().filter(is_code).count();
    assert!(lines < 60, "{lines} lines");
}
