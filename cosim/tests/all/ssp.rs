//! All of SSP: nested systems, transformations, bindings, mappings, sources.

use crate::formats::{Folder, assert_parts, component, connection, last, listed, ssd, system};
use crate::models::{Model, pack};

fn clock(name: &str) -> String {
    component(name, &Model::Clock.fmu(), "y:output:Real", "")
}

fn gain(name: &str, extra: &str) -> String {
    component(name, &Model::Gain.fmu(), "u:input:Real y:output:Real k:parameter:Real", extra)
}

fn value(name: &str, value: f64) -> String {
    format!("<ssv:Parameter name='{name}'><ssv:Real value='{value}'/></ssv:Parameter>")
}

fn set(parameters: &str) -> String {
    format!(
        "<ssv:ParameterSet version='1.0' name='p' \
         xmlns:ssv='http://ssp-standard.org/SSP1/SystemStructureParameterValues'>\
         <ssv:Parameters>{parameters}</ssv:Parameters></ssv:ParameterSet>"
    )
}

fn bound(inside: &str) -> String {
    format!("<ssd:ParameterBindings>{inside}</ssd:ParameterBindings>")
}

fn inline(parameters: &str) -> String {
    bound(&format!(
        "<ssd:ParameterBinding><ssd:ParameterValues>{}</ssd:ParameterValues>\
         </ssd:ParameterBinding>",
        set(parameters)
    ))
}

const LINEAR: &str = "<ssc:LinearTransformation factor='3' offset='1'/>";
const OTHER: &str = "<ssc:LinearTransformation factor='2' offset='5'/>";

/// clock -> [ in -> [ in -> gain -> out ] -> out ] -> gain, transformed on every way in.
fn nested() -> String {
    let ports = format!(
        "<ssd:Connectors>{}</ssd:Connectors>",
        listed("in:input:Real out:output:Real slope:parameter:Real")
    );
    let deep = system(
        &gain("g", ""),
        &[
            connection("in", "g.u", LINEAR),
            // Written backwards: start and end do not define the direction.
            connection("out", "g.y", ""),
            connection("slope", "g.k", "<ssc:LinearTransformation factor='10'/>"),
        ]
        .concat(),
    );
    let deep = format!("<ssd:System name='deep'>{ports}{deep}</ssd:System>");
    let inner = system(
        &deep,
        &[
            connection("in", "deep.in", LINEAR),
            connection("deep.out", "out", ""),
            connection("slope", "deep.slope", ""),
        ]
        .concat(),
    );
    let inner = format!(
        "<ssd:System name='inner'>{ports}{}{inner}</ssd:System>",
        inline(&value("slope", 0.2))
    );
    system(
        &[clock("c"), inner, gain("last", "")].concat(),
        &[connection("c.y", "inner.in", OTHER), connection("inner.out", "last.u", "")].concat(),
    )
}

#[test]
fn nested_systems_are_flat_and_transformed_on_every_way_in() {
    let folder = Folder::new();
    let results = folder.run(&ssd(&nested(), ""));
    // 3 (3 (2 t + 5) + 1) + 1 = 18 t + 49, times 0.2 * 10.
    assert!((last(&results, "last.y") - 134.0).abs() < 1e-9);
    assert!((last(&results, "inner.deep.g.y") - 134.0).abs() < 1e-9);
}

#[test]
fn what_is_wrong_with_connectors_of_systems_is_reported_with_its_line() {
    let folder = Folder::new();
    let text = ssd(&nested(), "");
    for (from, to, parts) in [
        (
            "endElement='inner' endConnector='in'",
            "endElement='inner' endConnector='inn'",
            &["E202", "inner has no connector 'inn'", "did you mean 'in'?", "test.ssd:"][..],
        ),
        (
            "startConnector='in' endElement='deep'",
            "startConnector='out' endElement='deep'",
            &["both ends are destinations"],
        ),
        (
            "startElement='deep' startConnector='out' endConnector='out'",
            "startElement='deep' startConnector='out' endElement='deep' endConnector='in'",
            &["'inner.deep.in' has two drivers", "on line"],
        ),
        (
            "<ssd:System name='deep'>",
            "<ssd:System name='deep'><ssd:Wire/>",
            &["<Wire> in <System> is unknown"],
        ),
    ] {
        assert!(text.contains(from), "{from}");
        assert_parts(&folder.error(&text.replacen(from, to, 1)), parts);
    }
}

#[test]
fn a_circle_of_system_connectors_is_refused() {
    let folder = Folder::new();
    let ports = listed("in:input:Real out:output:Real");
    let through = |name: &str| {
        format!(
            "<ssd:System name='{name}'><ssd:Connectors>{ports}</ssd:Connectors><ssd:Connections>\
             {}</ssd:Connections></ssd:System>",
            connection("in", "out", "")
        )
    };
    let connections = [
        connection("a.out", "b.in", ""),
        connection("b.out", "a.in", ""),
        connection("b.out", "g.u", ""),
    ];
    let text = system(&[through("a"), through("b"), gain("g", "")].concat(), &connections.concat());
    assert_parts(&folder.error(&ssd(&text, "")), &["E203", "'g.u' form a cycle"]);
}

#[test]
fn integers_booleans_and_items_are_mapped() {
    let folder = Folder::new();
    let counter = Model::Counter.fmu();
    let ports = "m:input:Integer n:output:Integer odd:input:Boolean even:output:Boolean";
    let (a, b) = (component("a", &counter, ports, ""), component("b", &counter, ports, ""));
    let entry = |from: &str, to: &str| format!("<ssc:MapEntry source='{from}' target='{to}'/>");
    let tens: String = (0..=10).map(|n| entry(&n.to_string(), &(100 + n).to_string())).collect();
    let tens =
        format!("<ssc:IntegerMappingTransformation>{tens}</ssc:IntegerMappingTransformation>");
    let not = format!(
        "<ssc:BooleanMappingTransformation>{}{}</ssc:BooleanMappingTransformation>",
        entry("true", "false"),
        entry("false", "true")
    );
    let connections = |tens: &str, not: &str| {
        [connection("a.n", "b.m", tens), connection("a.even", "b.odd", not)].concat()
    };
    let text = |tens: &str, not: &str| {
        ssd(&system(&[a.clone(), b.clone()].concat(), &connections(tens, not)), "")
    };
    let (plain, mapped) = (folder.run(&text("", "")), folder.run(&text(&tens, &not)));
    assert_eq!(last(&mapped, "b.n"), last(&plain, "b.n") + 100.0);
    assert_eq!(last(&mapped, "b.even"), 1.0 - last(&plain, "b.even"));
    let none = tens.replace(&entry("3", "103"), "");
    let system = folder.load(&text(&none, &not)).unwrap();
    let error = system.run(&mut []).unwrap_err().to_string();
    assert_parts(&error, &["E203", "the mapping of a.n -> b.m has no 3"]);
    assert_parts(
        &folder.error(&text(LINEAR, &not)),
        &["LinearTransformation", "Integer and Integer"],
    );
    assert_parts(&folder.error(&text(&not, &not)), &["BooleanMappingTransformation"]);
}

#[test]
fn bindings_with_prefix_and_mapping_and_their_precedence() {
    let folder = Folder::new();
    folder.write("values.ssv", &set(&[value("slope", 2.0), value("unused", 7.0)].concat()));
    folder.write(
        "names.ssm",
        "<ssm:ParameterMapping version='1.0' \
         xmlns:ssm='http://ssp-standard.org/SSP1/SystemStructureParameterMapping' \
         xmlns:ssc='http://ssp-standard.org/SSP1/SystemStructureCommon'>\
         <ssm:MappingEntry source='p.slope' target='g.k'>\
         <ssc:LinearTransformation factor='5' offset='1'/></ssm:MappingEntry>\
         <ssm:MappingEntry source='p.slpe' target='g.second'/></ssm:ParameterMapping>",
    );
    let own = inline(&value("k", 100.0));
    let elements = system(&[clock("c"), gain("g", &own)].concat(), &connection("c.y", "g.u", ""));
    let binding = "<ssd:ParameterBinding source='values.ssv' prefix='p.'>\
                   <ssd:ParameterMapping source='names.ssm'/></ssd:ParameterBinding>";
    let system = folder.load(&ssd(&[bound(binding), elements.clone()].concat(), "")).unwrap();
    // The system's 5 * 2 + 1 takes precedence over the component's own 100.
    assert_eq!(last(&crate::ssd::run(&system), "g.y"), 11.0);
    assert_parts(&system.warnings().join("\n"), &["names.ssm:1", "'p.slpe'", "'p.slope'?"]);
    // Without the mapping the names are unknown: reported for a file, an error inline.
    let plain = "<ssd:ParameterBinding source='values.ssv' prefix='g.'/>";
    let system = folder.load(&ssd(&[bound(plain), elements.clone()].concat(), "")).unwrap();
    assert_parts(&system.warnings().join("\n"), &["values.ssv:1: 'g.unused' is left out"]);
    let error = folder.error(&ssd(&[inline(&value("g.kk", 1.0)), elements].concat(), ""));
    assert_parts(&error, &["E202", "'kk'", "did you mean 'k'?"]);
}

#[test]
fn descriptions_in_descriptions() {
    let folder = Folder::new();
    let ports =
        format!("<ssd:Connectors>{}</ssd:Connectors>", listed("in:input:Real out:output:Real"));
    let elements = system(
        &gain("g", &inline(&value("k", 4.0))),
        &[connection("in", "g.u", ""), connection("g.y", "out", "")].concat(),
    );
    let inner = ssd(&[ports, elements].concat(), "");
    folder.write("parts/inner.ssd", &inner);
    let gain = std::fs::read(Model::Gain.fmu()).unwrap();
    let packed = inner.replace(&Model::Gain.fmu().display().to_string(), "resources/g.fmu");
    let entries = [("SystemStructure.ssd", packed.into_bytes()), ("resources/g.fmu", gain)];
    pack(&folder.path("inner.ssp"), &entries);
    for (kind, source) in [("definition", "parts/inner.ssd"), ("package", "inner.ssp")] {
        let part = format!(
            "<ssd:Component name='part' type='application/x-ssp-{kind}' source='{source}'/>"
        );
        let text = system(&[clock("c"), part].concat(), &connection("c.y", "part.in", ""));
        assert_eq!(last(&folder.run(&ssd(&text, "")), "part.g.y"), 4.0, "{kind}");
    }
    // A description that contains itself.
    let part = "<ssd:Component name='x' type='application/x-ssp-definition' source='test.ssd'/>";
    assert_parts(
        &folder.error(&ssd(&system(part, ""), "")),
        &["descriptions are nested too deeply"],
    );
}

#[test]
fn the_paths_of_a_package_do_not_leave_it() {
    let folder = Folder::new();
    let outside = folder.path("outside.fmu");
    std::fs::copy(Model::Gain.fmu(), &outside).unwrap();
    let absolute = outside.display().to_string();
    for source in [
        "../outside.fmu",
        "%2e%2e/outside.fmu",
        "resources/../../outside.fmu",
        &absolute,
        &format!("file://{absolute}"),
        "http://example.org/x.fmu",
        "..\\outside.fmu",
    ] {
        let text = ssd(&system(&component("g", std::path::Path::new(source), "", ""), ""), "");
        pack(&folder.path("x.ssp"), &[("SystemStructure.ssd", text.into_bytes())]);
        let error = cosim::System::load(folder.path("x.ssp"), &cosim::Overrides::new());
        let error = error.err().unwrap().to_string();
        assert_parts(&error, &["E208", "x.ssp/SystemStructure.ssd:8", &format!("\"{source}\"")]);
    }
    // The same in a parameter file; on disk the user may refer to any path.
    let binding = bound("<ssd:ParameterBinding source='../values.ssv'/>");
    let text = ssd(&[binding, system(&gain("g", ""), "")].concat(), "");
    pack(&folder.path("x.ssp"), &[("SystemStructure.ssd", text.clone().into_bytes())]);
    let error = cosim::System::load(folder.path("x.ssp"), &cosim::Overrides::new());
    assert_parts(&error.err().unwrap().to_string(), &["E208", "../values.ssv"]);
    folder.write("values.ssv", &set(&value("g.k", 2.0)));
    let file = folder.write("below/test.ssd", &text);
    assert!(cosim::System::load(file, &cosim::Overrides::new()).is_ok());
}

#[test]
fn of_ssp_2_what_fmi_2_has_is_read_and_the_rest_refused() {
    let folder = Folder::new();
    let text = ssd(
        &system(
            &[clock("c"), gain("g", "<ssd:MetaData kind='general' type='text/plain'/>")].concat(),
            &connection("c.y", "g.u", ""),
        ),
        "",
    );
    let text = text.replacen("version='1.0' name", "version='2.0' name", 1);
    let text = text.replace("<ssc:Real/>", "<ssc:Float64/>");
    assert_eq!(last(&folder.run(&text), "g.y"), 1.0);
    for (from, to, part) in [
        ("<ssc:Float64/>", "<ssc:Float32/>", "is listed as <ssc:Float32/>"),
        ("<ssc:Float64/>", "<ssc:Float64/><ssd:Dimension size='3'/>", "arrays are not supported"),
        ("endConnector='u'", "endConnector='u' endIndices='1'", "parts of arrays"),
        ("source=", "implementation='ScheduledExecution' source=", "ScheduledExecution"),
    ] {
        assert_parts(&folder.error(&text.replacen(from, to, 1)), &["test.ssd:", part]);
    }
}

#[test]
fn a_text_is_read_without_any_file() {
    let text =
        ssd(&system(&[clock("c"), gain("g", "")].concat(), &connection("c.y", "g.u", "")), "");
    assert_eq!(cosim::System::read_text(&text).unwrap(), 2);
    let binding = bound("<ssd:ParameterBinding source='/etc/hostname'/>");
    let error = cosim::System::read_text(&ssd(&binding, "")).unwrap_err().to_string();
    assert_parts(&error, &["E208", "text:8", "without a location"]);
    let part = "<ssd:Component name='x' type='application/x-ssp-package' source='/x.ssp'/>";
    let error = cosim::System::read_text(&ssd(&system(part, ""), "")).unwrap_err().to_string();
    assert_parts(&error, &["E208", "without a location"]);
    assert!(cosim::System::read_text("<OspSystemStructure").is_err());
}

#[test]
fn signals_of_a_dictionary_reach_any_depth() {
    let folder = Folder::new();
    let dictionary = "<ssb:SignalDictionary version='1.0' \
        xmlns:ssb='http://ssp-standard.org/SSP1/SystemStructureSignalDictionary' \
        xmlns:ssc='http://ssp-standard.org/SSP1/SystemStructureCommon'>\
        <ssb:DictionaryEntry name='speed'><ssc:Real/></ssb:DictionaryEntry></ssb:SignalDictionary>";
    folder.write("bus.ssb", dictionary);
    let reference = "<ssd:SignalDictionaryReference name='tap' dictionary='bus'/>";
    let inner = system(
        &[&gain("g", ""), reference].concat(),
        // Written backwards: the signal is the source because the gain's input is not.
        &connection("g.u", "tap.speed", LINEAR),
    );
    let inner = format!("<ssd:System name='inner'>{inner}</ssd:System>");
    let text = |dictionary: &str| {
        let elements = [&clock("c"), &inner, reference].concat();
        let system = system(&elements, &connection("c.y", "tap.speed", LINEAR));
        ssd(&format!("{system}<ssd:SignalDictionaries>{dictionary}</ssd:SignalDictionaries>"), "")
    };
    let inline = format!("<ssd:SignalDictionary name='bus'>{dictionary}</ssd:SignalDictionary>");
    let of_file = "<ssd:SignalDictionary name='bus' source='bus.ssb'/>";
    for text in [text(&inline), text(of_file)] {
        // 3 (3 t + 1) + 1 at t = 1.
        assert!((last(&folder.run(&text), "inner.g.y") - 13.0).abs() < 1e-9);
        let wrong = text.replacen("endConnector='speed'", "endConnector='sped'", 1);
        assert_parts(&folder.error(&wrong), &["E202", "no connector 'sped'", "'speed'?"]);
        let wrong = text.replacen("dictionary='bus'", "dictionary='buss'", 1);
        assert_parts(&folder.error(&wrong), &["E202", "no signal dictionary 'buss'", "'bus'?"]);
    }
}

#[test]
fn items_pass_to_integers_and_to_items_of_the_same_number_or_name() {
    let folder = Folder::new();
    let items = |name: &dyn Fn(i32) -> i32| -> String {
        (0..=10).map(|n| format!("<Item name=\"i{}\" value=\"{n}\"/>", name(n))).collect()
    };
    let two = "<Item name=\"Slow\" value=\"1\"/><Item name=\"Fast\" value=\"4\"/>";
    let first = items(&|n| n);
    let source = [(two, first.as_str()), ("<Integer/>", "<Enumeration declaredType=\"Mode\"/>")];
    let enumeration = "<Enumeration declaredType=\"Mode\" start=\"1\"/>";
    let reversed = items(&|n| 10 - n);
    let sink = [(two, reversed.as_str()), ("<Integer start=\"0\"/>", enumeration)];
    let source = folder.fmu(Model::Counter, "source", &source);
    let sink = folder.fmu(Model::Counter, "sink", &sink);
    let counter = Model::Counter.fmu();
    let text = |from: &std::path::Path, to: &std::path::Path, map: &str| {
        let ports = "m:input:Integer n:output:Integer";
        let elements = [component("a", from, ports, ""), component("b", to, ports, "")];
        ssd(&system(&elements.concat(), &connection("a.n", "b.m", map)), "")
    };
    let plain = last(&folder.run(&text(&counter, &counter, "")), "b.n");
    for (from, to) in [(&source, &counter), (&counter, &sink), (&source, &sink)] {
        assert_eq!(last(&folder.run(&text(from, to, "")), "b.n"), plain, "{from:?} {to:?}");
    }
    let map = |target: &str| {
        let entry = |n: i32| format!("<ssc:MapEntry source='i{n}' target='{target}{n}'/>");
        let entries: String = (0..=10).map(entry).collect();
        format!(
            "<ssc:EnumerationMappingTransformation>{entries}</ssc:EnumerationMappingTransformation>"
        )
    };
    // b.n is the number of steps, 10, and a.n; by name, 10 - a.n instead.
    let mapped = last(&folder.run(&text(&source, &sink, &map("i"))), "b.n");
    assert_eq!(mapped, 20.0 - (plain - 10.0));
    assert_parts(&folder.error(&text(&source, &sink, &map("j"))), &["'j0'"]);
    let error = folder.error(&text(&source, &counter, &map("i")));
    assert_parts(&error, &["E203", "EnumerationMappingTransformation"]);
}
