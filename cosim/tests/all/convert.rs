//! Written systems read back as the same system, in every format.

use std::fs::File;
use std::path::Path;

use cosim::fmi::Value;
use cosim::system::Connection;
use cosim::{Algorithm, Overrides, System};
use proptest::prelude::*;

use crate::formats::{Folder, assert_parts, component, connection, ssd, system};
use crate::models::Model;
use crate::ssd::{Ssd, run};

/// A component: name, model, step, start values.
type Seen = (String, String, f64, Vec<(usize, Value)>);

/// Everything in a system that can be compared.
#[derive(Debug, PartialEq)]
struct Outline {
    components: Vec<Seen>,
    connections: Vec<Connection>,
    columns: Vec<String>,
    experiment: [f64; 3],
    algorithm: Algorithm,
}

fn outline(system: &System) -> Outline {
    let components = system.components().iter().map(|c| {
        let model = c.model.description().map_or("", |d| &d.model_name).to_owned();
        (c.name.clone(), model, c.step.seconds(), c.start_values.clone())
    });
    let experiment = [system.start_time(), system.stop_time(), system.output_interval().rounded()];
    Outline {
        components: components.collect(),
        connections: system.connections().to_vec(),
        columns: system.columns().iter().map(|c| c.name.clone()).collect(),
        experiment: experiment.map(cosim::Time::seconds),
        algorithm: system.algorithm(),
    }
}

fn again(system: &System, path: &Path) -> Outline {
    system.write(path).unwrap();
    outline(&System::load(path, &Overrides::new()).unwrap())
}

const MODELS: [Model; 4] = [Model::Gain, Model::Integrator, Model::Counter, Model::Affine];

/// A component: its model, start values of k and second, and its step in tenths.
type Part = (usize, f64, Option<f64>, u8);

/// A connection: source, sink, and a transformation.
type Link = (prop::sample::Index, prop::sample::Index, Option<(f64, f64)>);

fn text(parts: &[Part], links: &[Link], algorithm: &str) -> String {
    let ports = "u:input:Real y:output:Real m:input:Integer n:output:Integer";
    let components = parts.iter().enumerate().map(|(number, (model, k, second, step))| {
        let values = [("k", Some(*k)), ("second", *second)];
        let values = values.iter().filter_map(|(name, value)| Some((name, (*value)?)));
        let values: String = values
            .map(|(name, v)| {
                format!("<ssv:Parameter name='{name}'><ssv:Real value='{v:?}'/></ssv:Parameter>")
            })
            .collect();
        let extra = format!(
            "<ssd:ParameterBindings><ssd:ParameterBinding><ssd:ParameterValues>\
             <ssv:ParameterSet version='1.0' name='p'><ssv:Parameters>{values}</ssv:Parameters>\
             </ssv:ParameterSet></ssd:ParameterValues></ssd:ParameterBinding>\
             </ssd:ParameterBindings><ssd:Annotations><ssc:Annotation type='cosim'>\
             <cosim:Component xmlns:cosim='urn:cosim:1' stepSize='{}'/></ssc:Annotation>\
             </ssd:Annotations>",
            f64::from(*step) / 10.0
        );
        component(&format!("c{number}.&lt;ü&gt; x"), &MODELS[*model].fmu(), ports, &extra)
    });
    let mut driven = Vec::new();
    let connections = links.iter().map(|(from, to, linear)| {
        let (from, to) = (from.index(parts.len()), to.index(parts.len()));
        if driven.contains(&to) {
            return String::new();
        }
        driven.push(to);
        let inside = linear.map_or(String::new(), |(factor, offset)| {
            format!("<ssc:LinearTransformation factor='{factor:?}' offset='{offset:?}'/>")
        });
        let name = |n: usize| format!("c{n}.&lt;ü&gt; x");
        connection(&format!("{}.y", name(from)), &format!("{}.u", name(to)), &inside)
    });
    let (components, connections): (String, String) = (components.collect(), connections.collect());
    let after = "";
    ssd(&system(&components, &connections), after).replace(
        "<ssd:DefaultExperiment startTime='0' stopTime='1'/>",
        &format!(
            "<ssd:DefaultExperiment startTime='0' stopTime='1.2'/><ssd:Annotations>\
             <ssc:Annotation type='cosim'><cosim:Master xmlns:cosim='urn:cosim:1' \
             algorithm='{algorithm}'/></ssc:Annotation></ssd:Annotations>"
        ),
    )
}

fn number() -> impl Strategy<Value = f64> {
    prop_oneof![-1e3..1e3, Just(-0.0), Just(1e-300), Just(0.1 + 0.2)]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, ..Default::default() })]

    #[test]
    fn every_format_keeps_random_systems(
        parts in prop::collection::vec((0..4_usize, number(), prop::option::of(1.0..1e9), 1..4_u8), 1..6),
        links in prop::collection::vec(
            (any::<prop::sample::Index>(), any::<prop::sample::Index>(), prop::option::of((number(), number()))),
            0..8,
        ),
        gauss in any::<bool>(),
    ) {
        let folder = Folder::new();
        let algorithm = if gauss { "gauss-seidel" } else { "jacobi" };
        let original = folder.load(&text(&parts, &links, algorithm)).unwrap();
        let wanted = outline(&original);
        prop_assert_eq!(&again(&original, &folder.path("out/a.ssd")), &wanted);
        prop_assert_eq!(&again(&original, &folder.path("a.ssp")), &wanted);
        let wanted = Outline { algorithm: Algorithm::Jacobi, ..wanted };
        prop_assert_eq!(&again(&original, &folder.path("osp")), &wanted);
        prop_assert_eq!(&again(&original, &folder.path("a.xml")), &wanted);
        // From format to format and back.
        let osp = System::load(folder.path("osp"), &Overrides::new()).unwrap();
        prop_assert_eq!(&again(&osp, &folder.path("b.ssp")), &wanted);
        let package = System::load(folder.path("b.ssp"), &Overrides::new()).unwrap();
        prop_assert_eq!(&again(&package, &folder.path("c/b.xml")), &wanted);
        // A second time gives the same bytes.
        package.write(folder.path("d.ssp")).unwrap();
        let bytes = |name: &str| std::fs::read(folder.path(name)).unwrap();
        prop_assert!(bytes("b.ssp") == bytes("d.ssp"));
    }
}

fn cosim(arguments: &[&str], folder: &Folder) -> (i32, String) {
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_cosim"))
        .args(arguments)
        .current_dir(folder.0.path())
        .env("NO_COLOR", "1")
        .output()
        .unwrap();
    (output.status.code().unwrap(), String::from_utf8(output.stderr).unwrap())
}

#[test]
fn the_verb_converts_with_changes_and_says_what_a_format_cannot() {
    let folder = Folder::new();
    let ssd = Ssd::new().add("c", Model::Clock).add("g", Model::Gain).connect("c.y", "g.u");
    let file = ssd.write();
    let from = file.to_str().unwrap();
    let changes = ["--start-value", "g.k=3", "--stop-time", "0.5", "--algorithm", "jacobi"];
    let (code, reported) = cosim(&[&["convert", from, "x.ssp"], &changes[..]].concat(), &folder);
    assert_eq!(code, 0, "{reported}");
    let overrides =
        Overrides::new().start_value("g.k", 3).stop_time(0.5).algorithm(Algorithm::Jacobi);
    let package = System::load(folder.path("x.ssp"), &Overrides::new()).unwrap();
    assert_eq!(run(&package), run(&ssd.load(&overrides).unwrap()));
    // The same system has the same bytes at any time.
    let mut archive = zip::ZipArchive::new(File::open(folder.path("x.ssp")).unwrap()).unwrap();
    for place in 0..archive.len() {
        let entry = archive.by_index(place).unwrap();
        assert_eq!(entry.last_modified(), Some(zip::DateTime::default()));
    }
    let (code, reported) = cosim(&["convert", from, "folder"], &folder);
    assert_eq!(code, 0, "{reported}");
    assert_parts(&reported, &["note: OSP has no gauss-seidel", "written: folder"]);
    assert!(folder.path("folder/GAIN.fmu").is_file());
    // Nothing is written over itself.
    let (code, reported) = cosim(&["convert", "folder", "folder"], &folder);
    assert_eq!(code, 1, "{reported}");
    assert_parts(&reported, &["would replace an input"]);
    assert!(System::load(folder.path("folder"), &Overrides::new()).is_ok());
    let (code, reported) = cosim(&["convert", from, "x.fmu"], &folder);
    assert_eq!(code, 2, "{reported}");
    assert_parts(&reported, &["no format has the extension .fmu"]);
}

#[test]
fn maps_and_model_exchange_have_no_word_in_osp_and_sums_none_in_ssp() {
    let folder = Folder::new();
    let ports = "m:input:Integer n:output:Integer";
    let map = "<ssc:IntegerMappingTransformation><ssc:MapEntry source='0' target='5'/>\
               </ssc:IntegerMappingTransformation>";
    let counter = |name: &str| component(name, &Model::Counter.fmu(), ports, "");
    let elements = [counter("a"), counter("b")].concat();
    let mapped = folder.load(&ssd(&system(&elements, &connection("a.n", "b.m", map)), "")).unwrap();
    let error = mapped.write(folder.path("x.xml")).unwrap_err().to_string();
    assert_parts(&error, &["E210", "a.n -> b.m is mapped"]);
    assert_eq!(again(&mapped, &folder.path("y.ssp")), outline(&mapped));
    let ball = component("ball", &Model::Ball.fmu(), "", "")
        .replace("<ssd:Connectors>\n</ssd:Connectors>", "");
    let ball = folder.load(&ssd(&system(&ball, ""), "")).unwrap();
    let error = ball.write(folder.path("x.xml")).unwrap_err().to_string();
    assert_parts(&error, &["E210", "'ball' is a model exchange FMU"]);
    let gain = Model::Gain.fmu();
    let sum = format!(
        "<OspSystemStructure xmlns='http://opensimulationplatform.com/MSMI/OSPSystemStructure' \
         version='0.1'><EndTime>1</EndTime><Simulators><Simulator name='g' source='{}'/></Simulators>\
         <Functions><VectorSum name='v' inputCount='1' dimension='2'/></Functions><Connections>\
         <SignalConnection><Variable simulator='g' name='y'/><Signal function='v' name='in[0][1]'/>\
         </SignalConnection></Connections></OspSystemStructure>",
        gain.display()
    );
    let sum = System::load(folder.write("sum.xml", &sum), &Overrides::new()).unwrap();
    let error = sum.write(folder.path("x.ssd")).unwrap_err().to_string();
    assert_parts(&error, &["E210", "'v' is a sum"]);
    sum.write(folder.path("z.xml")).unwrap();
    let back = System::load(folder.path("z.xml"), &Overrides::new()).unwrap();
    let names: Vec<&str> = back.components().iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["g", "v[0]", "v[1]"]);
}

#[test]
fn conversions_of_units_are_written_as_what_they_amount_to() {
    let folder = Folder::new();
    let source = folder.fmu_in(Model::Clock, "degC", "K=\"1\" offset=\"273.15\"");
    let sink = folder.fmu_in(Model::Gain, "mK", "K=\"1\" factor=\"0.001\"");
    let ports = "u:input:Real y:output:Real";
    let elements = [component("c", &source, ports, ""), component("g", &sink, ports, "")].concat();
    let text = ssd(&system(&elements, &connection("c.y", "g.u", "")), "");
    let original = folder.load(&text).unwrap();
    assert_eq!(crate::formats::last(&run(&original), "g.y"), 274150.0);
    let wanted = outline(&original);
    assert_eq!(again(&original, &folder.path("a.ssp")), wanted);
    assert_eq!(again(&original, &folder.path("b/a.ssd")), wanted);
    assert_eq!(again(&original, &folder.path("osp")).connections, wanted.connections);
    // Suppressed conversions are not made, and that is preserved too.
    let suppressed =
        text.replace("<ssd:Connection ", "<ssd:Connection suppressUnitConversion='true' ");
    let original = folder.load(&suppressed).unwrap();
    assert_eq!(again(&original, &folder.path("c.ssp")), outline(&original));
    assert_eq!(crate::formats::last(&run(&original), "g.y"), 1.0);
    // OSP cannot express it: a function that changes nothing keeps the units apart.
    assert_eq!(again(&original, &folder.path("d.xml")).connections, original.connections());
}

#[test]
fn all_parameter_sets_have_one_name() {
    let system = Ssd::new().add_with("a", Model::Gain, &[("k", 2.0)], None).add_with(
        "b",
        Model::Gain,
        &[("k", 3.0)],
        None,
    );
    let folder = Folder::new();
    let file = folder.path("written.ssd");
    system.load(&Overrides::new()).unwrap().write(&file).unwrap();
    let text = std::fs::read_to_string(file).unwrap();
    let sets =
        |part: &str| text.matches(&format!("<ssv:ParameterSet version=\"1.0\"{part}")).count();
    assert_eq!((sets(""), sets(" name=\"parameters\"")), (2, 2), "{text}");
}
