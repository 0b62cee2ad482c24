//! What foreign text does to a terminal: nothing.

use super::{Workspace, described};
use crate::command::text;
use crate::models::Model;

/// Control characters are shown escaped, wherever they come from: a name in an FMU, a scenario, a
/// message.
#[test]
fn no_text_of_a_file_commands_the_terminal() {
    let workspace = Workspace::new();
    let inside = workspace.folder.path().join("a/b");
    let hostile = "&#27;]0;owned&#7;&#x9b;2J\u{202e}&#10;error: forged";
    let description = Model::Gain.description().replace("\"GAIN\"", "'GAIN'");
    // The identifier names the library; only the name of the model is free.
    let description =
        description.replacen("modelName='GAIN'", &format!("modelName='{hostile}'"), 1);
    let description = description.replace("&#27;", "&#x1b;");
    std::fs::write(inside.join("x.fmu"), described(&description)).unwrap();
    std::fs::write(
        inside.join("s.json"),
        "{\"events\": [{\"time\": 0, \"model\": \"\\u001b[31m\"}]}",
    )
    .unwrap();
    let fmu = Model::Gain.fmu();
    let fmu = fmu.to_str().unwrap();
    let talking = Model::Gain.variant(
        &workspace.folder.path().join("talking.fmu"),
        &["ATTACK=SAY(1, \"logAll\", \"a\\033]0;owned\\007\\033[2Jb\\nerror: forged\")"],
        |description| description,
    );
    let talking = talking.to_str().unwrap();
    let commands: [&[&str]; 8] = [
        &["info", "x.fmu"],
        &["info", "x.fmu", "--format", "json"],
        &["validate", "x.fmu"],
        &["simulate", "x.fmu", "-o", "-"],
        &["simulate", fmu, "-o", "-", "--scenario", "s.json"],
        &["simulate", talking, "-o", "talked.csv"],
        &["simulate", talking, "-o", "talked.csv", "--debug-logging"],
        &["simulate", talking, "-o", "talked.csv", "--log-fmi-calls"],
    ];
    for verb in commands {
        let output = crate::command::cosim(&inside, verb);
        let shown = text(&output.stdout) + &text(&output.stderr);
        let verb = verb.join(" ");
        for c in shown.chars() {
            assert!(c == '\n' || !c.is_control() && c != '\u{202e}', "{verb}: {shown:?}");
        }
        assert!(!shown.contains("\nerror: forged"), "{verb}: {shown}");
    }
}
