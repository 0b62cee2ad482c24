//! Campaigns from the user's point of view: the same rows however they are made, nothing lost,
//! verdicts.

use std::path::Path;
use std::process::Stdio;

use tempfile::TempDir;

use crate::distributed::{cosim, outcome, results};
use crate::models::Model;
use crate::models::Model::{Clock, Counter, Gain, Integrator};
use crate::ssd::Ssd;

mod ended;
mod kept;
mod systems;

/// Clock -> gain -> integrator, of which the gain may be another FMU, in a folder with a campaign.
pub(crate) fn campaign(folder: &Path, more: &str) {
    let ssd = Ssd::new()
        .add("clock", Clock)
        .add("g", Gain)
        .add("x", Integrator)
        .connect("clock.y", "g.u")
        .connect("g.y", "x.u")
        .stop(1.0);
    std::fs::write(folder.join("chain.ssd"), ssd.text()).unwrap();
    std::fs::write(folder.join("noise.toml"), NOISE).unwrap();
    std::fs::write(folder.join("c.toml"), format!("{HEAD}{more}")).unwrap();
}

const NOISE: &str = "[[fault]]\nkind = \"white-noise\"\non = \"g.y\"\nsigma = 0.1\n";

pub(crate) const HEAD: &str = r#"
seed = 3
seeds = 12
[systems]
chain = "chain.ssd"
[scenarios]
clean = ""
noisy = "noise.toml"
[dispersions]
"g.k" = { kind = "normal", mean = 1, sigma = 0.1 }
[figures]
last = { kind = "final", of = "x.y" }
"#;

/// The rows, without the time of the runs.
fn rows(folder: &Path, name: &str) -> Vec<String> {
    let text = String::from_utf8(results(folder, name)).unwrap();
    text.lines().map(|line| line.rsplit_once(',').unwrap().0.to_owned()).collect()
}

fn run(folder: &Path, more: &[&str]) -> (i32, String) {
    outcome(folder, &[&["campaign", "c.toml", "-q", "--csv"][..], more].concat())
}

#[test]
fn rows_are_the_same_however_many_processes_made_them_and_after_kills() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    campaign(folder, "");
    let text = std::fs::read_to_string(folder.join("c.toml")).unwrap();
    std::fs::write(folder.join("c.toml"), text.replace("seeds = 12", "seeds = 400")).unwrap();
    for (jobs, name) in [("1", "one"), ("3", "three")] {
        let (code, stderr) = run(folder, &["--jobs", jobs, "--output-dir", name]);
        assert_eq!(code, 0, "{stderr}");
    }
    let wanted = rows(folder, "one/runs.csv");
    assert_eq!(wanted.len(), 801);
    assert_eq!(rows(folder, "three/runs.csv"), wanted);
    let mut kills = 0;
    loop {
        let mut again =
            cosim(folder, &["campaign", "c.toml", "-q", "--csv", "--output-dir", "killed"]);
        let mut process = again.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        // It is killed when there are some more rows, unless it has finished.
        let log = folder.join("killed/runs.jsonl");
        let length = || std::fs::metadata(&log).map_or(0, |log| log.len());
        let before = length();
        while length() < before + 1500 && process.try_wait().unwrap().is_none() {
            std::thread::yield_now();
        }
        if process.try_wait().unwrap().is_some_and(|status| status.success()) {
            break;
        }
        drop(process.kill());
        if process.wait().unwrap().success() {
            break;
        }
        kills += 1;
    }
    assert!(kills > 3, "{kills}");
    assert_eq!(rows(folder, "killed/runs.csv"), wanted);
}

#[test]
fn a_run_is_made_again_to_the_last_bit_and_a_changed_campaign_is_refused() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    campaign(folder, "");
    assert_eq!(run(folder, &[]).0, 0);
    let (code, stderr) = outcome(folder, &["replay", "c_campaign", "5"]);
    assert_eq!(code, 0, "{stderr}");
    assert!(stderr.contains("the same to the last bit"), "{stderr}");
    // Everything is recorded, including the variable of the figure.
    let recorded = String::from_utf8(results(folder, "run5.csv")).unwrap();
    assert!(recorded.lines().next().unwrap().contains("g.k"), "{recorded}");
    let last = rows(folder, "c_campaign/runs.csv")[6].split(',').nth(7).unwrap().to_owned();
    let place = recorded.lines().next().unwrap().split(',').position(|name| name == "x.y");
    let end = recorded.lines().last().unwrap().split(',').nth(place.unwrap()).unwrap();
    assert_eq!(end.parse::<f64>().unwrap(), last.parse::<f64>().unwrap());
    // More seeds extend the campaign; another distribution makes it another campaign.
    let text = HEAD.replace("seeds = 12", "seeds = 13");
    std::fs::write(folder.join("c.toml"), &text).unwrap();
    let before = rows(folder, "c_campaign/runs.csv");
    assert_eq!(run(folder, &[]).0, 0);
    let after = rows(folder, "c_campaign/runs.csv");
    assert_eq!((after.len(), &after[..25]), (27, &before[..]));
    std::fs::write(folder.join("c.toml"), text.replace("sigma = 0.1", "sigma = 0.2")).unwrap();
    let (code, stderr) = run(folder, &[]);
    assert_eq!(code, 3, "{stderr}");
    assert!(stderr.contains("E211") && stderr.contains("sigma: 0.2"), "{stderr}");
    assert_eq!(rows(folder, "c_campaign/runs.csv"), after);
}

#[test]
fn an_fmu_that_crashes_or_hangs_costs_its_runs_and_no_other() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    for (name, define) in [("aborts", "ABORTS"), ("spins", "SPINS"), ("fatal", "FATAL")] {
        Model::Gain.variant(&folder.join(format!("{name}.fmu")), &[define], |text| text);
    }
    let more = "[replacements]\na_good = {}\nb_aborts = { g = \"aborts.fmu\" }\n\
                c_spins = { g = \"spins.fmu\" }\nd_fatal = { g = \"fatal.fmu\" }\n";
    campaign(folder, more);
    let text = std::fs::read_to_string(folder.join("c.toml")).unwrap();
    let text = text.replace("seeds = 12", "seeds = 2\ntime-limit = 2");
    std::fs::write(folder.join("c.toml"), text).unwrap();
    let (code, stderr) = run(folder, &[]);
    assert_eq!(code, 0, "{stderr}");
    let rows = rows(folder, "c_campaign/runs.csv");
    for (cell, status, reason) in [
        ("a_good", "ok", ""),
        ("b_aborts", "crashed", "SIGABRT"),
        ("c_spins", "timed-out", "longer than 2 s"),
        ("d_fatal", "failed", "returned Fatal"),
    ] {
        let own: Vec<&String> = rows.iter().filter(|row| row.contains(cell)).collect();
        assert_eq!(own.len(), 4, "{rows:#?}");
        let reported =
            |row: &&&String| row.contains(&format!(",{status},")) && row.contains(reason);
        assert_eq!(own.iter().filter(reported).count(), 4, "{own:#?}");
    }
}

#[test]
fn thresholds_decide_the_exit_code() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    let verdict = |bound: &str| format!("[[verdict]]\nfigure = \"last\"\nat-most = {bound}\n");
    for (bound, wanted, word) in
        [("9", 0, "<testcase"), ("0", 1, "<failure"), ("0.45", 4, "<error")]
    {
        campaign(folder, &verdict(bound));
        let (code, stderr) = run(folder, &[]);
        assert_eq!(code, wanted, "{bound}: {stderr}");
        let junit = String::from_utf8(results(folder, "c_campaign/junit.xml")).unwrap();
        assert!(junit.contains(word), "{junit}");
    }
}

/// The value at this position of a JSON file in the results.
fn json(folder: &Path, name: &str, pointer: &str) -> serde_json::Value {
    let json: serde_json::Value = serde_json::from_slice(&results(folder, name)).unwrap();
    json.pointer(pointer).unwrap_or_else(|| panic!("{pointer} of {json:#}")).clone()
}

#[test]
fn a_sequential_campaign_leaves_cells_alone_that_are_decided() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    campaign(folder, "[[verdict]]\nfigure = \"last\"\nat-most = 9\ncells = \"*/clean\"\n");
    let text = std::fs::read_to_string(folder.join("c.toml")).unwrap();
    let text = text.replace("seeds = 12", "seeds = 40\nsequential = true");
    std::fs::write(folder.join("c.toml"), text).unwrap();
    assert_eq!(run(folder, &["--jobs", "3"]).0, 0);
    let rows = rows(folder, "c_campaign/runs.csv");
    let count = |cell: &str| rows.iter().filter(|row| row.contains(cell)).count();
    assert_eq!((count("chain/clean"), count("chain/noisy")), (10, 40));
    // Three checks share the error probability of the verdict.
    assert_eq!(json(folder, "c_campaign/summary.json", "/verdicts/0/answer"), "pass");
}

#[test]
fn what_became_better_or_worse_is_named() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    campaign(folder, "");
    assert_eq!(run(folder, &["--output-dir", "old"]).0, 0);
    let louder = NOISE.replace("white-noise", "bias").replace("sigma = 0.1", "value = 0.2");
    std::fs::write(folder.join("noise.toml"), louder).unwrap();
    assert_eq!(run(folder, &["--output-dir", "new", "--compare", "old"]).0, 0);
    let meaning = |cell| json(folder, "new/changes.json", &format!("/{cell}/meaning"));
    assert_eq!((meaning(0), meaning(1)), ("unclear".into(), "worse".into()));
    assert_eq!(json(folder, "new/changes.json", "/1/pairs"), 12);
}

#[test]
fn figures_of_results_that_exist_are_those_of_the_campaign() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    let more = "grown = { kind = \"max\", of = \"2 * {x.y} - {g.y}\" }\n[keep]\nworst = 1\n\
                figure = \"grown\"\nsample = 1\n";
    campaign(folder, more);
    assert_eq!(run(folder, &[]).0, 0);
    let names = std::fs::read_dir(folder.join("c_campaign/trajectories")).unwrap();
    let names: Vec<_> = names.map(|entry| entry.unwrap().file_name()).collect();
    assert!(names.contains(&"run0.mcap".into()) && (2..=4).contains(&names.len()), "{names:?}");
    for name in ["r.csv", "r.parquet", "r.mcap"] {
        assert_eq!(outcome(folder, &["replay", "c_campaign", "3", "-o", name]).0, 0);
    }
    let score = ["score", "--figures", "c.toml", "r.csv", "r.parquet", "r.mcap"];
    let output = cosim(folder, &[&score[..], &["--format", "json"]].concat()).output().unwrap();
    let reported: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let row = &rows(folder, "c_campaign/runs.csv")[4];
    let wanted: Vec<f64> = row.split(',').skip(7).take(2).map(|v| v.parse().unwrap()).collect();
    for file in 0..3 {
        let figures = &reported[file]["figures"];
        assert_eq!([&figures["grown"], &figures["last"]], [&wanted[0], &wanted[1]].map(|v| v));
    }
    let (code, stderr) = outcome(folder, &["replay", "c_campaign", "3", "-o", "r.parq"]);
    assert_eq!(code, 2, "{stderr}");
    assert!(
        stderr.contains("cannot be written as '.parq'") && stderr.contains(".parquet"),
        "{stderr}"
    );
}

#[test]
fn normalised_errors_are_held_against_chi_square_over_time() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    // The error of x is that of the gain, standard deviation 0.1 times the time squared over two.
    let nees = "nis = { kind = \"nis\", nis = \"x.y\", count = \"clock.y\", dimension = 1, every = 0.5 }\n";
    campaign(folder, nees);
    let text = std::fs::read_to_string(folder.join("c.toml")).unwrap();
    std::fs::write(folder.join("c.toml"), format!("stop-time = 1\n{text}")).unwrap();
    assert_eq!(run(folder, &[]).0, 0);
    let of =
        |place: &str| json(folder, "c_campaign/summary.json", &format!("/consistency/{place}"));
    assert_eq!((of("0/time"), of("1/time"), of("0/runs")), (0.5.into(), 1.0.into(), 12.into()));
    // scipy.stats.chi2.ppf([0.025, 0.975], 12) / 12
    let band = [of("0/band/0"), of("0/band/1")].map(|value| value.as_f64().unwrap());
    assert!(
        (band[0] - 0.366_982_375_6).abs() < 1e-9 && (band[1] - 1.944_722_013_2).abs() < 1e-9,
        "{band:?}"
    );
}

#[test]
fn a_dry_run_says_how_much_there_is_and_mistakes_are_reported_before_it() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    campaign(folder, "");
    let output = cosim(folder, &["campaign", "c.toml", "--dry-run"]).output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(text.contains("2 cells of 12 runs: 24 runs"), "{text}");
    assert!(!folder.join("c_campaign").exists());
    campaign(folder, "wrong = { kind = \"max\", of = \"x.z\" }\n[start-values]\n\"g.kk\" = 1\n");
    let (code, stderr) = run(folder, &[]);
    assert_eq!(code, 3, "{stderr}");
    for part in ["'x' has no variable 'z'", "did you mean 'k'"] {
        assert!(stderr.contains(part), "{part}: {stderr}");
    }
}

#[test]
fn an_interrupted_campaign_says_how_to_go_on() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    campaign(folder, "");
    let text = std::fs::read_to_string(folder.join("c.toml")).unwrap();
    std::fs::write(folder.join("c.toml"), text.replace("seeds = 12", "seeds = 20000")).unwrap();
    let mut command = cosim(folder, &["campaign", "c.toml", "-q", "--csv"]);
    let process = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let log = folder.join("c_campaign/runs.jsonl");
    while std::fs::metadata(&log).map_or(0, |log| log.len()) == 0 {
        std::thread::yield_now();
    }
    crate::distributed::signal(process.id(), "-TERM");
    let output = process.wait_with_output().unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(130), "{stderr}");
    assert!(stderr.contains("of 40000 runs are done"), "{stderr}");
    assert!(rows(folder, "c_campaign/runs.csv").len() > 1);
}
