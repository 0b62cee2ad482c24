//! modelDescription.xml: complete, correct, and the same bytes every time.

use crate::components::REGISTRY;
use fmu_kit::kernel::{Table, TableError};
use fmu_kit::{Declaration, Field, Start};

fn text(name: &str) -> String {
    REGISTRY.named(name).unwrap().describe().unwrap()
}

/// The names an unknown depends on, from a list of the model structure.
fn dependencies(name: &str, list: &str, unknown: &str) -> Vec<String> {
    let (text, table) = (text(name), REGISTRY.named(name).unwrap().table());
    let names: Vec<_> = table.variables().iter().map(|v| v.name.as_str()).collect();
    let index = names.iter().position(|name| *name == unknown).unwrap() + 1;
    let start = text.find(&format!("<{list}>")).expect("the list is there");
    let end = text.find(&format!("</{list}>")).unwrap();
    let key = format!("index=\"{index}\" dependencies=\"");
    let line = text[start..end].split_once(&key).expect("the unknown is listed").1;
    let indices = line.split_once('"').unwrap().0.split_whitespace();
    indices.map(|index| names[index.parse::<usize>().unwrap() - 1].to_owned()).collect()
}

#[test]
fn the_same_component_gives_the_same_bytes() {
    assert_eq!(text("Spring"), text("Spring"));
    let guid = REGISTRY.named("Spring").unwrap().guid();
    assert_eq!(guid.len(), 38);
    assert!(text("Spring").contains(&format!("guid=\"{guid}\"")));
    assert_ne!(guid, REGISTRY.named("Noise").unwrap().guid());
}

#[test]
fn feed_through_is_found_where_it_is_and_only_there() {
    assert_eq!(dependencies("Spring", "Outputs", "position"), ["state.x"]);
    assert_eq!(dependencies("Spring", "Outputs", "acceleration"), ["force", "state.x"]);
    assert_eq!(dependencies("Spring", "Derivatives", "der(state.x)"), ["state.v"]);
    assert_eq!(dependencies("Spring", "Derivatives", "der(state.v)"), ["force", "state.x"]);
}

/// All are computed at the same sample; `count` itself only follows `enabled`.
#[test]
fn sampled_outputs_share_the_inputs_that_move_any_of_them() {
    for output in ["value", "count", "stamp"] {
        assert_eq!(dependencies("Noise", "Outputs", output), ["signal", "enabled"]);
    }
}

/// It may change after more events than were tried.
#[test]
fn a_sampled_output_that_never_moves_is_taken_to_depend_on_all_inputs() {
    assert_eq!(dependencies("Clumsy", "Outputs", "constant"), ["command"]);
}

#[test]
fn initial_values_depend_on_parameters_and_inputs() {
    let of = |unknown| dependencies("Spring", "InitialUnknowns", unknown);
    assert_eq!(of("position"), ["parameter_set", "start", "label"]);
    assert_eq!(of("state.v"), ["label"]);
    let all = ["parameter_set", "mass", "stiffness", "start", "sign", "sprung", "label", "force"];
    assert_eq!(of("der(state.v)"), all);
    // A sample contains its time, and what is sampled together depends together.
    let sample = dependencies("Noise", "InitialUnknowns", "value");
    assert_eq!(sample, ["seed", "signal", "enabled", "time"]);
}

#[test]
fn the_parts_are_as_declared() {
    let text = text("Spring");
    for part in [
        r#"description="A mass on a &quot;spring&quot; &amp; nothing else""#,
        r#"version="1 &lt; 2""#,
        r#"<CoSimulation modelIdentifier="Spring""#,
        r#"<ModelExchange modelIdentifier="Spring""#,
        r#"<Unit name="N/m">"#,
        r#"<BaseUnit kg="1" s="-2"/>"#,
        r#"<Item name="Heavy" value="2" description="A heavy mass"/>"#,
        r#"<Enumeration declaredType="Set" start="1"/>"#,
        r#"<Real declaredType="Mass" unit="kg" min="0.001" start="1.0"/>"#,
        r#"<Real declaredType="Acceleration" unit="m/s2" nominal="1.0" derivative="15"/>"#,
        r#"<SimpleType name="Value in N/m">"#,
        r#"name="time" valueReference="12" description="Simulation time" causality="independent""#,
    ] {
        assert!(text.contains(part), "{part}\n{text}");
    }
    let solitary = self::text("Solitary");
    assert!(!solitary.contains("ModelExchange") && !solitary.contains("<Enumeration>"));
}

/// The page and the listing agree with the description, and contain the author's chapters.
#[test]
fn people_read_the_same_as_tools() {
    let spring = REGISTRY.named("Spring").unwrap();
    let page = spring.documentation("<h2>Equations</h2>");
    for part in [
        "A mass on a &quot;spring&quot; &amp; nothing else",
        "<h2>Equations</h2>",
        "<td><code>mass</code></td><td>Mass</td><td>kg</td><td class=\"n\">1.0</td>",
        "<li>2 <code>Heavy</code>: A heavy mass</li>",
        "<td class=\"n\">-1 … 1</td>",
        "<h2 id=\"continuous-states\">Continuous states</h2>",
    ] {
        assert!(page.contains(part), "{part}\n{page}");
    }
    let listing = spring.listing();
    for part in [
        "## Spring\n",
        "### Spring: Parameters\n",
        "| `mass` | Mass | kg | 1.0 | ≥ 0.001 |",
        "| `position` | Position | m |  |  |",
    ] {
        assert!(listing.contains(part), "{part}\n{listing}");
    }
}

#[test]
fn the_names_of_the_types_are_taken() {
    let force = Declaration {
        field: Field { name: "Force".to_owned(), ..Field::default() },
        start: Start::Real(0.0),
    };
    let table = Table::new(vec![force], vec![], vec![], vec![]);
    assert_eq!(table, Err(TableError::TypeName("Force".to_owned())));
}
