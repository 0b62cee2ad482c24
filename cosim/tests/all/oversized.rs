//! Files that would keep the program busy or fill the memory out of proportion: everything here is
//! read or refused within the limits of `hostile`, which a reader with a quadratic cost exceeds.

use std::fmt::Write;

use cosim::{Overrides, System};
use tempfile::TempDir;

use crate::formats::{connection, ssd, system};
use crate::hostile::{Workspace, described, with_variables};
use crate::models::Model;
use crate::rawzip::{Entry, archive};

/// A GiB of address space, in KiB.
const ONE_GIB: u32 = 1 << 20;

fn texts(numbers: std::ops::Range<usize>, text: impl Fn(usize) -> String) -> String {
    numbers.map(text).collect()
}

/// A workspace with the FMU `g.fmu`: its inputs u, its outputs y, and many more variables.
fn workspace(variables: &str) -> Workspace {
    let workspace = Workspace::new();
    workspace.put("g.fmu", described(with_variables(variables)));
    workspace
}

fn component(name: &str, inside: &str) -> String {
    format!("<ssd:Component name='{name}' source='g.fmu'>{inside}</ssd:Component>\n")
}

fn connector(name: &str, kind: &str) -> String {
    format!("<ssd:Connector name='{name}' kind='{kind}'><ssc:Real/></ssd:Connector>\n")
}

/// A system whose connector p leads to the signal s1 of a dictionary, and so on to g.u; one of these
/// connections is there `times` times.
fn signals(count: usize, times: usize, more: &str) -> String {
    let entries = texts(1..count + 1, |n| {
        format!("<ssb:DictionaryEntry name='s{n}'><ssc:Real/></ssb:DictionaryEntry>\n")
    });
    let hops = texts(1..count, |n| {
        connection(&format!("d.s{n}"), &format!("d.s{}", n + 1), "").repeat(times)
    });
    let elements = format!(
        "{}<ssd:SignalDictionaryReference name='d' dictionary='d'/>",
        component("g", &format!("<ssd:Connectors>{}</ssd:Connectors>", connector("u", "input")))
    );
    let first = connection("p", "d.s1", "");
    ssd(
        &format!(
            "<ssd:Connectors>{}</ssd:Connectors>{}<ssd:SignalDictionaries>\
             <ssd:SignalDictionary name='d'><ssb:SignalDictionary version='1.0' \
             xmlns:ssb='http://ssp-standard.org/SSP1/SystemStructureSignalDictionary'>\
             {entries}</ssb:SignalDictionary></ssd:SignalDictionary></ssd:SignalDictionaries>",
            connector("p", "input"),
            system(&elements, &[&first, &hops, more].concat()),
        ),
        "",
    )
}

#[track_caller]
fn assert_shown((code, shown): (i32, String), wanted: i32, parts: &[&str]) {
    let start: String = shown.chars().take(3000).collect();
    assert_eq!(code, wanted, "{start}");
    for part in parts {
        assert!(shown.contains(part), "{part} in {start}");
    }
    assert!(!shown.contains("panicked"), "{start}");
    assert!(shown.len() < 1 << 20, "{} bytes are reported", shown.len());
}

/// Each connection twice would be 2^40 ways.
#[test]
fn connections_given_twice() {
    let text = signals(40, 2, &connection("d.s40", "g.u", ""));
    let shown = workspace("").run("info", "x.ssd", text.as_bytes());
    assert_shown(shown, 3, &["[E203]", "'dictionary d.s2' has two drivers"]);
}

#[test]
fn a_long_chain_of_signals_is_followed() {
    let text = signals(100_000, 1, &connection("d.s100000", "g.u", ""));
    assert_shown(workspace("").run("info", "x.ssd", text.as_bytes()), 0, &[]);
}

#[test]
fn a_long_cycle_of_signals_is_refused() {
    let ends = connection("d.s50000", "g.u", "") + &connection("d.s50000", "d.s2", "");
    let text = signals(50_000, 1, &ends).replace(&connection("d.s1", "d.s2", ""), "");
    let shown = workspace("").run("info", "x.ssd", text.as_bytes());
    assert_shown(shown, 3, &["[E203]", "'g.u' form a cycle"]);
}

/// Each end of the chain has all conversions on the way: 25 million.
#[test]
fn many_ends_of_a_long_chain() {
    let ends = connection("d.s5000", "g.u", "").repeat(5000);
    let text = signals(5000, 1, &ends);
    let shown = workspace("").run_in(ONE_GIB, "info", "x.ssd", text.as_bytes());
    assert_shown(shown, 3, &["x.ssd:", "the system takes too much memory", "512 MiB"]);
}

fn parameters(count: usize) -> String {
    let all = texts(0..count, |n| {
        format!("<ssv:Parameter name='p{n}'><ssv:Real value='{n}'/></ssv:Parameter>\n")
    });
    format!(
        "<ssv:ParameterSet version='1.0' name='p' \
         xmlns:ssv='http://ssp-standard.org/SSP1/SystemStructureParameterValues'>\
         <ssv:Parameters>{all}</ssv:Parameters></ssv:ParameterSet>"
    )
}

fn mapping(count: usize) -> String {
    let all = texts(0..count, |n| format!("<ssm:MappingEntry source='p{n}' target='q{n}'/>\n"));
    format!(
        "<ssm:ParameterMapping version='1.0' \
         xmlns:ssm='http://ssp-standard.org/SSP1/SystemStructureParameterMapping'>{all}\
         </ssm:ParameterMapping>"
    )
}

fn bound(inside: &str) -> String {
    format!(
        "<ssd:ParameterBindings><ssd:ParameterBinding source='p.ssv'>{inside}\
         </ssd:ParameterBinding></ssd:ParameterBindings>"
    )
}

#[test]
fn a_large_parameter_file_of_many_components() {
    let workspace = workspace("");
    let mapped = bound("<ssd:ParameterMapping source='p.ssm'/>");
    for (count, code, binding) in [
        (100_000, 3, bound("")),
        (100_000, 3, mapped.clone()),
        (100, 0, bound("")),
        (100, 0, mapped),
    ] {
        workspace.put("p.ssv", parameters(count));
        workspace.put("p.ssm", mapping(count));
        let components = texts(0..1000, |n| component(&format!("c{n}"), &binding));
        let text = ssd(&system(&components, ""), "");
        let shown = workspace.run_in(2 * ONE_GIB, "info", "x.ssd", text.as_bytes());
        let parts = if code == 3 { ["takes too much memory"] } else { [MORE] };
        assert_shown(shown, code, &parts);
    }
}

#[test]
fn a_large_dictionary_of_many_systems() {
    let workspace = workspace("");
    let entries = texts(0..100_000, |n| format!("<ssb:DictionaryEntry name='s{n}'/>\n"));
    workspace.put(
        "d.ssb",
        format!(
            "<ssb:SignalDictionary version='1.0' \
             xmlns:ssb='http://ssp-standard.org/SSP1/SystemStructureSignalDictionary'>{entries}\
             </ssb:SignalDictionary>"
        ),
    );
    let systems = texts(0..1000, |n| {
        format!(
            "<ssd:System name='s{n}'><ssd:SignalDictionaries><ssd:SignalDictionary name='d' \
             source='d.ssb'/></ssd:SignalDictionaries></ssd:System>"
        )
    });
    let text = ssd(&system(&systems, ""), "");
    let shown = workspace.run_in(2 * ONE_GIB, "info", "x.ssd", text.as_bytes());
    assert_shown(shown, 3, &["takes too much memory"]);
}

/// The name of each component begins with those of the systems around it.
#[test]
fn a_long_name_of_a_system_with_many_components() {
    let components = texts(0..20_000, |n| component(&format!("c{n}"), ""));
    let name = "x".repeat(1 << 20);
    let inner = format!("<ssd:System name='{name}'>{}</ssd:System>", system(&components, ""));
    let text = ssd(&system(&inner, ""), "");
    let shown = workspace("").run_in(ONE_GIB, "info", "x.ssd", text.as_bytes());
    assert_shown(shown, 3, &["takes too much memory"]);
}

/// A package of 1,000 files that is used 150 times would take 150,000 places.
#[test]
fn a_package_that_is_used_often_is_unpacked_once() {
    let workspace = workspace("");
    let gain = component("g", "");
    let inner = ssd(&system(&gain, ""), "");
    let mut entries = vec![
        Entry::new("SystemStructure.ssd", inner.as_bytes()),
        Entry::new("g.fmu", &described(Model::Gain.description())),
    ];
    entries.extend((0..1000).map(|n| Entry::new(format!("resources/{n}"), b"")));
    workspace.put("inner.ssp", archive(&entries));
    let uses = texts(0..150, |n| {
        format!(
            "<ssd:Component name='c{n}' type='application/x-ssp-package' source='inner.ssp'/>\n"
        )
    });
    let text = ssd(&system(&uses, ""), "");
    assert_shown(workspace.run("info", "x.ssd", text.as_bytes()), 0, &[]);
}

#[test]
fn unknown_attributes_and_elements_by_the_hundred_thousand() {
    let workspace = workspace("");
    let one = component("g", "");
    let connectors = texts(0..200_000, |n| {
        format!("<ssd:Connector name='c{n}' kind='input' kindd='x'><ssc:Real/></ssd:Connector>\n")
    });
    let listed = format!("<ssd:Connectors>{connectors}</ssd:Connectors>");
    let text = ssd(&(listed + &system(&one, "")), "");
    let shown = workspace.run("info", "x.ssd", text.as_bytes());
    assert_shown(shown, 0, &["'kindd' of <Connector>", MORE]);
    let wires = "<ssd:Wire/>\n".repeat(200_000);
    let text = ssd(&system(&one, &wires), "");
    let shown = workspace.run("info", "x.ssd", text.as_bytes());
    assert_shown(shown, 3, &["<Wire> among connections", "200000 problems", "the first 100"]);
}

/// A hundred warnings are shown of a thousand and their number.
const MORE: &str = "and 901 more";

fn variables(count: usize) -> String {
    texts(0..count, |n| {
        let (input, output) = (2 * n + 100, 2 * n + 101);
        format!(
            "<ScalarVariable name='i{n}' valueReference='{input}' causality='input'>\
             <Real start='0'/></ScalarVariable>\n\
             <ScalarVariable name='o{n}' valueReference='{output}' causality='output'><Real/>\
             </ScalarVariable>\n"
        )
    })
}

/// The structure lists what these outputs depend on: nothing.
fn with_outputs(count: usize) -> Vec<u8> {
    let outputs = texts(0..count, |n| format!("<Unknown index='{}' dependencies=''/>", 2 * n + 2));
    let shift = |text: String| {
        // The variables come before the model's own.
        let index = |n: usize| format!("index=\"{n}\"");
        text.replace(&index(3), &index(2 * count + 3)).replace("dependencies=\"1\"", "")
    };
    let text = shift(with_variables(&variables(count)));
    let text = text.replace("<Outputs>", &format!("<Outputs>{outputs}"));
    described(text)
}

#[test]
fn a_hundred_thousand_connectors_connections_parameters_and_entries() {
    const COUNT: usize = 100_000;
    let workspace = Workspace::new();
    workspace.put("g.fmu", with_outputs(COUNT));
    let set = parameters(COUNT);
    let map = mapping(COUNT).replace("target='q", "target='i");
    workspace.put("p.ssv", set);
    workspace.put("p.ssm", map);
    let listed = texts(0..COUNT, |n| {
        connector(&format!("i{n}"), "input") + &connector(&format!("o{n}"), "output")
    });
    let listed = format!("<ssd:Connectors>{listed}</ssd:Connectors>");
    let binding = bound("<ssd:ParameterMapping source='p.ssm'/>");
    let components = component("a", &listed) + &component("b", &(listed + &binding));
    let wires = texts(0..COUNT, |n| connection(&format!("a.o{n}"), &format!("b.i{n}"), ""));
    let text = ssd(&system(&components, &wires), "");
    assert_shown(workspace.run("info", "x.ssd", text.as_bytes()), 0, &[]);
    // Every input has two drivers.
    let text = ssd(&system(&components, &wires.repeat(2)), "");
    let shown = workspace.run("info", "x.ssd", text.as_bytes());
    assert_shown(shown, 3, &["'b.i0' has two drivers", "100000 problems"]);
}

#[test]
fn fifty_thousand_components() {
    let components = texts(0..50_000, |n| component(&format!("c{n}"), ""));
    let chain = texts(1..50_000, |n| connection(&format!("c{}.y", n - 1), &format!("c{n}.u"), ""));
    let connectors = connector("u", "input") + &connector("y", "output");
    let listed = format!("'g.fmu'><ssd:Connectors>{connectors}</ssd:Connectors>");
    let components = components.replace("'g.fmu'>", &listed);
    let text = ssd(&system(&components, &chain), "");
    assert_shown(workspace("").run("info", "x.ssd", text.as_bytes()), 0, &[]);
}

fn osp(functions: &str, connections: &str) -> String {
    format!(
        "<OspSystemStructure version='0.1' \
         xmlns='http://opensimulationplatform.com/MSMI/OSPSystemStructure'>\
         <StartTime>0</StartTime><EndTime>1</EndTime><BaseStepSize>0.1</BaseStepSize><Simulators>\
         <Simulator name='a' source='g.fmu'/><Simulator name='b' source='g.fmu'/></Simulators>\
         <Functions>{functions}</Functions><Connections>{connections}</Connections>\
         </OspSystemStructure>"
    )
}

fn of_signal(function: &str, signal: &str, simulator: &str, variable: &str) -> String {
    format!(
        "<SignalConnection><Variable simulator='{simulator}' name='{variable}'/>\
         <Signal function='{function}' name='{signal}'/></SignalConnection>\n"
    )
}

#[test]
fn functions_and_their_connections_by_the_ten_thousand() {
    const COUNT: usize = 50_000;
    let workspace = Workspace::new();
    workspace.put("g.fmu", with_outputs(COUNT));
    let functions = texts(0..COUNT, |n| {
        format!(
            "<LinearTransformation name='l{n}' factor='2' offset='0'/>\n\
             <Sum name='s{n}' inputCount='1'/>\n"
        )
    });
    let connections = texts(0..COUNT, |n| {
        let (l, s, o, i) = (format!("l{n}"), format!("s{n}"), format!("o{n}"), format!("i{n}"));
        [
            of_signal(&l, "in", "a", &o),
            of_signal(&l, "out", "b", &i),
            of_signal(&s, "in[0]", "a", &o),
        ]
        .concat()
    });
    let log =
        texts(0..COUNT, |n| format!("<simulator name='a'><variable name='o{n}'/></simulator>\n"));
    workspace.put(
        "LogConfig.xml",
        format!(
            "<simulators xmlns='http://opensimulationplatform.com/LogConfig'>{log}</simulators>"
        ),
    );
    let text = osp(&functions, &connections);
    let shown = workspace.run("info", "OspSystemStructure.xml", text.as_bytes());
    assert_shown(shown, 0, &[]);
    // All of them without a source.
    let out = texts(0..COUNT, |n| of_signal(&format!("l{n}"), "out", "b", &format!("i{n}")));
    let text = osp(&functions, &out);
    let shown = workspace.run("info", "OspSystemStructure.xml", text.as_bytes());
    assert_shown(shown, 3, &["nothing is connected to 'in'", "50000 problems"]);
}

/// Groups in groups, connected many times: 10,000 times 10,000 connections.
#[test]
fn large_groups_that_are_connected_often() {
    let workspace = workspace("");
    let refs = texts(0..10_000, |n| format!("<Variable ref='v{n}'/>"));
    let (open, close) =
        (texts(0..40, |n| format!("<Generic name='g{n}'>")), "</Generic>".repeat(40));
    workspace.put(
        "GAIN_OspModelDescription.xml",
        format!(
            "<OspModelDescription version='1.0' \
             xmlns='https://open-simulation-platform.com/OspModelDescription/1.0.0'>\
             <VariableGroups>{open}{refs}{close}</VariableGroups></OspModelDescription>"
        ),
    );
    let one = "<VariableGroupConnection><VariableGroup simulator='a' name='g0'/>\
               <VariableGroup simulator='b' name='g0'/></VariableGroupConnection>\n";
    let text = osp("", &one.repeat(10_000));
    let shown = workspace.run_in(2 * ONE_GIB, "info", "OspSystemStructure.xml", text.as_bytes());
    assert_shown(shown, 3, &["takes too much memory"]);
}

/// A description declares 10,000 ports in a few bytes.
#[test]
fn many_large_sums() {
    let sums = texts(0..20_000, |n| format!("<Sum name='s{n}' inputCount='10000'/>\n"));
    let shown = workspace("").run_in(
        2 * ONE_GIB,
        "info",
        "OspSystemStructure.xml",
        osp(&sums, "").as_bytes(),
    );
    assert_shown(shown, 3, &["takes too much memory"]);
}

/// Twenty million equal numbers, which take some kilobytes in the file.
#[test]
fn results_of_many_equal_values_in_a_short_file() {
    use parquet::data_type::DoubleType;
    use parquet::file::writer::SerializedFileWriter;
    use parquet::schema::parser::parse_message_type;
    let file = |groups: usize, rows: usize| {
        let schema = parse_message_type("message table { required double time; }").unwrap();
        let mut bytes = Vec::new();
        let mut writer =
            SerializedFileWriter::new(&mut bytes, schema.into(), Default::default()).unwrap();
        for _ in 0..groups {
            let mut group = writer.next_row_group().unwrap();
            let mut column = group.next_column().unwrap().unwrap();
            column.typed::<DoubleType>().write_batch(&vec![0.5; rows], None, None).unwrap();
            column.close().unwrap();
            group.close().unwrap();
        }
        writer.close().unwrap();
        bytes
    };
    let workspace = Workspace::new();
    let bomb = file(20, 1 << 20);
    assert!(bomb.len() < 1 << 16, "{}", bomb.len());
    let shown = workspace.run_in(ONE_GIB, "verify r.parquet", "r.parquet", &bomb);
    assert_shown(shown, 3, &["r.parquet", "20971520 rows of 1 columns"]);
    let folder = TempDir::new().unwrap();
    let small = folder.path().join("small.parquet");
    std::fs::write(&small, file(1, 1 << 20)).unwrap();
    assert_eq!(cosim::observe::read(&small).unwrap().time().len(), 1 << 20);
}

/// Many patterns that begin with text are compared only with what may match them.
#[test]
fn a_pattern_for_each_of_many_components() {
    let components = texts(0..10_000, |n| component(&format!("c{n}"), ""));
    let mut records = String::new();
    (0..10_000).for_each(|n| write!(records, "<cosim:Record variable='c{n}.*'/>").unwrap());
    let annotation = format!(
        "<ssd:Annotations xmlns:cosim='urn:cosim:1'><ssc:Annotation type='cosim'><cosim:Master>\
         {records}</cosim:Master></ssc:Annotation></ssd:Annotations>"
    );
    let workspace = workspace("");
    let text = ssd(&system(&components, ""), &annotation);
    assert_shown(workspace.run("info", "x.ssd", text.as_bytes()), 0, &[]);
    let text = text.replace(".*'/>", "*x*x*x'/>").replace("variable='c", "variable='*c");
    let shown = workspace.run("info", "x.ssd", text.as_bytes());
    assert_shown(shown, 2, &["too many patterns"]);
}

/// The readers of one process forget what failed: files may be corrected.
#[test]
fn an_fmu_that_could_not_be_opened_is_opened_when_it_is_corrected() {
    let folder = TempDir::new().unwrap();
    let (file, fmu) = (folder.path().join("x.ssd"), folder.path().join("g.fmu"));
    std::fs::write(&fmu, described(Model::Gain.description())).unwrap();
    std::fs::write(&file, ssd(&system(&component("g", ""), ""), "")).unwrap();
    let system = System::load(&file, &Overrides::new()).unwrap();
    let other = folder.path().join("other.fmu");
    std::fs::write(&other, b"no archive").unwrap();
    let replaced = Overrides::new().replace("g", &other);
    assert!(system.with(&replaced).is_err());
    std::fs::copy(&fmu, &other).unwrap();
    assert!(system.with(&replaced).is_ok());
}
