//! `cosim verify`: the same or not, and where results diverge.

use super::*;

fn verify(folder: &Path, a: &str, b: &str) -> (i32, String) {
    let output = cosim(folder, &["verify", a, b]).output().unwrap();
    let reported = [output.stdout, output.stderr].concat();
    (output.status.code().unwrap_or(-1), String::from_utf8(reported).unwrap())
}

#[test]
fn files_are_the_same_or_part_at_a_named_sample_and_variable() {
    let (file, folder) = (chain(5.0), TempDir::new().unwrap());
    let folder = folder.path();
    let file = file.write();
    let path = file.to_str().unwrap();
    for name in ["a.csv", "a.mcap"] {
        let digests = format!("{name}.digests");
        let arguments = ["run", path, "-o", name, "--digest-file", &digests, "--format", "json"];
        let output = cosim(folder, &arguments).output().unwrap();
        let summary: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        let digest = summary["digest"].as_str().unwrap().to_owned();
        assert_eq!(verify(folder, name, &digest).0, 0);
        let last = std::fs::read_to_string(folder.join(&digests)).unwrap();
        assert!(last.trim_end().ends_with(&digest), "{last}");
    }
    let (code, reported) = verify(folder, "a.csv", "a.mcap");
    assert_eq!(code, 0, "{reported}");
    assert!(reported.contains("the same: 51 samples"), "{reported}");
    let (code, reported) = verify(folder, "a.csv.digests", "a.mcap.digests");
    assert_eq!(code, 0, "{reported}");

    // One value of one sample, in its last bit.
    let text = std::fs::read_to_string(folder.join("a.csv")).unwrap();
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let column = lines[0].split(',').position(|name| name == "x.y").unwrap();
    let mut fields: Vec<String> = lines[31].split(',').map(str::to_owned).collect();
    let value: f64 = fields[column].parse().unwrap();
    fields[column] = format!("{:?}", value.next_up());
    lines[31] = fields.join(",");
    std::fs::write(folder.join("b.csv"), lines.join("\n") + "\n").unwrap();
    let (code, reported) = verify(folder, "b.csv", "a.mcap");
    assert_eq!(code, 1, "{reported}");
    assert!(reported.contains("part at sample 30, t = 3.0: 1 of"), "{reported}");
    assert!(
        reported.contains(&format!("x.y: {:?} and {value:?}, 1 ULP", value.next_up())),
        "{reported}"
    );

    std::fs::write(folder.join("c.csv"), lines[..20].join("\n") + "\n").unwrap();
    let (code, reported) = verify(folder, "a.csv", "c.csv");
    assert_eq!(code, 1, "{reported}");
    assert!(
        reported.contains("c.csv ends at t = 1.8 after 19 samples, a.csv has 51"),
        "{reported}"
    );
    assert_eq!(verify(folder, "a.csv", "missing.csv").0, 3);
    assert_eq!(verify(folder, "a.csv", &"0".repeat(64)).0, 1);
}

#[test]
fn lists_of_digests_part_where_the_runs_do() {
    let (file, folder) = (chain(5.0), TempDir::new().unwrap());
    let folder = folder.path();
    let file = file.write();
    let path = file.to_str().unwrap();
    let bias = r#"{"description": "x", "events": [{"time": 2.0, "model": "g", "variable": "y",
        "action": "bias", "value": 0.5}], "end": 5.0}"#;
    std::fs::write(folder.join("s.json"), bias).unwrap();
    for (name, more) in [("a", &[][..]), ("b", &["--scenario", "s.json"])] {
        let (results, digests) = (format!("{name}.csv"), format!("{name}.digests"));
        let run = ["run", path, "-q", "-o", &results, "--digest-file", &digests];
        let (code, stderr) = outcome(folder, &[&run[..], more].concat());
        assert_eq!(code, 0, "{stderr}");
    }
    let (_, values) = verify(folder, "a.csv", "b.csv");
    let (code, reported) = verify(folder, "a.digests", "b.digests");
    assert_eq!(code, 1, "{reported}");
    let place = reported.split("part at ").nth(1).unwrap().split('\n').next().unwrap();
    assert!(values.contains(place.split(", ").next().unwrap()), "{reported} {values}");
}
