//! Who may do what: the rights that the listening side gives to certificates by their common
//! name.
//!
//! A worker takes commands and gives answers, its token and its own words; an observer reads what
//! is meant for observers; a name that is not listed may ask which rights it has, and no more.

use std::path::Path;

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use crate::distributed::keys;
use crate::error::{Code, Error, Result};

/// The common names that are known, by what they may do.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Members {
    /// May drive runs, and everything else.
    pub orchestrators: Vec<String>,
    /// May lend machines.
    pub workers: Vec<String>,
    /// May read what is published for observers.
    pub observers: Vec<String>,
}

/// What somebody may do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Role {
    /// Everything.
    Orchestrator,
    /// Lend a machine.
    Worker,
    /// Read telemetry.
    Observer,
}

impl Role {
    /// The role in words.
    pub(crate) fn text(self) -> &'static str {
        match self {
            Self::Orchestrator => "an orchestrator",
            Self::Worker => "a worker",
            Self::Observer => "an observer",
        }
    }
}

impl Members {
    /// What a file says; nothing when there is none.
    pub(crate) fn read(file: &Path) -> Result<Option<Self>> {
        let text = match std::fs::read_to_string(file) {
            Ok(text) => text,
            Err(why) if why.kind() == std::io::ErrorKind::NotFound => return Ok(None),
            Err(why) => return Err(unusable(file).why(why)),
        };
        serde_json::from_str(&text).map(Some).map_err(|why| unusable(file).why(why))
    }

    /// What a name may do.
    pub(crate) fn role(&self, name: &str) -> Option<Role> {
        let has = |names: &[String]| names.iter().any(|known| known == name);
        let roles = [
            (&self.orchestrators, Role::Orchestrator),
            (&self.workers, Role::Worker),
            (&self.observers, Role::Observer),
        ];
        roles.into_iter().find(|(names, _)| has(names)).map(|(_, role)| role)
    }

    /// Zenoh's access control: what is not said here is denied. Local users of the session are
    /// not concerned.
    pub(crate) fn access_control(&self) -> Value {
        let mut list = Lists::default();
        list.subject("anybody", None);
        let ask = ["query", "reply", "declare_queryable"];
        list.rule("ask", BOTH, &ask, &[keys::rights()]);
        list.policy("anybody", &["ask"]);
        if !self.orchestrators.is_empty() {
            list.subject("orchestrators", Some(&self.orchestrators));
            list.rule("all", BOTH, &ALL, &keys::everything());
            list.policy("orchestrators", &["all"]);
        }
        if !self.observers.is_empty() {
            list.subject("observers", Some(&self.observers));
            let open = [keys::open("**")];
            list.rule("watch", IN, &["declare_subscriber"], &open);
            list.rule("show", OUT, &["put"], &open);
            list.policy("observers", &["watch", "show"]);
        }
        self.workers.iter().for_each(|worker| list.worker(worker));
        json!({
            "enabled": true,
            "default_permission": "deny",
            "rules": list.rules,
            "subjects": list.subjects,
            "policies": list.policies,
        })
    }
}

const IN: &[&str] = &["ingress"];
const OUT: &[&str] = &["egress"];
const BOTH: &[&str] = &["ingress", "egress"];
const ALL: [&str; 9] = [
    "put",
    "delete",
    "declare_subscriber",
    "query",
    "declare_queryable",
    "reply",
    "liveliness_token",
    "declare_liveliness_subscriber",
    "liveliness_query",
];

#[derive(Default)]
struct Lists {
    rules: Vec<Value>,
    subjects: Vec<Value>,
    policies: Vec<Value>,
}

impl Lists {
    fn subject(&mut self, id: &str, names: Option<&[String]>) {
        self.subjects.push(match names {
            Some(names) => json!({ "id": id, "cert_common_names": names }),
            None => json!({ "id": id }),
        });
    }

    fn rule(&mut self, id: &str, flows: &[&str], messages: &[&str], keys: &[String]) {
        self.rules.push(json!({
            "id": id, "permission": "allow", "flows": flows, "messages": messages,
            "key_exprs": keys,
        }));
    }

    fn policy(&mut self, subject: &str, rules: &[&str]) {
        self.policies.push(json!({ "subjects": [subject], "rules": rules }));
    }

    /// A worker announces and serves itself, and speaks for the lives of groups that it has.
    fn worker(&mut self, name: &str) {
        let (own, root) = (keys::worker(name), keys::root());
        let gives = [own.clone(), keys::lives(name, "rep/*"), keys::lives(name, "alive/*")];
        let serves = [format!("{own}/*")];
        let takes = [keys::lives(name, "cmd/*")];
        let asks = [keys::fmu("*", "*")];
        let follows = [own, format!("{root}/running/*")];
        let listen = ["declare_liveliness_subscriber", "liveliness_query"];
        let hear = ["declare_subscriber", listen[0], listen[1]];
        let rules: [(&[&str], &[&str], &[String]); 10] = [
            (IN, &["put", "liveliness_token"], &gives),
            (OUT, &hear, &gives),
            (IN, &["declare_queryable", "reply"], &serves),
            (OUT, &["query"], &serves),
            (IN, &["declare_subscriber"], &takes),
            (OUT, &["put"], &takes),
            (IN, &["query"], &asks),
            (OUT, &["reply", "declare_queryable"], &asks),
            (IN, &listen, &follows),
            (OUT, &["liveliness_token", "reply"], &follows),
        ];
        self.subject(name, Some(&[name.to_owned()]));
        let names: Vec<String> = (0..rules.len()).map(|n| format!("{name} {n}")).collect();
        for (id, (flows, messages, keys)) in names.iter().zip(rules) {
            self.rule(id, flows, messages, keys);
        }
        self.policy(name, &names.iter().map(String::as_str).collect::<Vec<_>>());
    }
}

fn unusable(file: &Path) -> Error {
    Error::new(Code::Certificate, "the list of members cannot be used")
        .at(file)
        .help(r#"it is as {"orchestrators": ["a"], "workers": ["b"], "observers": ["c"]}"#)
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
    fn everybody_has_the_rights_of_his_role_and_no_more() {
        let list = members().access_control();
        let life = keys::life("r", "left", 1, 2);
        let (command, answer) = (format!("{life}/cmd/bulk"), format!("{life}/rep/quick"));
        let (left, signals) = (keys::worker("left"), keys::open("r/signals"));
        for (subject, message, key, wanted) in [
            ("orchestrators", "put", &command, true),
            ("orchestrators", "query", &format!("{left}/start"), true),
            ("left", "put", &answer, true),
            ("left", "put", &command, false),
            ("right", "put", &answer, false),
            ("right", "liveliness_token", &format!("{life}/alive/quick"), false),
            ("right", "declare_subscriber", &command, false),
            ("left", "declare_subscriber", &command, true),
            ("left", "declare_subscriber", &answer, false),
            ("left", "liveliness_token", &left, true),
            ("right", "liveliness_token", &left, false),
            ("right", "declare_queryable", &format!("{left}/start"), false),
            ("left", "query", &format!("{left}/start"), false),
            ("left", "query", &keys::fmu("r", "00"), true),
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
