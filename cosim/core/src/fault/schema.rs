//! The JSON Schema of scenarios in TOML, for editors that complete and check them.

use serde_json::{Map, Value, json};

use super::{KINDS, Word};

/// The schema: a list of faults, each of one of the [`KINDS`] with its keys.
pub fn schema() -> Value {
    let faults: Vec<Value> = KINDS.iter().map(fault).collect();
    json!({
        "$schema": "http://json-schema.org/draft-07/schema#",
        "title": "Scenario: faults of a co-simulated system",
        "type": "object",
        "additionalProperties": false,
        "properties": {
            "description": { "type": "string" },
            "seed": { "type": "integer", "minimum": 0, "description": "of all random numbers" },
            "end": { "type": "number", "description": "ends the run at this instant (s)" },
            "fault": { "type": "array", "items": { "oneOf": faults } },
        },
    })
}

fn fault(word: &Word) -> Value {
    let number = |what: &str| json!({ "type": "number", "description": what });
    let mut properties = Map::new();
    let mut add = |key: &str, value: Value| drop(properties.insert(key.to_owned(), value));
    add("kind", json!({ "const": word.name, "description": word.meaning }));
    let what = "a variable, or several; * and ? match parts of names";
    let name = json!({ "type": "string" });
    let names = json!({ "type": "array", "items": { "type": "string" }, "minItems": 1 });
    add("on", json!({ "description": what, "oneOf": [name, names] }));
    add("installed", number("is installed at this instant (s); by default with the run"));
    add("from", number("begins at this instant (s)"));
    add("until", number("ends at this instant (s)"));
    let one = json!({ "type": "number" });
    let two = json!({ "type": "array", "items": one, "minItems": 2, "maxItems": 2 });
    add(
        "for",
        json!({ "description": "lasts this long, or a time drawn between two (s)",
                       "oneOf": [one, two] }),
    );
    add(
        "between",
        json!({ "type": "array", "items": one, "minItems": 2, "maxItems": 2,
                           "description": "begins at an instant drawn between these (s)" }),
    );
    add(
        "when",
        json!({ "type": "string",
                        "description": "begins when this first holds, such as 'a.y > 2'" }),
    );
    add("ramp-in", number("grows for this long (s)"));
    add("ramp-out", number("fades for this long (s)"));
    for meant in word.keys {
        let value = match meant.words {
            [] => number(meant.meaning),
            words => json!({ "enum": words, "description": meant.meaning }),
        };
        add(meant.key, value);
    }
    json!({
        "type": "object",
        "required": ["kind", "on"],
        "additionalProperties": false,
        "properties": properties,
    })
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_committed_schema_is_that_of_the_code() {
        let file =
            concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/reference/scenario.schema.json");
        let text = serde_json::to_string_pretty(&super::schema()).unwrap() + "\n";
        assert_eq!(
            std::fs::read_to_string(file).unwrap(),
            text,
            "`cosim explain schema` prints it"
        );
    }
}
