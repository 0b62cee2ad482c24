//! Reports through the binary: their data, and the handling of bad input.

use std::fmt::Write as _;
use std::path::Path;

use serde_json::Value;
use tempfile::TempDir;

use crate::campaign::{HEAD, campaign};
use crate::distributed::{cosim, outcome, results};

/// The data of a page, which must not contain markup.
fn data(page: &str) -> Value {
    let start = "<script type=\"application/json\" id=\"data\">";
    let (_, rest) = page.split_once(start).expect(page);
    let (data, _) = rest.split_once("</script>").unwrap();
    assert!(!data.contains('<'));
    serde_json::from_str(data).unwrap()
}

/// The data of the report written by this command, and its stderr.
fn report(folder: &Path, arguments: &[&str]) -> (Value, String) {
    let arguments = [&["report"][..], arguments, &["--output-file", "out.html"]].concat();
    let (code, stderr) = outcome(folder, &arguments);
    assert_eq!(code, 0, "{stderr}");
    (data(&String::from_utf8(results(folder, "out.html")).unwrap()), stderr)
}

fn write(folder: &Path, name: &str, text: &str) {
    std::fs::write(folder.join(name), text).unwrap();
}

fn strings(list: &Value) -> Vec<&str> {
    list.as_array().unwrap().iter().map(|text| text.as_str().unwrap()).collect()
}

#[test]
fn a_campaign_is_reported_with_its_worst_and_its_median_run() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    campaign(folder, "[[verdict]]\nfigure = 'last'\nat-most = 100\n");
    let text = std::fs::read_to_string(folder.join("c.toml")).unwrap();
    write(folder, "c.toml", &format!("description = \"Is it <b>good</b>?\"\n{text}"));
    assert_eq!(outcome(folder, &["campaign", "c.toml", "-q"]).0, 0);
    let (reported, stderr) = report(folder, &["c_campaign"]);
    assert!(stderr.contains("the report is in out.html"), "{stderr}");
    assert_eq!(reported["question"], "Is it <b>good</b>?");
    let campaign = &reported["campaign"];
    assert_eq!((&campaign["answer"], &campaign["runs"]), (&"pass".into(), &24.into()));
    assert_eq!(campaign["figures"][0]["what"], "the last x.y");
    let cells = campaign["cells"].as_array().unwrap();
    assert_eq!(cells.len(), 2);
    for cell in cells {
        // All runs are points, and the worst run is the maximum of them.
        let (runs, values) = (&cell["sample"]["run"], &cell["sample"]["figures"][0]);
        assert_eq!(runs.as_array().unwrap().len(), 12);
        let values: Vec<f64> =
            values.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect();
        let worst = (0..12).max_by(|a, b| values[*a].total_cmp(&values[*b])).unwrap();
        let shown = cell["shown"].as_array().unwrap();
        assert_eq!((&shown[0]["why"], &shown[1]["why"]), (&"worst".into(), &"median".into()));
        assert_eq!(shown[0]["run"], runs[worst]);
        assert!(shown[0]["problem"].is_null(), "{shown:?}");
        // The repeated run ends with the figure in its row.
        let trace = &reported["runs"][&shown[0]["run"].to_string()];
        assert_eq!((&trace["start"], &trace["stop"]), (&0.0.into(), &1.0.into()));
        // The gain determines the result.
        let correlation = cell["sensitivity"][0][0].as_f64().unwrap();
        assert!(correlation > 0.5, "{correlation}");
    }
    let noisy = &reported["runs"][&cells[1]["shown"][0]["run"].to_string()];
    assert_eq!(noisy["faults"][0]["label"], "white noise of g.y");
    let (none, _) = report(folder, &["c_campaign", "--runs-per-cell", "0"]);
    assert!(none["runs"].as_object().unwrap().is_empty());
    // The same folder gives the same bytes.
    assert_eq!(report(folder, &["c_campaign"]).0, reported);
    assert!(!folder.join("c_campaign/report.html").exists());
    assert_eq!(outcome(folder, &["report", "c_campaign"]).0, 0);
    assert!(folder.join("c_campaign/report.html").exists());
}

#[test]
fn what_a_folder_lacks_is_named_and_the_rest_is_shown() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    campaign(folder, "");
    assert_eq!(outcome(folder, &["campaign", "c.toml", "-q"]).0, 0);
    // A truncated row, one that is not a row, and one that failed.
    let log = std::fs::read_to_string(folder.join("c_campaign/runs.jsonl")).unwrap();
    let mut lines: Vec<&str> = log.lines().take(20).collect();
    lines.push("{\"run\":\"seven\"}");
    let failed = "{\"run\":23,\"status\":\"crashed\",\"reason\":\"</script><script>alert(1)\",\
        \"inputs\":[\"1\"],\"simulated\":\"\",\"figures\":[],\"digest\":\"\",\"cpu_ms\":\"\"}";
    lines.push(failed);
    let text = lines.join("\n") + "\n{\"run\":21,\"sta";
    write(folder, "c_campaign/runs.jsonl", &text);
    let (reported, stderr) = report(folder, &["c_campaign"]);
    let notes = strings(&reported["notes"]);
    for part in
        ["line 21 of runs.jsonl", "line 23 of runs.jsonl", "3 of 24 runs have not been made yet"]
    {
        assert!(notes.iter().any(|note| note.contains(part)), "{part}: {notes:?}");
        assert!(stderr.contains(part), "{part}: {stderr}");
    }
    assert_eq!(
        (&reported["campaign"]["runs"], &reported["campaign"]["failed"]),
        (&21.into(), &1.into())
    );
    // The manifest is cut short: the states of the runs are left.
    let manifest = folder.join("c_campaign/campaign.json");
    let whole = std::fs::read(&manifest).unwrap();
    std::fs::write(&manifest, &whole[..whole.len() / 2]).unwrap();
    let (reported, stderr) = report(folder, &["c_campaign"]);
    assert!(reported["campaign"].is_null());
    assert!(strings(&reported["notes"])[0].contains("campaign.json"), "{}", reported["notes"]);
    assert!(stderr.contains("only the states of runs are shown"), "{stderr}");
    let table = &reported["sections"][0]["blocks"][0]["value"]["rows"];
    assert_eq!(*table, serde_json::json!([["crashed", "1"], ["ok", "20"]]));
    std::fs::write(&manifest, whole).unwrap();
    // Only the manifest: no run is finished.
    std::fs::remove_file(folder.join("c_campaign/runs.jsonl")).unwrap();
    let (reported, _) = report(folder, &["c_campaign"]);
    assert_eq!(reported["campaign"]["runs"], 0);
    assert!(strings(&reported["notes"])[0].contains("runs.jsonl"), "{}", reported["notes"]);
    assert_eq!(reported["campaign"]["answer"], "none");
}

#[test]
fn folders_with_nothing_to_show_get_a_page_that_says_so() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    campaign(folder, "");
    assert_eq!(outcome(folder, &["campaign", "c.toml", "-q"]).0, 0);
    let said = |name: &str, parts: &[&str]| {
        let (reported, _) = report(folder, &[name]);
        let notes = strings(&reported["notes"]);
        for part in parts {
            assert!(notes.iter().any(|note| note.contains(part)), "{part}: {notes:?}");
        }
        reported
    };
    // A table that was cut short, then one of fewer runs than there are.
    let table = folder.join("c_campaign/runs.parquet");
    let whole = std::fs::read(&table).unwrap();
    std::fs::write(&table, &whole[..whole.len() / 2]).unwrap();
    said("c_campaign", &["runs.parquet cannot be read"]);
    std::fs::write(&table, &whole).unwrap();
    let log = folder.join("c_campaign/runs.jsonl");
    let rows = std::fs::read_to_string(&log).unwrap();
    let fewer: Vec<&str> = rows.lines().take(20).collect();
    std::fs::write(&log, fewer.join("\n") + "\n").unwrap();
    said("c_campaign", &["4 of 24 runs have not been made", "runs.parquet has 24 of 20 runs"]);
    // Without the file that says which campaign it is, there are still the states.
    std::fs::remove_file(folder.join("c_campaign/campaign.json")).unwrap();
    let reported = said("c_campaign", &["only the states of runs are shown", "campaign.json"]);
    assert_eq!(reported["sections"][0]["blocks"][0]["value"]["rows"][0][1], "20");
    std::fs::remove_file(&log).unwrap();
    let reported = said("c_campaign", &["campaign.json", "runs.jsonl cannot be read"]);
    assert_eq!(reported["sections"], serde_json::json!([]));
    std::fs::create_dir_all(folder.join("parts/shard-1-of-2")).unwrap();
    said("parts", &["its shards are not merged"]);
    // The page itself makes an empty folder no other one.
    std::fs::create_dir(folder.join("empty")).unwrap();
    for _ in 0..2 {
        assert_eq!(outcome(folder, &["report", "empty"]).0, 0);
        assert!(folder.join("empty/report.html").exists());
    }
    said("empty", &["campaign.json"]);
}

#[test]
fn errors_over_time_are_those_of_the_runs_and_rows_of_a_list_have_names() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    campaign(
        folder,
        "e = { kind = \"error\", of = \"x.y\", minus = \"g.y\", sigma = \"2 * {g.k}\", every = 0.25 }\n",
    );
    write(folder, "list.csv", "name,x.k,g.k\nslow,1,1\n\"<b>fast</b>\",1,2\n");
    let text = std::fs::read_to_string(folder.join("c.toml")).unwrap();
    let (head, rest) = text.split_once("[dispersions]").unwrap();
    let (_, figures) = rest.split_once("[figures]").unwrap();
    let head = head.replace("seeds = 12", "seeds = 1\nstop-time = 1\nlist = 'list.csv'");
    write(folder, "c.toml", &format!("{head}[figures]{figures}"));
    let (code, stderr) = outcome(folder, &["campaign", "c.toml", "-q", "--csv"]);
    assert_eq!(code, 0, "{stderr}");
    let (reported, _) = report(folder, &["c_campaign"]);
    let cells = reported["campaign"]["cells"].as_array().unwrap();
    let names: Vec<&str> = cells.iter().map(|cell| cell["name"].as_str().unwrap()).collect();
    assert_eq!(
        names,
        [
            "chain/clean/slow",
            "chain/clean/<b>fast</b>",
            "chain/noisy/slow",
            "chain/noisy/<b>fast</b>"
        ]
    );
    assert_eq!(cells[1]["row"], "clean, <b>fast</b>");
    let errors = &cells[1]["errors"][0];
    assert_eq!(errors["t"], serde_json::json!([0.25, 0.5, 0.75, 1]));
    assert_eq!(errors["three_sigma"], serde_json::json!([12, 12, 12, 12]));
    // The only run, recorded.
    let (code, stderr) = outcome(folder, &["replay", "c_campaign", "1"]);
    assert_eq!(code, 0, "{stderr}");
    let recorded = String::from_utf8(results(folder, "run1.csv")).unwrap();
    let rows: Vec<Vec<&str>> = recorded.lines().map(|line| line.split(',').collect()).collect();
    let column = |name: &str| rows[0].iter().position(|known| *known == name).unwrap();
    let number = |row: &[&str], name: &str| row[column(name)].parse::<f64>().unwrap();
    for (place, instant) in [0.25, 0.5, 0.75, 1.0].into_iter().enumerate() {
        let row = rows[1..].iter().rfind(|row| number(row, "time") <= instant + 1e-9).unwrap();
        let error = number(row, "x.y") - number(row, "g.y");
        for quantile in errors["quantiles"].as_array().unwrap() {
            assert!((quantile[place].as_f64().unwrap() - error).abs() < 1e-4 * error.abs());
        }
    }
}

#[test]
fn runs_that_cannot_be_made_again_are_a_line_with_the_reason() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    campaign(folder, "");
    assert_eq!(outcome(folder, &["campaign", "c.toml", "-q"]).0, 0);
    write(folder, "noise.toml", "[[fault]]\nkind = \"bias\"\non = \"g.y\"\nvalue = 1\n");
    let (reported, _) = report(folder, &["c_campaign"]);
    let problem = reported["campaign"]["cells"][0]["shown"][0]["problem"].as_str().unwrap();
    assert!(problem.contains("changed") && problem.contains("scenario noisy"), "{problem}");
    assert!(reported["runs"].as_object().unwrap().is_empty());
    // The file describes another campaign now: the one that was made is shown.
    write(folder, "c.toml", &HEAD.replace("clean", "quiet"));
    let (reported, stderr) = report(folder, &["c_campaign"]);
    assert!(stderr.contains("as it was when its runs were made"), "{stderr}");
    assert!(stderr.contains("quiet"), "{stderr}");
    assert_eq!(reported["campaign"]["cells"][0]["name"], "chain/clean");
}

#[test]
fn a_campaign_is_reported_without_its_file_and_its_list() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    campaign(folder, "");
    write(folder, "list.csv", "g.k\n1\n2\n");
    let (head, figures) =
        (HEAD.split("[dispersions]").next().unwrap(), HEAD.split("[figures]").nth(1));
    let head = head.replace("seeds = 12", "seeds = 3\nlist = 'list.csv'");
    write(folder, "c.toml", &format!("{head}[figures]{}", figures.unwrap()));
    let (code, stderr) = outcome(folder, &["campaign", "c.toml", "-q"]);
    assert_eq!(code, 0, "{stderr}");
    let (before, _) = report(folder, &["c_campaign"]);
    std::fs::rename(folder.join("c.toml"), folder.join("moved.toml")).unwrap();
    std::fs::remove_file(folder.join("list.csv")).unwrap();
    let (after, stderr) = report(folder, &["c_campaign"]);
    assert!(stderr.contains("as it was when its runs were made"), "{stderr}");
    assert!(strings(&after["notes"])[0].contains("c.toml"), "{}", after["notes"]);
    assert_eq!((&after["campaign"], &after["runs"]), (&before["campaign"], &before["runs"]));
}

#[test]
fn folders_and_endings_that_are_no_such_thing_are_refused_with_a_remedy() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    std::fs::create_dir(folder.join("empty")).unwrap();
    std::fs::create_dir_all(folder.join("home/music")).unwrap();
    write(folder, "r.csv", "time,a.pose.x\n0,1\n");
    for (arguments, parts) in [
        (&["home"][..], &["no results of a campaign", "campaign.json"][..]),
        (&["missing"], &["missing"]),
        (&["r.csv", "-o", "x.eps"], &["E001", ".eps", ".html", ".svg", ".png", ".pdf"]),
        (&["r.csv", "-o", "x.png"], &["a picture holds one figure", "--xy"]),
        (&["r.csv", "-o", "x.htlm"], &["did you mean 'html'"]),
        (&["empty", "-o", "x.svg"], &["one figure"]),
        (&["empty", "--truth", "a.pose"], &["--truth applies to the results of one run"]),
        (&["r.csv", "--truth", "a.poze"], &["'a.poze.x'"]),
    ] {
        let (code, stderr) = outcome(folder, &[&["report"], arguments].concat());
        assert_ne!(code, 0, "{arguments:?}");
        parts.iter().for_each(|part| assert!(stderr.contains(part), "{part}: {stderr}"));
    }
    assert!(!folder.join("x.png").exists());
}

#[test]
fn a_figure_is_drawn_as_pixels_and_as_a_page() {
    if !std::path::Path::new("/usr/share/fonts").is_dir() {
        println!("skipped: no font is installed");
        return;
    }
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    write(folder, "r.csv", "time,a.x,a.y\n0,1,0\n1,2,1\n2,1,3\n");
    for name in ["x.svg", "x.png", "x.pdf"] {
        let figure = ["report", "r.csv", "--xy", "Path: a.x, a.y", "-o", name];
        let (code, stderr) = outcome(folder, &figure);
        assert_eq!(code, 0, "{stderr}");
    }
    let read = |name: &str| std::fs::read(folder.join(name)).unwrap();
    let svg = String::from_utf8(read("x.svg")).unwrap();
    let width: f64 =
        svg.split(" width=\"").nth(1).unwrap().split('"').next().unwrap().parse().unwrap();
    // Width of a PNG: at octet 16 of its head.
    let png = read("x.png");
    assert!(png.starts_with(b"\x89PNG"));
    assert_eq!(u32::from_be_bytes(png[16..20].try_into().unwrap()), 2 * width.ceil() as u32);
    // Text stays text: a font is in the page.
    let pdf = read("x.pdf");
    assert!(pdf.starts_with(b"%PDF-") && pdf.windows(9).any(|part| part == b"/FontFile"));
}

/// A run on a circle with an estimate that is accurate to 0.5 m, and a variable that is not a
/// number.
fn circle() -> String {
    let mut text = "time,t.pose.x,t.pose.y,t.pose.z,t.pose.yaw,e.pose.x,e.pose.y,e.pose.yaw,\
        e.sigma.x,e.sigma.y,e.sigma.yaw,e.innovation.fix.x,e.innovation_sigma.fix.x,\
        e.count.fix.rejected,e.nis.fix,<script>alert(1)</script>,odd \"\"\n"
        .replace("odd \"\"", "\"odd \"\", name\"");
    for row in 0..5000 {
        let time = f64::from(row) * 0.1;
        let (y, x) = (time / 50.0).sin_cos();
        let rejected = u8::from(row > 3000);
        _ = writeln!(
            text,
            "{time},{x},{y},20,3.1,{},{y},-3.1,0.5,0.5,0.1,0.2,0.4,{rejected},0.25,NaN,{row}",
            x + 0.25
        );
    }
    text
}

#[test]
fn a_run_has_its_map_errors_and_innovations_with_units() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    write(folder, "run.csv", &circle());
    let scenario = "[[fault]]\nkind = \"drop-out\"\non = \"fix.x\"\nfrom = 30\nfor = 20\n";
    write(folder, "s.toml", scenario);
    let (reported, _) = report(folder, &["run.csv", "--scenario", "s.toml"]);
    let run = &reported["runs"][""];
    let paths: Vec<(&str, &str)> = run["map"]["paths"]
        .as_array()
        .unwrap()
        .iter()
        .map(|path| (path["name"].as_str().unwrap(), path["role"].as_str().unwrap()))
        .collect();
    assert_eq!(paths, [("t.pose", "truth"), ("e.pose", "estimate")]);
    assert_eq!(run["map"]["paths"][1]["ellipses"]["xx"][0], 0.25);
    assert_eq!(
        (&run["faults"][0]["from"], &run["faults"][0]["until"]),
        (&30.0.into(), &50.0.into())
    );
    let plots = run["plots"].as_array().unwrap();
    let plot = |title: &str| {
        let found = plots.iter().find(|plot| plot["title"] == title);
        found.unwrap_or_else(|| {
            panic!("{title}: {:?}", plots.iter().map(|p| &p["title"]).collect::<Vec<_>>())
        })
    };
    let error = plot("e.pose.x: error");
    assert_eq!((&error["unit"], &error["lines"][0]["v"][7]), (&"m".into(), &0.25.into()));
    assert_eq!(error["band"]["v"][7], 1.5);
    // The shortest rotation from 3.1 to -3.1.
    let turned = plot("e.pose.yaw: error");
    let yaw = turned["lines"][0]["v"][0].as_f64().unwrap();
    assert!((yaw - (std::f64::consts::TAU - 6.2).to_degrees()).abs() < 1e-3, "{yaw}");
    assert_eq!(turned["unit"], "deg");
    let innovation = plot("e.innovation.fix.x");
    assert_eq!((&innovation["unit"], &innovation["band"]["v"][0]), (&"m".into(), &0.8.into()));
    let mark = innovation["marks"]["at"][0].as_u64().unwrap() as usize;
    assert_eq!(innovation["t"][mark], 300.1);
    assert_eq!(plot("e.pose: NEES of x and y")["lines"][0]["v"][0], 0.25);
    let high = plot("e.nis.fix: NIS")["limits"]["high"].as_f64().unwrap();
    assert!((high - 5.023_886).abs() < 1e-5, "{high}");
    // No axis has two units; angles are shown in degrees.
    let rows = run["table"].as_array().unwrap();
    let unit = |name: &str| {
        let row = rows.iter().find(|row| row["name"] == name);
        row.map(|row| &row["unit"])
    };
    let signals = run["signals"].as_array().unwrap();
    for (plot, line) in signals
        .iter()
        .flat_map(|plot| plot["lines"].as_array().unwrap().iter().map(move |l| (plot, l)))
    {
        let (section, name) = (plot["section"].as_str().unwrap(), line["name"].as_str().unwrap());
        let name =
            if section == "variables" { name.to_owned() } else { format!("{section}.{name}") };
        assert_eq!(Some(&plot["unit"]), unit(&name), "{name}");
    }
    let degrees = serde_json::Value::from("deg");
    let of_variables = plots.iter().filter_map(|plot| {
        let title = plot["title"].as_str().unwrap();
        let known = unit(title.strip_suffix(": error").unwrap_or(title))?;
        Some((&plot["unit"], if known == "rad" { &degrees } else { known }, title))
    });
    let of_variables: Vec<_> = of_variables.collect();
    assert!(of_variables.len() >= 4, "{of_variables:?}");
    of_variables.iter().for_each(|(plot, known, title)| assert_eq!(plot, known, "{title}"));
    let table: Vec<&str> =
        run["table"].as_array().unwrap().iter().map(|row| row["name"].as_str().unwrap()).collect();
    assert!(table.contains(&"<script>alert(1)</script>"), "{table:?}");
    assert!(table.contains(&"odd \", name"), "{table:?}");
}

#[test]
fn files_of_a_run_are_named_with_their_hashes() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    write(folder, "r.csv", "time,a.pose.x\n0,1\n");
    write(folder, "s.toml", "");
    let (reported, _) = report(folder, &["r.csv", "--scenario", "s.toml"]);
    let provenance = reported["provenance"].as_array().unwrap();
    let of = |term: &str| {
        provenance.iter().find(|entry| entry["term"] == term).unwrap()["text"].as_str().unwrap()
    };
    // sha256sum
    let empty = "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855";
    assert_eq!(of("Scenario"), format!("s.toml, SHA-256 {empty}"));
    assert!(of("Results").starts_with("r.csv, SHA-256 "), "{}", of("Results"));
}

#[test]
fn paths_are_those_that_a_file_declares() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    write(folder, "r.csv", "time,e,n,nav.east,nav.north\n0,1,2,1.5,2\n1,3,4,3.5,4\n");
    let roles = "axes = 'enu'\n[truth]\npose = { x = 'e', y = 'n' }\n\
        [estimates.nav]\npose = { x = 'nav.east', y = 'nav.north' }\n";
    write(folder, "roles.toml", roles);
    let (reported, _) = report(folder, &["r.csv", "--roles", "roles.toml"]);
    let paths = &reported["runs"][""]["map"]["paths"];
    let of = |place: usize| (&paths[place]["name"], &paths[place]["role"], &paths[place]["x"]);
    let north = serde_json::json!([2, 4]);
    assert_eq!(of(0), (&"truth.pose".into(), &"truth".into(), &north));
    assert_eq!(of(1), (&"nav.pose".into(), &"estimate".into(), &north));
    let plots = reported["runs"][""]["plots"].as_array().unwrap();
    let east = plots.iter().find(|plot| plot["title"] == "nav.pose.y: error").unwrap();
    assert_eq!((&east["unit"], &east["lines"][0]["v"][0]), (&"m".into(), &0.5.into()));
    // They are given in one way.
    let both = ["report", "r.csv", "--roles", "roles.toml", "--truth", "truth.pose"];
    assert_eq!(outcome(folder, &both).0, 2);
}

#[test]
fn recordings_that_lack_things_are_shown_as_far_as_they_go() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    write(folder, "bare.csv", "time,a,b\n0,1,2\n1,2,3\n");
    let (reported, _) = report(folder, &["bare.csv"]);
    let run = &reported["runs"][""];
    assert!(strings(&reported["notes"])[0].contains("no truth is recorded"));
    assert!(run["map"].is_null());
    // Their units are not known: each has its own axis.
    assert_eq!(run["signals"].as_array().unwrap().len(), 2);
    write(folder, "nan.csv", "time,a.pose.x,a.pose.y,b\n0,NaN,NaN,NaN\n1,NaN,NaN,NaN\n");
    let (reported, _) = report(folder, &["nan.csv"]);
    assert_eq!(reported["runs"][""]["table"][0]["not_finite"], 2);
    write(folder, "none.csv", "time,a.pose.x,a.pose.y\n");
    let (reported, _) = report(folder, &["none.csv"]);
    assert!(strings(&reported["notes"]).contains(&"no instant is recorded"));
    write(folder, "back.csv", "time,a\n0,1\n2,2\n1,9\nNaN,9\n3,3\n");
    let (reported, _) = report(folder, &["back.csv"]);
    assert!(
        strings(&reported["notes"])[0].starts_with("2 rows are left out"),
        "{}",
        reported["notes"]
    );
    assert_eq!(reported["runs"][""]["signals"][0]["t"], serde_json::json!([0, 2, 3]));
    let plot = &["bare.csv", "--plot", "A: a, c"];
    let (code, stderr) = outcome(folder, &[&["report"], &plot[..]].concat());
    assert!(code != 0 && stderr.contains("'c' was not recorded"), "{stderr}");
}

#[test]
fn ten_thousand_columns_fit() {
    let folder = TempDir::new().unwrap();
    let names: Vec<String> = (0..10_000).map(|i| format!("c{}.value[{i}]", i / 100)).collect();
    let mut text = format!("time,{}\n", names.join(","));
    for row in 0..200 {
        let values: Vec<String> = (0..10_000).map(|i| format!("{}.125", row * i % 97)).collect();
        text += &format!("{row},{}\n", values.join(","));
    }
    write(folder.path(), "wide.csv", &text);
    let output = cosim(folder.path(), &["report", "wide.csv", "-o", "-"]).output().unwrap();
    let page = String::from_utf8(output.stdout).unwrap();
    assert!(page.len() < 5_000_000, "{}", page.len());
    let reported = data(&page);
    let notes = strings(&reported["notes"]);
    assert!(notes.iter().any(|note| note.contains("2000 of")), "{notes:?}");
}
