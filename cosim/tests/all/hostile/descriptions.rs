//! Descriptions of FMUs that are refused, or in which something is reported.

use super::{Workspace, described};
use crate::models::Model;

#[test]
fn xml_that_is_no_description() {
    let workspace = Workspace::new();
    let root = "<fmiModelDescription fmiVersion='2.0'";
    let laughs: String = (1..10)
        .map(|n| format!("<!ENTITY l{n} '{}'>", format!("&l{};", n - 1).repeat(10)))
        .collect();
    let bomb = format!("<!DOCTYPE x [<!ENTITY l0 'ha'>{laughs}]>\n{root}>&l9;</x>");
    let external = "<!DOCTYPE x SYSTEM 'file:///etc/passwd'>\n<x/>";
    let wide: String = (0..100_000).map(|n| format!(" a{n}='1'")).collect();
    for (bytes, parts) in [
        (bomb.as_bytes().to_vec(), &["modelDescription.xml:1", "DTD"][..]),
        (external.into(), &[":1", "DTD"]),
        (format!("{root} guid='&l9;'/>").into(), &[":1", "l9"]),
        ("<a>".repeat(100_000).into(), &[":1", "64 levels"]),
        (format!("{root}{wide}/>").into(), &[":1", "256 attributes"]),
        ("\n<a>".repeat(2_000_001).into(), &["nested too deeply"]),
        (format!("<a>{}", "<b/>".repeat(2_000_001)).into(), &["2000000 elements"]),
        (format!("<{}/>", "a".repeat(1 << 20)).into(), &["a name of 1048576 bytes"]),
        (format!("{root}\nguid='\u{e9}'/>").replace('\u{e9}', "?").into(), &[":1", "UTF-8"]),
    ] {
        let bytes = match parts.last() {
            // A byte of Latin-1 in the second line.
            Some(&"UTF-8") => {
                let mut bytes: Vec<u8> = bytes;
                let at = bytes.iter().position(|&b| b == b'?').unwrap();
                bytes[at] = 0xe9;
                bytes
            }
            _ => bytes,
        };
        let parts: Vec<&str> = parts
            .iter()
            .map(|p| if *p == ":1" && bytes.contains(&0xe9) { ":2" } else { p })
            .collect();
        workspace.refuses(
            "x.fmu",
            &described(bytes),
            &[&["[E103]", "modelDescription.xml"], &parts[..]].concat(),
        );
    }
}

#[test]
fn encodings() {
    let workspace = Workspace::new();
    let description = Model::Gain.description();
    let utf16: Vec<u8> =
        [0xfeff].into_iter().chain(description.encode_utf16()).flat_map(u16::to_le_bytes).collect();
    workspace.refuses("x.fmu", &described(utf16), &["[E103]", "UTF-16"]);
    let declared = |name: &str, text: &str| {
        description.replace("UTF-8", name).replace("modelName=\"GAIN\"", text)
    };
    workspace.refuses(
        "x.fmu",
        &described(declared("windows-1252", "modelName=\"Gerät\"")),
        &["[E103]", ":1", "windows-1252"],
    );
    workspace.refuses("x.fmu", &described(declared("UTF-16", "")), &["[E103]", ":1", "UTF-16"]);
    // ASCII is the same in both.
    let (code, shown) =
        workspace.run("info", "x.fmu", &described(declared("ISO-8859-1", "modelName='g'")));
    assert_eq!(code, 0, "{shown}");
    let marked = [&[0xef, 0xbb, 0xbf], description.as_bytes()].concat();
    assert_eq!(workspace.run("info", "x.fmu", &described(marked)).0, 0);
}

#[test]
fn other_versions_numbers_and_names() {
    let workspace = Workspace::new();
    let description = Model::Gain.description();
    for (from, to, parts) in [
        ("fmiVersion=\"2.0\"", "fmiVersion=\"1.0\"", &[":2", "FMI version 1.0"][..]),
        ("fmiVersion=\"2.0\" ", "fmiVersion=\"3.0\" ", &[":2", "FMI version 3.0", "FMI 2.0"]),
        ("valueReference=\"3\"", "valueReference=\"4294967296\"", &[":12", "4294967296"]),
        ("valueReference=\"3\"", "valueReference=\"-1\"", &[":12", "-1"]),
        ("index=\"3\"", "index=\"18446744073709551616\"", &[":22", "18446744073709551616"]),
        ("numberOfEventIndicators", "x", &[]),
        ("guid=\"{test}\"", "guid=\"{test}\" numberOfEventIndicators=\"-1\"", &[":2", "-1"]),
        ("stopTime=\"1\"", "stopTime=\"one\"", &["stopTime=\"one\""]),
        ("canGetAndSetFMUstate=\"true\"", "canGetAndSetFMUstate=\"yes\"", &[":3", "yes"]),
        ("maxOutputDerivativeOrder", "", &[]),
    ] {
        if description.contains(from) {
            let bytes = described(description.replace(from, to));
            let code = if from.starts_with("fmiVersion") { "[E106]" } else { "[E104]" };
            workspace.refuses("x.fmu", &bytes, &[&[code, "modelDescription.xml"], parts].concat());
        }
    }
}

#[test]
fn what_fmi_does_not_have_is_reported() {
    let workspace = Workspace::new();
    let folder = workspace.folder.path().join("outside");
    std::fs::create_dir(&folder).unwrap();
    let fmu = Model::Gain.variant(&folder.join("x.fmu"), &[], |description| {
        description.replace("causality=\"input\"><Real", "causalty=\"input\"><Real").replace(
            "<DefaultExperiment",
            "<Surprise/><DefaultExperiment xsi:x=\"1\" xmlns:xsi=\"u\"",
        )
    });
    let bytes = std::fs::read(fmu).unwrap();
    std::fs::remove_dir_all(folder).unwrap();
    let (code, shown) = workspace.run("validate", "x.fmu", &bytes);
    assert_eq!(code, 0, "{shown}");
    for part in ["'causalty' of <ScalarVariable>", "'causality'?", "<Surprise>", "xml:9", "xml:7"] {
        assert!(shown.contains(part), "{part} in {shown}");
    }
    assert!(!shown.contains("xsi"), "{shown}");
}

#[test]
fn a_wrong_guid_is_refused_by_the_fmu_and_reported() {
    let workspace = Workspace::new();
    let folder = workspace.folder.path().join("outside");
    std::fs::create_dir(&folder).unwrap();
    let fmu = Model::Gain.variant(&folder.join("x.fmu"), &[], |d| d.replace("{test}", "{other}"));
    let bytes = std::fs::read(fmu).unwrap();
    std::fs::remove_dir_all(folder).unwrap();
    let (code, shown) = workspace.run("simulate -o -", "x.fmu", &bytes);
    // Only running it shows the problem: the library decides.
    assert_eq!(code, 1, "{shown}");
    assert!(shown.contains("returned NULL") && shown.contains("wrong GUID {other}"), "{shown}");
}

#[test]
fn names_too_long_for_a_table() {
    let workspace = Workspace::new();
    let variable = |length: usize| {
        let name = "v".repeat(length);
        let inside = "causality='local'><Real start='1'/>";
        let first =
            format!("<ScalarVariable name='{name}' valueReference='90' {inside}</ScalarVariable>");
        let text = Model::Gain.description();
        described(text.replace("</ModelVariables>", &format!("{first}</ModelVariables>")))
    };
    for length in [65_535, 65_536, 1 << 20] {
        for verb in ["info", "info --format json"] {
            let (code, shown) = workspace.run(verb, "x.fmu", &variable(length));
            assert_eq!(code, 0, "{length} {verb}: {shown}");
        }
    }
}
