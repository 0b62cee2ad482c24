//! What is kept of failed runs, and campaigns made in parts.

use tempfile::TempDir;

use super::*;

#[test]
fn what_failed_runs_left_is_kept() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    Model::Gain.variant(&folder.join("fatal.fmu"), &["FATAL"], |text| text);
    campaign(
        folder,
        "[replacements]\ngood = {}\nfatal = { g = \"fatal.fmu\" }\n[keep]\nfailed = true\n",
    );
    let text = std::fs::read_to_string(folder.join("c.toml")).unwrap();
    std::fs::write(folder.join("c.toml"), text.replace("seeds = 12", "seeds = 2")).unwrap();
    let (code, stderr) = run(folder, &[]);
    assert_eq!(code, 0, "{stderr}");
    let failed: Vec<String> = rows(folder, "c_campaign/runs.csv")
        .iter()
        .filter(|row| row.contains(",failed,"))
        .map(|row| format!("run{}.mcap", row.split(',').next().unwrap()))
        .collect();
    let names = std::fs::read_dir(folder.join("c_campaign/trajectories")).unwrap();
    let mut names: Vec<String> =
        names.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    assert_eq!((failed.len(), &names), (4, &failed));
}

#[test]
fn a_run_that_hangs_when_it_is_made_again_is_given_up() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    Model::Gain.variant(&folder.join("spins.fmu"), &["SPINS"], |text| text);
    campaign(folder, "[replacements]\nspins = { g = \"spins.fmu\" }\n[keep]\nfailed = true\n");
    let text = std::fs::read_to_string(folder.join("c.toml")).unwrap();
    let text = text.replace("seeds = 12", "seeds = 1\ntime-limit = 0.5");
    std::fs::write(folder.join("c.toml"), text).unwrap();
    let (_, stderr) = run(folder, &[]);
    assert!(!stderr.contains("trajectory"), "{stderr}");
    // As if one of them had failed in a different way.
    let log = folder.join("c_campaign/runs.jsonl");
    let rows = std::fs::read_to_string(&log).unwrap();
    std::fs::write(&log, rows.replacen("timed-out", "failed", 1)).unwrap();
    let (_, stderr) = run(folder, &[]);
    let reported = "has left no trajectory: it took longer than 1 s";
    assert_eq!(stderr.matches(reported).count(), 1, "{stderr}");
}

#[test]
fn parts_put_together_are_the_whole_and_those_that_do_not_fit_are_refused() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    campaign(folder, "[[verdict]]\nfigure = \"last\"\nat-most = 9\n");
    assert_eq!(run(folder, &["--output-dir", "whole"]).0, 0);
    for part in ["1/3", "2/3", "3/3"] {
        assert_eq!(run(folder, &["--shard", part, "--output-dir", "parts"]).0, 0);
    }
    let merge = |parts: &[&str], to: &str| {
        let options = ["--output-dir", to, "-q", "--csv"];
        outcome(folder, &[&["campaign", "--merge"][..], parts, &options].concat())
    };
    let all = ["parts/shard-1-of-3", "parts/shard-2-of-3", "parts/shard-3-of-3"];
    let (code, stderr) = merge(&all, "merged");
    assert_eq!(code, 0, "{stderr}");
    assert_eq!(rows(folder, "merged/runs.csv"), rows(folder, "whole/runs.csv"));
    assert_eq!(json(folder, "merged/summary.json", "/verdicts/0/answer"), "pass");
    // A missing part is reported.
    let (_, stderr) = merge(&all[..2], "fewer");
    assert!(stderr.contains("8 of 24 runs"), "{stderr}");
    // Two different rows of the same run.
    let log = folder.join(all[0]).join("runs.jsonl");
    let text = std::fs::read_to_string(&log).unwrap();
    let copy = folder.join("copy");
    std::fs::create_dir(&copy).unwrap();
    std::fs::copy(folder.join(all[0]).join("campaign.json"), copy.join("campaign.json")).unwrap();
    let first = |line: &&str| line.contains("\"run\":0,");
    let row = text.lines().find(first).unwrap();
    let other = row.replacen("\"simulated\":\"1\"", "\"simulated\":\"2\"", 1);
    std::fs::write(copy.join("runs.jsonl"), text.replace(row, &other)).unwrap();
    let (code, stderr) = merge(&[all[0], "copy"], "differs");
    assert!(code != 0 && stderr.contains("run 0"), "{stderr}");
    // Results of another campaign.
    let text = std::fs::read_to_string(folder.join("c.toml")).unwrap();
    std::fs::write(folder.join("c.toml"), text.replace("seed = 3", "seed = 4")).unwrap();
    assert_eq!(run(folder, &["--shard", "1/3", "--output-dir", "others"]).0, 0);
    let (code, stderr) = merge(&[all[1], "others/shard-1-of-3"], "mixed");
    assert!(code != 0 && stderr.contains("seed"), "{stderr}");
}
