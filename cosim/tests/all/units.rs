//! Units: converted where dimensions agree, refused where they do not, reported where unknown.

use crate::formats::{Folder, assert_parts, component, connection, last, ssd, system};
use crate::models::Model;

const PORTS: &str = "u:input:Real y:output:Real";

#[test]
fn units_of_one_dimension_are_converted() {
    let folder = Folder::new();
    let source = folder.fmu_in(Model::Clock, "degC", "K=\"1\" offset=\"273.15\"");
    let sink = folder.fmu_in(
        Model::Gain,
        "degF",
        "K=\"1\" factor=\"0.5555555555555556\" offset=\"255.3722222222222\"",
    );
    let elements = [component("c", &source, PORTS, ""), component("g", &sink, PORTS, "")].concat();
    let text = |inside: &str, attribute: &str| {
        let connection = connection("c.y", "g.u", inside)
            .replace("<ssd:Connection ", &format!("<ssd:Connection {attribute} "));
        ssd(&system(&elements, &connection), "")
    };
    let system = folder.load(&text("", "")).unwrap();
    // 1 degree Celsius at the end.
    assert!((last(&crate::ssd::run(&system), "g.y") - 33.8).abs() < 1e-9);
    assert_parts(&system.notes().join("\n"), &["converted: c.y -> g.u from degC to degF"]);
    let twice = "<ssc:LinearTransformation factor='2'/>";
    let results = folder.run(&text(twice, ""));
    assert!((last(&results, "g.y") - 67.6).abs() < 1e-9);
    let results = folder.run(&text(twice, "suppressUnitConversion='true'"));
    assert_eq!(last(&results, "g.y"), 2.0);
}

#[test]
fn other_dimensions_are_refused_and_all_of_them_reported() {
    let folder = Folder::new();
    let metre = folder.fmu_in(Model::Clock, "m", "m=\"1\"");
    let newton = folder.fmu_in(Model::Gain, "N", "kg=\"1\" m=\"1\" s=\"-2\"");
    let elements = [
        component("c", &metre, PORTS, ""),
        component("g", &newton, PORTS, ""),
        component("h", &newton, PORTS, ""),
    ];
    let connections = [connection("c.y", "g.u", ""), connection("c.y", "h.u", "")];
    let text = ssd(&system(&elements.concat(), &connections.concat()), "");
    let error = folder.error(&text);
    assert_parts(
        &error,
        &[
            "[E209] c.y -> g.u: m meets N",
            "m and kg.m.s-2",
            "c.y -> h.u",
            "2 problems",
            "test.ssd:",
        ],
    );
    let silenced =
        text.replace("<ssd:Connection ", "<ssd:Connection suppressUnitConversion='true' ");
    assert!(folder.load(&silenced).is_ok());
}

#[test]
fn units_of_connectors_and_values_count() {
    let folder = Folder::new();
    let metre = folder.fmu_in(Model::Gain, "m", "m=\"1\"");
    let units = "<ssd:Units><ssc:Unit name='km'><ssc:BaseUnit m='1' factor='1000'/></ssc:Unit>\
                 <ssc:Unit name='s'><ssc:BaseUnit s='1'/></ssc:Unit></ssd:Units>";
    let clock = component("c", &Model::Clock.fmu(), "y:output:Real:km", "");
    let value = |unit: &str| {
        format!(
            "<ssd:ParameterBindings><ssd:ParameterBinding><ssd:ParameterValues>\
             <ssv:ParameterSet version='1.0' name='p'><ssv:Parameters><ssv:Parameter name='u'>\
             <ssv:Real value='7' unit='{unit}'/></ssv:Parameter></ssv:Parameters>\
             </ssv:ParameterSet></ssd:ParameterValues></ssd:ParameterBinding>\
             </ssd:ParameterBindings>"
        )
    };
    let text = |unit: &str| {
        let elements = [
            clock.clone(),
            component("g", &metre, "u:input:Real y:output:Real", ""),
            component("h", &metre, "u:input:Real", &value(unit)),
        ];
        ssd(&system(&elements.concat(), &connection("c.y", "g.u", "")), units)
    };
    // The clock's own unit has no definition, that of its connector has: km into m.
    let results = folder.run(&text("km"));
    assert_eq!(last(&results, "g.y"), 1000.0);
    assert_eq!(last(&results, "h.y"), 7000.0);
    assert_parts(&folder.error(&text("s")), &["E209", "the value of 'h.u': s meets m"]);
}

#[test]
fn a_unit_at_one_end_is_a_note_and_one_without_definition_a_warning() {
    let folder = Folder::new();
    let without = folder.fmu(Model::Gain, "plain", &[(" unit=\"m\"", "")]);
    let miles = folder.fmu(Model::Gain, "miles", &[("unit=\"m\"", "unit=\"mile\"")]);
    let elements = [
        component("c", &Model::Clock.fmu(), PORTS, ""),
        component("g", &without, PORTS, ""),
        component("h", &miles, PORTS, ""),
    ];
    let connections = [connection("c.y", "g.u", ""), connection("c.y", "h.u", "")];
    let system = folder.load(&ssd(&system(&elements.concat(), &connections.concat()), "")).unwrap();
    assert_parts(&system.notes().join("\n"), &["known at one end only", "c.y -> g.u (m)"]);
    assert_parts(&system.warnings().join("\n"), &["c.y -> h.u joins the units m and mile"]);
}
