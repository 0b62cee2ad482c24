//! The rights that the listening side grants to certificates by their common name.
//!
//! A worker receives commands and sends answers, its token and information about itself; an
//! observer reads what is published for observers; a name that is not listed may only query its own
//! rights.

use std::path::Path;

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use crate::keys;
use cosim_base::error::{Code, Error, Result};

/// The known common names, by role.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Members {
    /// May drive runs and do everything else.
    pub orchestrators: Vec<String>,
    /// May provide machines.
    pub workers: Vec<String>,
    /// May read what is published for observers.
    pub observers: Vec<String>,
}

/// The rights of a name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Role {
    /// Everything.
    Orchestrator,
    /// Provide a machine.
    Worker,
    /// Read telemetry.
    Observer,
}

impl Role {
    /// The role as text.
    pub(crate) fn text(self) -> &'static str {
        match self {
            Self::Orchestrator => "an orchestrator",
            Self::Worker => "a worker",
            Self::Observer => "an observer",
        }
    }
}

impl Members {
    /// Reads a file; `None` if it does not exist.
    pub(crate) fn read(file: &Path) -> Result<Option<Self>> {
        let text = match cosim_base::files::read_input_text(file) {
            Ok(text) => text,
            Err(why) if why.kind() == std::io::ErrorKind::NotFound => return Ok(None),
            Err(why) => return Err(unusable(file).why(why)),
        };
        serde_json::from_str(&text).map(Some).map_err(|why| unusable(file).why(why))
    }

    /// The role of a name.
    pub(crate) fn role(&self, name: &str) -> Option<Role> {
        let has = |names: &[String]| names.iter().any(|known| known == name);
        let roles = [
            (&self.orchestrators, Role::Orchestrator),
            (&self.workers, Role::Worker),
            (&self.observers, Role::Observer),
        ];
        roles.into_iter().find(|(names, _)| has(names)).map(|(_, role)| role)
    }

    /// Zenoh's access control: everything not listed here is denied. Local users of the session are
    /// not affected.
    pub(crate) fn access_control(&self) -> Value {
        let mut list = Lists::default();
        list.member("anybody", None, &rights(None, ""));
        if !self.orchestrators.is_empty() {
            list.member(
                "orchestrators",
                Some(&self.orchestrators),
                &rights(Some(Role::Orchestrator), ""),
            );
        }
        if !self.observers.is_empty() {
            list.member("observers", Some(&self.observers), &rights(Some(Role::Observer), ""));
        }
        for worker in &self.workers {
            let own = std::slice::from_ref(worker);
            list.member(worker, Some(own), &rights(Some(Role::Worker), worker));
        }
        json!({
            "enabled": true,
            "default_permission": "deny",
            "rules": list.rules,
            "subjects": list.subjects,
            "policies": list.policies,
        })
    }
}

/// An operation on a key.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verb {
    /// Publish messages.
    Publish,
    /// Subscribe to messages.
    Hear,
    /// Declare a liveliness token.
    Announce,
    /// Watch liveliness tokens.
    Follow,
    /// Answer queries.
    Serve,
    /// Send queries and receive answers.
    Ask,
}

impl Verb {
    /// All of them.
    pub const ALL: [Self; 6] =
        [Self::Publish, Self::Hear, Self::Announce, Self::Follow, Self::Serve, Self::Ask];

    /// The verb as text.
    pub fn text(self) -> &'static str {
        match self {
            Self::Publish => "publish",
            Self::Hear => "hear",
            Self::Announce => "announce",
            Self::Follow => "follow",
            Self::Serve => "serve",
            Self::Ask => "ask",
        }
    }

    /// The Zenoh messages of this verb: those sent by a member, and those sent to it.
    fn messages(self) -> [&'static [&'static str]; 2] {
        const LISTEN: &[&str] = &["declare_liveliness_subscriber", "liveliness_query"];
        match self {
            Self::Publish => [&["put", "delete"], &["declare_subscriber"]],
            Self::Hear => [&["declare_subscriber"], &["put", "delete"]],
            Self::Announce => [&["liveliness_token"], LISTEN],
            Self::Follow => [LISTEN, &["liveliness_token", "reply"]],
            Self::Serve => [&["declare_queryable", "reply"], &["query"]],
            Self::Ask => [&["query"], &["declare_queryable", "reply"]],
        }
    }
}

/// The rights of a role, for a worker of that name: the single source of Zenoh's access control, of
/// the table in the documentation, and of the test that tries all of them.
pub(crate) fn rights(role: Option<Role>, name: &str) -> Vec<(Verb, String)> {
    let own = keys::worker(name);
    match role {
        // Only the listening side answers there: any other client that served it could claim that
        // others have no rights.
        None => vec![(Verb::Ask, keys::rights())],
        Some(Role::Orchestrator) => {
            let all = keys::everything();
            Verb::ALL.into_iter().flat_map(|verb| all.clone().map(|key| (verb, key))).collect()
        }
        Some(Role::Observer) => vec![(Verb::Hear, keys::open("**"))],
        // It announces and serves itself, and speaks for the incarnations that it runs.
        Some(Role::Worker) => vec![
            (Verb::Announce, own.clone()),
            (Verb::Follow, own.clone()),
            (Verb::Serve, format!("{own}/*")),
            (Verb::Follow, keys::running("*")),
            (Verb::Announce, keys::incarnations(name, "alive/*")),
            (Verb::Hear, keys::incarnations(name, "cmd/*")),
            (Verb::Publish, keys::incarnations(name, "rep/*")),
            (Verb::Ask, keys::fmu("*", name, "*")),
        ],
    }
}

/// All rights: role, verb and key; the worker is called `name`.
#[doc(hidden)]
pub fn all_rights(name: &str) -> Vec<(&'static str, Verb, String)> {
    let roles = [
        ("anybody", None),
        ("orchestrator", Some(Role::Orchestrator)),
        ("worker", Some(Role::Worker)),
        ("observer", Some(Role::Observer)),
    ];
    let of =
        |(text, role)| rights(role, name).into_iter().map(move |(verb, key)| (text, verb, key));
    roles.into_iter().flat_map(of).collect()
}

#[derive(Default)]
struct Lists {
    rules: Vec<Value>,
    subjects: Vec<Value>,
    policies: Vec<Value>,
}

impl Lists {
    fn member(&mut self, id: &str, names: Option<&[String]>, rights: &[(Verb, String)]) {
        self.subjects.push(match names {
            Some(names) => json!({ "id": id, "cert_common_names": names }),
            None => json!({ "id": id }),
        });
        let mut own = Vec::new();
        for (number, (verb, key)) in rights.iter().enumerate() {
            for (flow, messages) in ["ingress", "egress"].into_iter().zip(verb.messages()) {
                let rule = format!("{id} {number} {flow}");
                self.rules.push(json!({
                    "id": rule, "permission": "allow", "flows": [flow], "messages": messages,
                    "key_exprs": [key],
                }));
                own.push(rule);
            }
        }
        self.policies.push(json!({ "subjects": [id], "rules": own }));
    }
}

fn unusable(file: &Path) -> Error {
    Error::new(Code::Certificate, "the list of members cannot be used")
        .at(file)
        .help(r#"the format is {"orchestrators": ["a"], "workers": ["b"], "observers": ["c"]}"#)
}

#[cfg(test)]
mod tests {
    use zenoh::key_expr::KeyExpr;

    use super::*;

    fn members() -> Members {
        let names = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect();
        Members {
            orchestrators: names(&["o"]),
            workers: names(&["left", "right"]),
            observers: names(&["desk"]),
        }
    }

    /// Whether `subject` may send `message` on `key`.
    fn may(list: &Value, subject: &str, message: &str, key: &str) -> bool {
        let has = |list: &Value, text: &str| list.as_array().unwrap().iter().any(|v| v == text);
        let key = KeyExpr::try_from(key).unwrap();
        let policies = list["policies"].as_array().unwrap();
        let of =
            policies.iter().filter(|p| ["anybody", subject].iter().any(|s| has(&p["subjects"], s)));
        let rules: Vec<&Value> =
            of.flat_map(|policy| policy["rules"].as_array().unwrap()).collect();
        list["rules"].as_array().unwrap().iter().any(|rule| {
            let keys = rule["key_exprs"].as_array().unwrap();
            rules.contains(&&rule["id"])
                && has(&rule["flows"], "ingress")
                && has(&rule["messages"], message)
                && keys
                    .iter()
                    .any(|k| KeyExpr::try_from(k.as_str().unwrap()).unwrap().includes(&key))
        })
    }

    #[test]
    fn every_name_has_the_rights_of_its_role_and_no_more() {
        let list = members().access_control();
        let key = keys::incarnation("r", "left", 1, 2);
        let (command, answer) = (format!("{key}/cmd/bulk"), format!("{key}/rep/quick"));
        let (left, signals) = (keys::worker("left"), keys::open("r/signals"));
        for (subject, message, key, wanted) in [
            ("orchestrators", "put", &command, true),
            ("orchestrators", "query", &format!("{left}/start"), true),
            ("left", "put", &answer, true),
            ("left", "put", &command, false),
            ("left", "declare_queryable", &keys::rights(), false),
            ("right", "put", &answer, false),
            ("right", "liveliness_token", &format!("{key}/alive/quick"), false),
            ("right", "declare_subscriber", &command, false),
            ("left", "declare_subscriber", &command, true),
            ("left", "declare_subscriber", &answer, false),
            ("left", "liveliness_token", &left, true),
            ("right", "liveliness_token", &left, false),
            ("right", "declare_queryable", &format!("{left}/start"), false),
            ("left", "query", &format!("{left}/start"), false),
            ("left", "query", &keys::fmu("r", "left", "00"), true),
            ("left", "query", &keys::fmu("r", "right", "00"), false),
            ("desk", "declare_queryable", &keys::rights(), false),
            ("left", "reply", &keys::rights(), false),
            ("left", "put", &signals, false),
            ("observers", "declare_subscriber", &signals, true),
            ("observers", "put", &signals, false),
            ("observers", "declare_subscriber", &answer, false),
            ("observers", "put", &command, false),
            ("nobody", "query", &keys::rights(), true),
            ("nobody", "declare_subscriber", &signals, false),
        ] {
            assert_eq!(may(&list, subject, message, key), wanted, "{subject} {message} {key}");
        }
    }

    #[test]
    fn the_table_of_rights_stands_in_the_documentation() {
        let mut table = String::from("| who | does | with |\n|---|---|---|\n");
        for (role, verb, key) in all_rights("NAME") {
            // An orchestrator does everything.
            if role != "orchestrator" {
                table += &format!("| {role} | {} | `{key}` |\n", verb.text());
            }
        }
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/distributed.md");
        let text = std::fs::read_to_string(file).unwrap();
        assert!(text.contains(&table), "docs/distributed.md should have:\n{table}");
    }

    #[test]
    fn zenoh_takes_the_list() {
        let mut config = zenoh::Config::default();
        let list = members().access_control().to_string();
        assert!(config.insert_json5("access_control", &list).is_ok());
        let list = Members::default().access_control().to_string();
        assert!(config.insert_json5("access_control", &list).is_ok());
    }

    #[test]
    fn a_name_has_one_role() {
        let roles = ["o", "left", "desk", "x"].map(|name| members().role(name));
        let wanted = [Some(Role::Orchestrator), Some(Role::Worker), Some(Role::Observer), None];
        assert_eq!(roles, wanted);
    }
}
