//! What an FMU changes in the process is set back wherever its code is called.

use tempfile::TempDir;

use crate::command::{cosim, text};
use crate::distributed::outcome;
use crate::exits::{PLACES, doing};

/// What is called at these places, up to the end of the run.
const FUNCTIONS: [&str; 5] = [
    "loading the library",
    "fmi2GetVersion",
    "fmi2Instantiate",
    "fmi2ExitInitializationMode",
    "fmi2DoStep",
];

#[test]
fn a_change_is_reported_with_the_function_that_made_it() {
    let folder = TempDir::new().unwrap();
    for (place, function) in PLACES.into_iter().zip(FUNCTIONS) {
        for (change, what) in [
            ("fesetround(FE_UPWARD)", "the floating-point environment"),
            ("chdir(\"/usr\")", "the working directory"),
            ("close(1)", "where a standard stream goes"),
        ] {
            let fmu = doing(folder.path(), place, change);
            let (code, shown) = outcome(folder.path(), &["simulate", &fmu, "-o", "out.csv"]);
            assert_eq!(code, 0, "{place} {change}: {shown}");
            // Where a step changed what is compared only now and then, which one is not known.
            let seldom = place == "step" && !change.starts_with("fe");
            let reported = format!("{} changed {what}", if seldom { "a step" } else { function });
            assert!(shown.contains(&reported), "{place} {change}: {shown}");
        }
    }
}

#[test]
fn the_output_survives_what_an_fmu_closes_while_it_is_unloaded() {
    let folder = TempDir::new().unwrap();
    let fmu = doing(folder.path(), "destructor", "close(1)");
    let output = cosim(folder.path(), &["validate", &fmu]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(text(&output.stdout).contains("valid"), "{}", text(&output.stderr));
}
