//! What the roles of a distributed run may do.

use std::path::Path;
use std::time::Duration;

use cosim::distributed::Verb;
use zenoh::Wait;

use super::{Running, free_port, keys, start, text};
use crate::distributed::{chain, outcome, results};

/// A run over TLS with two workers.
fn locked_run(at: &Path, file: &str, more: &[&str]) -> (Running, Running, Running, String) {
    let endpoint = format!("tls/127.0.0.1:{}", free_port());
    let run = ["run", file, "-q", "-o", "there.csv", "--distributed", "--min-workers", "2"];
    let run = [&run[..], &["--listen", &endpoint, "--credentials", "keys/orchestrator"], more];
    let run = start(at, &run.concat());
    let worker = |name: &str| {
        let credentials = format!("keys/{name}");
        let arguments = ["worker", "--name", name, "--connect", &endpoint, "--allow-upload"];
        start(at, &[&arguments[..], &["--credentials", &credentials]].concat())
    };
    // They keep connecting for a while.
    let (left, right) = (worker("left"), worker("right"));
    (run, left, right, endpoint)
}

#[test]
fn an_observer_can_neither_read_nor_write_what_steers_a_run() {
    let (folder, file) = (keys(), chain(16.0));
    let (at, file) = (folder.path(), file.write());
    let path = file.to_str().unwrap();
    let (code, stderr) = outcome(at, &["run", path, "-q", "-o", "here.csv"]);
    assert_eq!(code, 0, "{stderr}");
    let (mut run, _left, _right, endpoint) = locked_run(at, path, &["--real-time=2"]);
    let observer = observe(&endpoint, &at.join("keys/observer"));
    let second = observe(&endpoint, &at.join("keys/observer"));
    let heard = observer.declare_subscriber("cosim/@1/**").wait().unwrap();
    let runs = observer.liveliness().get("cosim/@1/run/**").wait().unwrap();
    assert_eq!(runs.iter().filter(|reply| reply.result().is_ok()).count(), 0);
    let mut ended = None;
    while ended.is_none() {
        for key in ["cosim/@1/run/x/left/0.1/cmd/quick", "cosim/@1/run/x/left/0.1/rep/quick"] {
            second.put(key, vec![0xC5, 1, 10]).wait().unwrap();
        }
        std::thread::sleep(Duration::from_millis(20));
        ended = run.0.try_wait().unwrap();
    }
    assert_eq!(ended.and_then(|status| status.code()), Some(0));
    assert_eq!(results(at, "here.csv"), results(at, "there.csv"));
    assert!(heard.try_recv().unwrap().is_none());
}

#[test]
fn a_worker_does_not_receive_the_commands_of_another() {
    let (folder, file) = (keys(), chain(16.0));
    let (at, file) = (folder.path(), file.write());
    let (mut run, _left, _right, endpoint) =
        locked_run(at, file.to_str().unwrap(), &["--real-time=4"]);
    let thief = observe(&endpoint, &at.join("keys/right"));
    let hear = |worker: &str| thief.declare_subscriber(format!("cosim/@1/run/*/{worker}/*/cmd/*"));
    let (others, own) = (hear("left").wait().unwrap(), hear("right").wait().unwrap());
    assert_eq!(run.0.wait().unwrap().code(), Some(0));
    assert!(own.try_recv().unwrap().is_some());
    assert!(others.try_recv().unwrap().is_none());
}

/// A session with these credentials, using Zenoh alone.
fn observe(endpoint: &str, credentials: &Path) -> zenoh::Session {
    let mut config = zenoh::Config::default();
    let file = |name: &str| format!("{:?}", credentials.join(name));
    for (key, value) in [
        ("mode", "\"client\"".to_owned()),
        ("connect/endpoints", format!("[{endpoint:?}]")),
        ("connect/timeout_ms", "10000".to_owned()),
        ("scouting/multicast/enabled", "false".to_owned()),
        ("transport/link/tls/root_ca_certificate", file("ca.pem")),
        ("transport/link/tls/connect_certificate", file("cert.pem")),
        ("transport/link/tls/connect_private_key", file("key.pem")),
        ("transport/link/tls/enable_mtls", "true".to_owned()),
    ] {
        config.insert_json5(key, &value).unwrap();
    }
    zenoh::open(config).wait().unwrap()
}

/// Every role tries every verb on keys of every kind, with real certificates: what it may do works,
/// and nothing else does.
#[test]
fn every_cell_of_the_table_of_rights_is_as_it_says() {
    let folder = keys();
    let at = folder.path();
    // A name of the authority that is not in the list.
    let list = text(at, "keys/orchestrator/members.json");
    std::fs::write(
        at.join("keys/orchestrator/members.json"),
        list.replace("\"right\"", "\"other\""),
    )
    .unwrap();
    let endpoint = format!("tls/127.0.0.1:{}", free_port());
    let listening = ["workers", "--wait", "600", "--listen", &endpoint];
    let _listening = start(at, &[&listening[..], &["--credentials", "keys/orchestrator"]].concat());
    let of = |member: &str| observe(&endpoint, &at.join("keys").join(member));
    let orchestrator = of("orchestrator");
    let life = |worker: &str, what: &str| format!("cosim/@1/run/r/{worker}/0.1/{what}/quick");
    let mut sampled = vec!["cosim/@1/rights".to_owned(), "cosim/@1/running/r".to_owned()];
    sampled.push("cosim/1/r/status".to_owned());
    for worker in ["left", "other"] {
        sampled.push(format!("cosim/@pool/1/{worker}"));
        sampled.push(format!("cosim/@pool/1/{worker}/start"));
        sampled.push(format!("cosim/@1/run/r/{worker}/fmu/00"));
        sampled.extend(["cmd", "rep", "alive"].map(|what| life(worker, what)));
    }
    let rights = cosim::distributed::all_rights("left");
    let mut wrong = Vec::new();
    for (role, member) in [("worker", "left"), ("observer", "observer"), ("anybody", "right")] {
        let session = of(member);
        for key in &sampled {
            for verb in Verb::ALL {
                let may = rights.iter().any(|(who, does, keys)| {
                    (*who == role || *who == "anybody") && *does == verb && includes(keys, key)
                });
                // The listening side itself answers there.
                if key == "cosim/@1/rights" && matches!(verb, Verb::Ask | Verb::Serve) {
                    continue;
                }
                let does = tries((&orchestrator, key), (&session, key), verb, may);
                if does != may {
                    wrong.push(format!("{role} {verb:?} {key}: {does}, not {may}"));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// A forged answer about its rights would make a worker give up.
#[test]
fn an_observer_cannot_answer_for_the_rights() {
    let folder = keys();
    let at = folder.path();
    let endpoint = format!("tls/127.0.0.1:{}", free_port());
    let listening = ["workers", "--wait", "600", "--listen", &endpoint];
    let _listening = start(at, &[&listening[..], &["--credentials", "keys/orchestrator"]].concat());
    let of = |member: &str| observe(&endpoint, &at.join("keys").join(member));
    let observer = of("observer");
    let answering = |session: &zenoh::Session| {
        let forger = session.declare_queryable("cosim/@1/rights").callback(|query| {
            drop(query.reply(query.key_expr().clone(), "forged").wait());
        });
        let forger = forger.wait().unwrap();
        fence(session);
        forger
    };
    let left = of("left");
    let answers = || -> Vec<Vec<u8>> {
        let asked = left
            .get("cosim/@1/rights")
            .payload("left")
            .target(zenoh::query::QueryTarget::All)
            .consolidation(zenoh::query::ConsolidationMode::None)
            .timeout(Duration::from_secs(10));
        let answers = asked.wait().unwrap().into_iter();
        let answers = answers.filter_map(|reply| reply.into_result().ok());
        answers.map(|answer| answer.payload().to_bytes().into_owned()).collect()
    };
    let _forger = answering(&observer);
    let got = answers();
    assert!(!got.is_empty() && !got.contains(&b"forged".to_vec()), "{got:?}");
    // The answer of a member with the right to answer arrives.
    let orchestrator = of("orchestrator");
    let _other = answering(&orchestrator);
    assert!(answers().contains(&b"forged".to_vec()));
}

fn includes(keys: &str, key: &str) -> bool {
    use zenoh::key_expr::KeyExpr;
    KeyExpr::try_from(keys).unwrap().includes(&KeyExpr::try_from(key).unwrap())
}

/// Everything sent before by the same session has arrived when this has its answer.
fn fence(session: &zenoh::Session) {
    let asked = session.get("cosim/@1/rights").payload("x").timeout(Duration::from_secs(10));
    assert!(asked.wait().unwrap().recv().is_ok());
}

/// A pattern of keys gives no more rights than each key in it: no member reaches the keys of others
/// by a pattern that includes them.
#[test]
fn patterns_give_no_rights_to_the_keys_in_them() {
    let folder = keys();
    let at = folder.path();
    let endpoint = format!("tls/127.0.0.1:{}", free_port());
    let listening = ["workers", "--wait", "600", "--listen", &endpoint];
    let _listening = start(at, &[&listening[..], &["--credentials", "keys/orchestrator"]].concat());
    let of = |member: &str| observe(&endpoint, &at.join("keys").join(member));
    let orchestrator = of("orchestrator");
    let rights = cosim::distributed::all_rights("left");
    let mut wrong = Vec::new();
    for (role, member) in [("worker", "left"), ("observer", "observer")] {
        let session = of(member);
        for (pattern, key) in [
            ("**", "cosim/1/r/status"),
            ("cosim/**", "cosim/1/r/status"),
            ("cosim/1/*/status", "cosim/1/r/status"),
            ("cosim/@1/**", "cosim/@1/running/r"),
            ("cosim/@1/run/**", "cosim/@1/run/r/right/fmu/00"),
            ("cosim/@1/run/*/*/fmu/*", "cosim/@1/run/r/right/fmu/00"),
            ("cosim/@1/run/*/*/*/cmd/*", "cosim/@1/run/r/right/0.1/cmd/quick"),
            ("cosim/@1/run/*/*/*/rep/*", "cosim/@1/run/r/right/0.1/rep/quick"),
            ("cosim/@1/run/*/*/*/alive/*", "cosim/@1/run/r/right/0.1/alive/quick"),
            ("cosim/@pool/**", "cosim/@pool/1/right/start"),
            ("cosim/@pool/1/*", "cosim/@pool/1/right"),
        ] {
            for verb in Verb::ALL {
                let may = rights.iter().any(|(who, does, keys)| {
                    (*who == role || *who == "anybody") && *does == verb && includes(keys, pattern)
                });
                let does = tries((&orchestrator, key), (&session, pattern), verb, may);
                if does != may {
                    wrong.push(format!("{role} {verb:?} {pattern}: {does}, not {may}"));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Whether a member can do that with its key, seen from the orchestrator and its key. If it `may`,
/// the effect is waited for.
fn tries(
    orchestrator: (&zenoh::Session, &str),
    member: (&zenoh::Session, &str),
    verb: Verb,
    may: bool,
) -> bool {
    let patience = if may { Duration::from_secs(10) } else { Duration::from_millis(150) };
    let answers = |(session, key): (&zenoh::Session, &str)| {
        let asked = session.get(key).payload("x").timeout(patience).wait().unwrap();
        asked.into_iter().any(|reply| reply.result().is_ok())
    };
    let lives = |(session, key): (&zenoh::Session, &str)| {
        let asked = session.liveliness().get(key).timeout(patience).wait().unwrap();
        asked.into_iter().any(|reply| reply.result().is_ok())
    };
    let serve = |(session, key): (&zenoh::Session, &str)| {
        let queryable = session.declare_queryable(key.to_owned()).callback(|query| {
            drop(query.reply(query.key_expr().clone(), "x").wait());
        });
        let queryable = queryable.wait().unwrap();
        fence(session);
        queryable
    };
    let hears = |from: (&zenoh::Session, &str), to: (&zenoh::Session, &str)| {
        let heard = to.0.declare_subscriber(to.1.to_owned()).wait().unwrap();
        [to.0, from.0].into_iter().for_each(fence);
        from.0.put(from.1, "x").wait().unwrap();
        [from.0, to.0].into_iter().for_each(fence);
        heard.recv_timeout(patience).unwrap().is_some()
    };
    let announce = |(session, key): (&zenoh::Session, &str)| {
        let token = session.liveliness().declare_token(key.to_owned()).wait().unwrap();
        fence(session);
        token
    };
    match verb {
        Verb::Publish => hears(member, orchestrator),
        Verb::Hear => hears(orchestrator, member),
        Verb::Announce => {
            let _token = announce(member);
            lives(orchestrator)
        }
        Verb::Follow => {
            let _token = announce(orchestrator);
            lives(member)
        }
        Verb::Serve => {
            let _served = serve(member);
            answers(orchestrator)
        }
        Verb::Ask => {
            let _served = serve(orchestrator);
            answers(member)
        }
    }
}
