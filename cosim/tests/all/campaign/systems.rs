//! Several systems in one campaign, with different names for the same things.

use tempfile::TempDir;

use super::*;

/// The chain of [`campaign`] with other names, and with a component that only receives.
fn other(folder: &Path, of_system: &str) {
    let ssd = Ssd::new()
        .add("clock", Clock)
        .add("amplifier", Gain)
        .add("sum", Integrator)
        .add("listener", Integrator)
        .connect("clock.y", "amplifier.u")
        .connect("amplifier.y", "sum.u")
        .connect("amplifier.y", "listener.u")
        .stop(1.0);
    campaign(folder, "grown = { kind = \"max\", of = \"2 * {x.y} - {g.y}\", minus = \"g.k\" }\n");
    std::fs::write(folder.join("other.ssd"), ssd.text()).unwrap();
    let text = std::fs::read_to_string(folder.join("c.toml")).unwrap();
    let systems = format!("other = {{ file = \"other.ssd\", {of_system} }}\n[scenarios]");
    let text = text.replace("[scenarios]", &systems);
    let text = format!("stop-when = \"x.y > 0.4\"\n{text}");
    let late = format!("{NOISE}when = \"x.y > 0.1\"\n");
    std::fs::write(folder.join("noise.toml"), late).unwrap();
    std::fs::write(folder.join("c.toml"), text).unwrap();
}

#[test]
fn scenarios_and_figures_are_the_same_in_a_system_with_other_names() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    other(folder, "names = { g = \"amplifier\", x = \"sum\" }, without = [\"listener\"]");
    let (code, stderr) = run(folder, &[]);
    assert_eq!(code, 0, "{stderr}");
    let rows = rows(folder, "c_campaign/runs.csv");
    // Everything that does not identify the run, its system and the recording.
    let reported = |system: &str| -> Vec<String> {
        let own = rows.iter().filter(|row| row.contains(&format!(",{system}/")));
        own.map(|row| {
            let cells: Vec<&str> = row.split(',').skip(3).collect();
            cells[..cells.len() - 1].join(",").replace("sum.y", "x.y")
        })
        .collect()
    };
    assert_eq!(reported("chain").len(), 24);
    assert_eq!(reported("chain"), reported("other"));
    let (code, stderr) = outcome(folder, &["replay", "c_campaign", "3"]);
    assert_eq!(code, 0, "{stderr}");
    let recorded = String::from_utf8(results(folder, "run3.csv")).unwrap();
    let names = recorded.lines().next().unwrap();
    assert!(names.contains("sum.y") && !names.contains("listener"), "{names}");
}

#[test]
fn names_and_components_that_are_not_there_are_reported() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    for (of_system, part) in [
        ("names = { g = \"amplifer\", x = \"sum\" }", "did you mean 'amplifier'?"),
        ("without = [\"listner\"]", "did you mean 'listener'?"),
        ("without = [\"sum\", \"amplifier\"]", "'listener.u' needs it"),
        ("withot = [\"sum\"]", "did you mean 'without'?"),
    ] {
        other(folder, of_system);
        let (code, stderr) = run(folder, &[]);
        assert!(code != 0 && stderr.contains(part), "{part}: {stderr}");
    }
}

#[test]
fn seeds_can_be_counted() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    let ssd = Ssd::new().add("count", Counter).stop(1.0);
    std::fs::write(folder.join("count.ssd"), ssd.text()).unwrap();
    // The counter's output is its steps plus its start value.
    let text = "seeds = 3\nsystems.count = \"count.ssd\"\nfigures.n = { kind = \"final\", of = \"count.n\" }\n\
                [seed-parameters]\n\"count.m\" = { first = 5, step = 2 }\n";
    std::fs::write(folder.join("c.toml"), text).unwrap();
    let (code, stderr) = run(folder, &[]);
    assert_eq!(code, 0, "{stderr}");
    let rows = rows(folder, "c_campaign/runs.csv");
    let last: Vec<&str> = rows[1..].iter().map(|row| row.split(',').nth(6).unwrap()).collect();
    assert_eq!(last, ["15", "17", "19"]);
    std::fs::write(folder.join("c.toml"), text.replace("step =", "stop =")).unwrap();
    let (code, stderr) = run(folder, &[]);
    assert!(code == 3 && stderr.contains("did you mean 'step'?"), "{stderr}");
}
