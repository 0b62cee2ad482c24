//! OSP structures: simulators, functions, connections of all kinds, groups, LogConfig.

use std::path::Path;

use cosim::{Algorithm, Overrides, Recording, Run, Snapshot, System, Time};

use crate::formats::{Folder, assert_parts, last};
use crate::models::Model;
use crate::ssd::{assert_near, run};

pub(crate) fn structure(body: &str) -> String {
    format!(
        "<?xml version='1.0' encoding='UTF-8'?>
<OspSystemStructure xmlns='http://opensimulationplatform.com/MSMI/OSPSystemStructure' version='0.1'>
<StartTime>0.0</StartTime>
<EndTime>1.0</EndTime>
<BaseStepSize>0.1</BaseStepSize>
<Algorithm>fixedStep</Algorithm>
{body}
</OspSystemStructure>
"
    )
}

pub(crate) fn simulator(name: &str, source: &Path, values: &str) -> String {
    let source = source.display();
    format!(
        "<Simulator name='{name}' source='{source}'><InitialValues>{values}</InitialValues>\
         </Simulator>\n"
    )
}

fn real(variable: &str, value: f64) -> String {
    format!("<InitialValue variable='{variable}'><Real value='{value}'/></InitialValue>")
}

fn variables(a: (&str, &str), b: (&str, &str)) -> String {
    format!(
        "<VariableConnection><Variable simulator='{}' name='{}'/><Variable simulator='{}' \
         name='{}'/></VariableConnection>\n",
        a.0, a.1, b.0, b.1
    )
}

pub(crate) fn signal(variable: (&str, &str), signal: (&str, &str)) -> String {
    format!(
        "<SignalConnection><Variable simulator='{}' name='{}'/><Signal function='{}' name='{}'/>\
         </SignalConnection>\n",
        variable.0, variable.1, signal.0, signal.1
    )
}

/// Two clocks, one through a linear transformation, summed up for two gains.
pub(crate) fn summed() -> String {
    let (clock, gain) = (Model::Clock.fmu(), Model::Gain.fmu());
    let simulators = [
        simulator("sum_of", &gain, &real("k", 2.0)),
        simulator("a", &clock, ""),
        simulator("b", &clock, ""),
        simulator("scaled", &gain, ""),
    ];
    let connections = [
        signal(("a", "y"), ("s", "in[0]")),
        signal(("b", "y"), ("s", "in[1]")),
        signal(("sum_of", "u"), ("s", "out")),
        signal(("b", "y"), ("l", "in")),
        signal(("scaled", "u"), ("l", "out")),
    ];
    structure(&format!(
        "<Simulators>{}</Simulators><Functions><LinearTransformation name='l' factor='10' \
         offset='-3'/><Sum name='s' inputCount='2'/></Functions><Connections>{}</Connections>",
        simulators.concat(),
        connections.concat()
    ))
}

#[test]
fn functions_take_no_time_in_any_algorithm() {
    let folder = Folder::new();
    let file = folder.write("OspSystemStructure.xml", &summed());
    let system = System::load(&file, &Overrides::new()).unwrap();
    assert_eq!(system.algorithm(), Algorithm::Jacobi);
    let results = run(&system);
    // Jacobi: a gain sees the clocks of the previous step; a sum in between adds no delay.
    let before: Vec<f64> = (0..=10).map(|k| f64::from((k - 1).max(0)) * 0.1).collect();
    let expected: Vec<f64> = before.iter().map(|t| 4.0 * t).collect();
    assert_near(results.column("sum_of.y").unwrap(), &expected);
    let expected: Vec<f64> = before.iter().map(|t| 10.0 * t - 3.0).collect();
    assert_near(results.column("scaled.y").unwrap(), &expected);
    assert!((last(&results, "s.out") - 2.0).abs() < 1e-12);
    let overrides = Overrides::new().algorithm(Algorithm::GaussSeidel);
    let results = run(&System::load(folder.0.path(), &overrides).unwrap());
    assert!((last(&results, "sum_of.y") - 4.0).abs() < 1e-12);
}

#[test]
fn connections_go_from_the_output_to_the_input_however_they_are_written() {
    let folder = Folder::new();
    let simulators = [
        simulator("g", &Model::Gain.fmu(), &real("k", 2.0)),
        simulator("c", &Model::Clock.fmu(), ""),
    ];
    let text = structure(&format!(
        "<Simulators>{}</Simulators><Connections>{}</Connections>",
        simulators.concat(),
        variables(("g", "u"), ("c", "y"))
    ));
    let file = folder.write("x.xml", &text);
    let results = run(&System::load(file, &Overrides::new()).unwrap());
    assert!((last(&results, "g.y") - 1.8).abs() < 1e-12);
}

const GROUPS: &str = "<OspModelDescription version='1.0' \
    xmlns='https://open-simulation-platform.com/OspModelDescription/1.0.0'><VariableGroups>\
    <Generic name='in'><Variable ref='u'/><Variable ref='m'/></Generic>\
    <Generic name='port'><Force name='out'><Variable ref='y'/><Variable ref='n'/></Force></Generic>\
    </VariableGroups></OspModelDescription>";

#[test]
fn groups_of_variables_and_vectors() {
    let folder = Folder::new();
    folder.write("COUNTER_OspModelDescription.xml", GROUPS);
    let reals = GROUPS.replace("<Variable ref='m'/>", "").replace("<Variable ref='n'/>", "");
    folder.write("CLOCK_OspModelDescription.xml", &reals);
    folder.write("GAIN_OspModelDescription.xml", &reals);
    let (counter, clock, gain) = (Model::Counter.fmu(), Model::Clock.fmu(), Model::Gain.fmu());
    let simulators = [
        simulator("a", &counter, ""),
        simulator("b", &counter, ""),
        simulator("c", &clock, ""),
        simulator("g", &gain, ""),
    ];
    let group = |simulator: &str, name: &str| {
        format!("<VariableGroup simulator='{simulator}' name='{name}'/>")
    };
    let vector = |inside: String, signal: &str| {
        format!(
            "<SignalGroupConnection>{inside}<SignalGroup function='v' name='{signal}'/>\
             </SignalGroupConnection>"
        )
    };
    let connections = [
        format!(
            "<VariableGroupConnection>{}{}</VariableGroupConnection>",
            group("b", "in"),
            group("a", "port")
        ),
        vector(group("c", "out"), "in[0]"),
        vector(group("c", "port"), "in[1]"),
        vector(group("g", "in"), "out"),
    ];
    let text = structure(&format!(
        "<Simulators>{}</Simulators><Functions><VectorSum name='v' inputCount='2' \
         dimension='1'/></Functions><Connections>{}</Connections>",
        simulators.concat(),
        connections.concat()
    ));
    let file = folder.write("OspSystemStructure.xml", &text);
    let results = run(&System::load(&file, &Overrides::new()).unwrap());
    assert_eq!(last(&results, "b.n"), 19.0);
    assert!((last(&results, "g.y") - 1.8).abs() < 1e-12);
    for (from, to, parts) in [
        (
            "name='port'/><SignalGroup",
            "name='prot'/><SignalGroup",
            &["E202", "no variable group 'prot'", "'port'?", "OspSystemStructure.xml:11"][..],
        ),
        ("simulator='b' name='in'", "simulator='g' name='in'", &["differ in size"]),
        ("dimension='1'", "dimension='2'", &["vectors of 'v' have 2"]),
        ("inputCount='2'", "inputCount='0'", &["'v' has 0 inputs"]),
        ("inputCount='2'", "inputCount='99999999'", &["must be 1 to"]),
        ("function='v' name='out'", "function='w' name='out'", &["no function 'w'", "'v'?"]),
    ] {
        let wrong = folder.write("wrong.xml", &text.replacen(from, to, 1));
        let error = System::load(&wrong, &Overrides::new()).err().unwrap().to_string();
        assert_parts(&error.replace("wrong.xml", "OspSystemStructure.xml"), parts);
    }
}

#[test]
fn the_log_config_chooses_what_is_recorded() {
    let folder = Folder::new();
    folder.write("OspSystemStructure.xml", &summed());
    folder.write(
        "LogConfig.xml",
        "<simulators xmlns='http://opensimulationplatform.com/LogConfig'>\
         <simulator name='a' decimationFactor='2'><variable name='y'/></simulator>\
         <simulator name='scaled' decimationFactor='4'/></simulators>",
    );
    let results = run(&System::load(folder.0.path(), &Overrides::new()).unwrap());
    let expected = ["a.y", "scaled.u", "scaled.k", "scaled.y", "scaled.second", "scaled.m"];
    assert_eq!(results.names()[..6], expected);
    assert_near(&results.time()[..3], &[0.0, 0.2, 0.4]);
    folder.write(
        "LogConfig.xml",
        "<simulators><simulator name='a'><variable name='yy'/></simulator></simulators>",
    );
    let error = System::load(folder.0.path(), &Overrides::new()).err().unwrap().to_string();
    assert_parts(&error, &["E202", "'yy'", "did you mean 'y'?"]);
}

/// Every n-th step counts from the start of the run, also if the run continues from the middle.
#[test]
fn decimated_results_are_every_nth_row_of_all() {
    let folder = Folder::new();
    folder.write("OspSystemStructure.xml", &summed());
    let every = |factor: u32| {
        let own = format!("<simulator name='a' decimationFactor='{factor}'/>");
        folder.write("LogConfig.xml", &format!("<simulators>{own}</simulators>"));
        System::load(folder.0.path(), &Overrides::new()).unwrap()
    };
    let (all, mut taken) = (run(&every(1)), None);
    assert_eq!(all.time().len(), 11);
    for factor in [2, 3, 4, 10] {
        let some = run(&every(factor));
        let nth = |values: &[f64]| -> Vec<f64> {
            values.iter().copied().step_by(factor as usize).collect()
        };
        assert_eq!(some.time(), nth(all.time()), "{factor}");
        assert_eq!(some.names(), all.names());
        for ((name, values), (_, whole)) in some.columns().zip(all.columns()) {
            assert_eq!(values, nth(whole), "{factor}: {name}");
        }
    }
    let mut keep = |snapshot: Snapshot| {
        taken = Some(snapshot);
        Ok(())
    };
    let at = [Time::from_seconds(0.3)];
    Run::new(&every(3)).snapshots(None, &at, &mut keep).go().unwrap();
    let taken = taken.unwrap();
    for (factor, expected) in [(3, &[0.6, 0.9][..]), (2, &[0.4, 0.6, 0.8, 1.0]), (4, &[0.4, 0.8])] {
        let mut rest = Recording::new();
        Run::new(&every(factor)).observe(&mut rest).resume(&taken).go().unwrap();
        assert_eq!(rest.time(), expected, "{factor}");
        let whole = run(&every(factor));
        for ((name, values), (_, whole)) in rest.columns().zip(whole.columns()) {
            assert!(whole.ends_with(values), "{factor}: {name}");
        }
    }
}

#[test]
fn what_is_wrong_is_reported_all_at_once() {
    let folder = Folder::new();
    let text = summed()
        .replace("name='scaled' source", "name='scaled' stepsize='0.1' source")
        .replace("<Functions>", "<Functions><Product name='p'/>")
        .replace("name='in[1]'", "name='in[2]'")
        .replace("function='l' name='in'", "function='l' name='inn'")
        .replace("simulator='a' name='y'", "simulator='aa' name='y'")
        .replace("fixedStep", "adaptive");
    let file = folder.write("x.xml", &text);
    let error = System::load(file, &Overrides::new()).err().unwrap();
    assert_parts(
        &error.to_string(),
        &[
            "the algorithm 'adaptive' is unknown",
            "<Product> in <Functions> is unknown",
            "'s' has no variable 'in[2]'",
            "has no signal 'inn'",
            "nothing is connected to 'in' of the function 'l'",
            "no component 'aa'",
        ],
    );
    assert!(error.problems().all(|p| p.place().is_some_and(|(_, line)| line.is_some())), "{error}");
}

#[test]
fn functions_need_steps_with_a_common_base() {
    let folder = Folder::new();
    let text = summed().replace("name='b' ", "name='b' stepSize='0.0333331' ");
    assert!(text.contains("0.0333331"));
    let file = folder.write("OspSystemStructure.xml", &text);
    let error = System::load(&file, &Overrides::new()).err().unwrap();
    let line = 1 + text.lines().position(|line| line.contains("0.0333331")).unwrap();
    let place = format!("OspSystemStructure.xml:{line}");
    for part in ["E205", "are inconsistent", "a function changes at each multiple", &place] {
        assert!(error.to_string().contains(part), "{part}: {error}");
    }
}
