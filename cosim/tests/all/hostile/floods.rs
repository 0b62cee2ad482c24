//! Small or long files that would take much memory or time.

use super::{Workspace, described, with_variables};
use crate::models::Model;

#[test]
fn floods_of_variables_types_and_dependencies_end_in_time() {
    let workspace = Workspace::new();
    let many = |count: usize, inside: &str| -> String {
        (0..count)
            .map(|n| {
                format!(
                    "<ScalarVariable name='v{n}' valueReference='{n}' {inside}</ScalarVariable>\n"
                )
            })
            .collect()
    };
    // Outputs that the structure does not list.
    let outputs = many(200_000, "causality='output'><Real/>");
    let (code, shown) =
        workspace.run("validate", "outputs.fmu", &described(with_variables(&outputs)));
    assert_eq!(code, 0, "{shown}");
    assert!(shown.contains("no binary for this machine"), "{shown}");
    // One long type of many variables: it is stored once.
    let items: String = (0..50_000).map(|n| format!("<Item name='i{n}' value='{n}'/>")).collect();
    let typed = many(50_000, "><Enumeration declaredType='Mode' start='1'/>");
    let text = with_variables(&typed).replace("<Item name=\"Slow\" value=\"1\"/>", &items);
    let (code, shown) = workspace.run("validate", "types.fmu", &described(text));
    assert_eq!(code, 0, "{shown}");
    // The same name again, at the end of many.
    let twice = format!(
        "{}<ScalarVariable name='v0' valueReference='0'><Real/></ScalarVariable>",
        many(100_000, "><Real/>")
    );
    workspace.refuses("twice.fmu", &described(with_variables(&twice)), &["'v0'", "declared twice"]);
    let list = "1 ".repeat(20_000_001);
    let text = Model::Gain
        .description()
        .replace("dependencies=\"1\"", &format!("dependencies=\"{list}\""));
    workspace.refuses("dependencies.fmu", &described(text), &[":22", "20000000 dependencies"]);
}

/// Found by the fuzz target: a record of 2^64 - 1 bytes, and a string of 4 GiB in a channel.
#[test]
fn results_that_lie_about_their_lengths() {
    let workspace = Workspace::new();
    let length = include_bytes!("record_length.mcap");
    let (code, shown) = workspace.run("verify r.mcap", "r.mcap", length);
    assert_eq!(code, 0, "{shown}");
    let length = include_bytes!("string_length.mcap");
    let (code, shown) = workspace.run("verify r.mcap", "r.mcap", length);
    assert_eq!(code, 3, "{shown}");
    assert!(shown.contains("r.mcap") && shown.contains("a channel is damaged"), "{shown}");
}

/// A tree takes a bounded multiple of its text: a namespace shared by all elements, names that
/// occur a million times, a million attributes. If that is too much, it is refused in time.
#[test]
fn small_files_that_would_become_large_trees() {
    let workspace = Workspace::new();
    let root = "<fmiModelDescription fmiVersion='2.0'";
    let children = "<b/>".repeat(250_000);
    let namespaced =
        format!("{root} xmlns='{}'>{children}</fmiModelDescription>", "n".repeat(60_000));
    let deep = format!("<{0} xmlns:{0}='{0}'>", "p".repeat(1000)).repeat(60);
    let prefixed = format!("{root}>{deep}");
    let attributes: String = (0..250).map(|n| format!(" a{n}=''")).collect();
    let wide = format!("<b{attributes}/>").repeat(60_000);
    let wide = format!("{root}>{wide}</fmiModelDescription>");
    let long = format!("{root} guid='{}'/>", "x".repeat(40 << 20));
    for text in [&namespaced, &prefixed, &wide, &long] {
        let (code, shown) = workspace.run_in(1 << 20, "info", "x.fmu", &described(text));
        assert!(matches!(code, 0 | 3), "{code}: {}: {shown}", &text[..100]);
    }
    let (_, shown) = workspace.run_in(1 << 20, "info", "x.fmu", &described(&wide));
    assert!(shown.contains("[E103]") && shown.contains("takes too much memory"), "{shown}");
    // The same in a system, and in the parameters that it names.
    let system = namespaced.replace("fmiModelDescription", "ssd:SystemStructureDescription");
    let system = system.replacen(
        "xmlns=",
        "xmlns:ssd='http://ssp-standard.org/SSP1/SystemStructureDescription' xmlns=",
        1,
    );
    let (code, shown) = workspace.run_in(1 << 20, "info", "x.ssd", system.as_bytes());
    assert_eq!(code, 3, "{}", &shown[..shown.len().min(2000)]);
}

#[test]
fn a_million_columns_are_compared_in_time() {
    let workspace = Workspace::new();
    let mut table = String::from("time");
    (0..1_000_000).for_each(|n| table.push_str(&format!(",c{n}")));
    table.push_str("\n0");
    table.push_str(&",1".repeat(1_000_000));
    table.push('\n');
    let other = table.replacen("c0,", "d0,", 1).replace("c999999\n", "d999999\n");
    std::fs::write(workspace.folder.path().join("a/b/other.csv"), &other).unwrap();
    let (code, shown) = workspace.run("verify other.csv", "r.csv", table.as_bytes());
    assert_eq!(code, 1, "{shown}");
    assert!(shown.contains("different variables"), "{shown}");
    let (code, shown) = workspace.run("verify r.csv", "r.csv", table.as_bytes());
    assert_eq!(code, 0, "{shown}");
    let header = format!("time{}\n", ",".repeat(2_000_001));
    let (code, shown) = workspace.run("verify r.csv", "r.csv", header.as_bytes());
    assert_eq!(code, 3, "{shown}");
    assert!(shown.contains("2000000 columns"), "{shown}");
}

/// With a million wrong names and a thousand valid ones, the search for suggestions would take
/// hours.
#[test]
fn wrong_names_by_the_thousand_are_reported_in_time() {
    let workspace = Workspace::new();
    let name = |n: usize| format!("{}{n}", "variable_with_a_long_name_".repeat(6));
    let variables: String = (0..2_000)
        .map(|n| {
            let name = name(n);
            format!(
                "<ScalarVariable name='{name}' valueReference='{}'><Real/></ScalarVariable>",
                n + 50
            )
        })
        .collect();
    let description = Model::Gain.description();
    let description =
        description.replace("</ModelVariables>", &format!("{variables}</ModelVariables>"));
    let inside = workspace.folder.path().join("a/b");
    std::fs::write(inside.join("g.fmu"), described(description)).unwrap();
    let connections: String = (0..20_000)
        .map(|n| {
            let wrong = name(n).replace("long", "lang");
            format!(
                "<ssd:Connection startElement='g' startConnector='{wrong}' endElement='g' endConnector='u'/>"
            )
        })
        .collect();
    let system = format!(
        "<ssd:SystemStructureDescription xmlns:ssd='http://ssp-standard.org/SSP1/SystemStructureDescription' \
         version='1.0' name='s'><ssd:System name='s'><ssd:Elements><ssd:Component name='g' \
         type='application/x-fmu-sharedlibrary' source='g.fmu'/></ssd:Elements><ssd:Connections>\
         {connections}</ssd:Connections></ssd:System></ssd:SystemStructureDescription>"
    );
    let (code, shown) = workspace.run("info", "x.ssd", system.as_bytes());
    assert_eq!(code, 3, "{}", &shown[..shown.len().min(2000)]);
    assert!(shown.len() < 1 << 20, "{} bytes are reported", shown.len());
}
