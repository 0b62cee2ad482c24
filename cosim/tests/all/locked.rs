//! Authentication and authorization through the binary: a refused client gets the reason, and
//! FMUs can do only what they are allowed to.

use std::net::TcpListener;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Stdio};
use std::time::Duration;

use cosim::distributed::Verb;
use rcgen::{CertificateParams, DnType, Issuer, KeyPair};
use tempfile::TempDir;
use zenoh::Wait;

use crate::distributed::{chain, cosim, outcome, results, signal};
use crate::models::Model;
use crate::ssd::Ssd;

/// A process that ends with the test.
pub(crate) struct Running(pub(crate) Child);

impl Drop for Running {
    fn drop(&mut self) {
        signal(self.0.id(), "-TERM");
        // A stopped process does not receive the signal.
        signal(self.0.id(), "-CONT");
        let _ = self.0.wait();
    }
}

pub(crate) fn start(folder: &Path, arguments: &[&str]) -> Running {
    let mut command = cosim(folder, arguments);
    Running(command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap())
}

pub(crate) fn free_port() -> u16 {
    TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port()
}

/// Keys of two authorities, `keys` and `others`.
fn keys() -> TempDir {
    let folder = TempDir::new().unwrap();
    for name in ["keys", "others"] {
        let arguments = ["keys", name, "--worker", "left", "--worker", "right"];
        let (code, stderr) = outcome(folder.path(), &arguments);
        assert_eq!(code, 0, "{stderr}");
    }
    folder
}

/// A folder of credentials made from files of others.
fn mixed(folder: &Path, name: &str, files: [(&str, String); 3]) {
    let place = folder.join(name);
    std::fs::create_dir(&place).unwrap();
    for (file, content) in files {
        std::fs::write(place.join(file), content).unwrap();
    }
}

fn text(folder: &Path, file: &str) -> String {
    std::fs::read_to_string(folder.join(file)).unwrap()
}

fn common_name(certificate: &str) -> String {
    let (_, pem) = x509_parser::pem::parse_x509_pem(certificate.as_bytes()).unwrap();
    let certificate = pem.parse_x509().unwrap();
    let name = certificate.subject().iter_common_name().next().unwrap();
    name.as_str().unwrap().to_owned()
}

/// A certificate of the authority `keys` for the days given, from now.
fn dated(folder: &Path, name: &str, days: std::ops::Range<i64>) {
    let key = KeyPair::from_pem(&text(folder, "keys/authority/ca.key.pem")).unwrap();
    let mut authority = CertificateParams::default();
    authority.distinguished_name = rcgen::DistinguishedName::new();
    authority
        .distinguished_name
        .push(DnType::CommonName, common_name(&text(folder, "keys/authority/ca.pem")));
    let mut params = CertificateParams::new(["localhost".to_owned()]).unwrap();
    let now = time::OffsetDateTime::now_utc();
    params.not_before = now + time::Duration::days(days.start);
    params.not_after = now + time::Duration::days(days.end);
    let own = KeyPair::generate().unwrap();
    let certificate = params.signed_by(&own, &Issuer::new(authority, key)).unwrap();
    let ca = text(folder, "keys/authority/ca.pem");
    let files = [("ca.pem", ca), ("cert.pem", certificate.pem()), ("key.pem", own.serialize_pem())];
    mixed(folder, name, files);
}

#[test]
fn keys_are_for_their_owner_and_never_overwritten() {
    let folder = keys();
    let mut files = Vec::new();
    for member in ["authority", "orchestrator", "left", "right", "observer"] {
        let place = folder.path().join("keys").join(member);
        assert_eq!(std::fs::metadata(&place).unwrap().permissions().mode() & 0o777, 0o700);
        files.extend(std::fs::read_dir(place).unwrap().map(|entry| entry.unwrap().path()));
    }
    assert_eq!(files.len(), 2 + 4 + 3 * 3);
    for file in files {
        assert_eq!(std::fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o600);
    }
    let (code, stderr) = outcome(folder.path(), &["keys", "keys"]);
    assert_eq!(code, 1, "{stderr}");
    assert!(stderr.contains("never overwritten"), "{stderr}");
    for name in ["../x", "", "a b", ".x", "orchestrator"] {
        let (code, _) = outcome(folder.path(), &["keys", "new", "--worker", name]);
        assert_eq!((code, folder.path().join("new").exists()), (2, false), "{name}");
    }
}

/// A TLS connection is corrupted if one thread of Zenoh sends while another receives.
#[test]
fn tls_is_refused_with_more_threads() {
    let (folder, endpoint) = (keys(), format!("tls/127.0.0.1:{}", free_port()));
    let workers = ["workers", "--wait", "0.1", "--listen", &endpoint];
    let arguments = [&workers[..], &["--credentials", "keys/orchestrator"]].concat();
    for threads in ["(app:(worker_threads:2))", "(rx:(handover:app))"] {
        let mut command = cosim(folder.path(), &arguments);
        let output = command.env("ZENOH_RUNTIME", threads).output().unwrap();
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{stderr}");
        assert!(stderr.contains("TLS needs one thread") && stderr.contains(threads), "{stderr}");
    }
    let (code, stderr) = outcome(folder.path(), &arguments);
    assert_eq!(code, 0, "{stderr}");
}

#[test]
fn a_refusal_says_which_it_is() {
    let folder = keys();
    let at = folder.path();
    let ca = |name: &str| text(at, &format!("{name}/authority/ca.pem"));
    let both = ca("keys") + &ca("others");
    let of = |member: &str, file: &str| text(at, &format!("{member}/{file}"));
    let certificate = |member: &str| ("cert.pem", of(member, "cert.pem"));
    let key = |member: &str| ("key.pem", of(member, "key.pem"));
    mixed(at, "foreign", [("ca.pem", ca("keys")), certificate("others/left"), key("others/left")]);
    mixed(at, "trusting", [("ca.pem", both), certificate("others/left"), key("others/left")]);
    mixed(at, "swapped", [("ca.pem", ca("keys")), certificate("keys/left"), key("keys/right")]);
    mixed(
        at,
        "garbled",
        [("ca.pem", ca("keys")), ("cert.pem", "no certificate".to_owned()), key("keys/left")],
    );
    mixed(
        at,
        "keyless",
        [
            ("ca.pem", ca("keys")),
            certificate("keys/left"),
            ("key.pem", of("keys/left", "cert.pem")),
        ],
    );
    std::fs::create_dir(at.join("empty")).unwrap();
    dated(at, "expired", -10..-1);
    dated(at, "early", 1..10);
    let port = free_port();
    let listen = format!("tls/0.0.0.0:{port}");
    let listening =
        ["workers", "--listen", &listen, "--credentials", "keys/orchestrator", "--wait", "100"];
    let _listening = start(at, &listening);
    while std::net::TcpStream::connect(("127.0.0.1", port)).is_err() {
        std::thread::sleep(Duration::from_millis(10));
    }
    let tls = format!("tls/127.0.0.1:{port}");
    let elsewhere = format!("tls/127.0.0.2:{port}");
    let plain = format!("tcp/127.0.0.1:{port}");
    for (endpoint, credentials, name, error) in [
        (&tls, "others/left", "left", "[E506] no trust", "another authority than ours"),
        (&elsewhere, "keys/left", "left", "[E506] no trust", "not for the name 127.0.0.2"),
        (&tls, "empty", "left", "[E506] a certificate or key is missing", "empty/ca.pem"),
        (
            &tls,
            "foreign",
            "left",
            "[E506] the certificate was not issued by the authority",
            "UnknownIssuer",
        ),
        (&tls, "trusting", "left", "[E506] no trust", "does not know the authority of our"),
        (&tls, "swapped", "left", "[E506] the key does not match", "swapped/key.pem"),
        (&tls, "garbled", "left", "[E506] it contains no certificate", "garbled/cert.pem"),
        (&tls, "keyless", "left", "[E506] it contains no private key", "keyless/key.pem"),
        (&tls, "expired", "left", "[E506] the certificate has expired", "valid until"),
        (&tls, "early", "left", "[E506] the certificate is not valid yet", "valid from"),
        (&tls, "keys/observer", "observer", "[E507]", "that name as an observer"),
        (&tls, "keys/left", "right", "[E507]", "certificate of 'left'"),
        (&plain, "keys/left", "left", "[E504]", "answers, but not as"),
    ]
    .map(|(endpoint, credentials, name, what, why)| (endpoint, credentials, name, [what, why]))
    {
        let arguments =
            ["worker", "--name", name, "--connect", endpoint, "--credentials", credentials];
        let (code, stderr) = outcome(at, &arguments);
        assert_eq!(code, 1, "{credentials}: {stderr}");
        for part in error {
            assert!(stderr.contains(part), "{credentials}: {stderr}");
        }
    }
}

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

/// Runs `file` on one worker that is started with `lent`: the run's exit code and stderr.
pub(crate) fn on_worker(
    at: &Path,
    file: &Path,
    lent: &[&str],
    environment: &[(&str, &str)],
) -> (i32, String) {
    let endpoint = format!("tcp/127.0.0.1:{}", free_port());
    let run = ["run", file.to_str().unwrap(), "-o", "there.csv", "--distributed"];
    let run = [&run[..], &["--deadline", "1"]].concat();
    let mut command = cosim(at, &[&run[..], &["--listen", &endpoint]].concat());
    let run = command.stderr(Stdio::piped()).stdout(Stdio::null()).spawn().unwrap();
    let worker = ["worker", "--name", "w", "--connect", &endpoint];
    let mut worker = cosim(at, &[&worker[..], lent].concat());
    worker.envs(environment.iter().copied()).stdout(Stdio::null()).stderr(Stdio::null());
    let _worker = Running(worker.spawn().unwrap());
    let output = run.wait_with_output().unwrap();
    (output.status.code().unwrap_or(-1), String::from_utf8_lossy(&output.stderr).into_owned())
}

#[test]
fn a_worker_loads_only_what_was_allowed_there() {
    let (folder, system) = (TempDir::new().unwrap(), Ssd::new().add("pump", Model::Gain).stop(1.0));
    let (at, file) = (folder.path(), system.write());
    let fmu = Model::Gain.fmu();
    let other = Model::Clock.fmu();
    let (code, stderr) = on_worker(at, &file, &["--allow", other.to_str().unwrap()], &[]);
    assert_eq!(code, 1, "{stderr}");
    let hash = sha256(&fmu);
    for part in ["[E508] pump: this worker does not load", &hash, "--allow-upload", "worker w"] {
        assert!(stderr.contains(part), "{stderr}");
    }
    let allowed = [fmu.to_str().unwrap(), &hash];
    for allowed in allowed {
        let (code, stderr) = on_worker(at, &file, &["--allow", allowed], &[]);
        assert_eq!(code, 0, "{stderr}");
    }
    let (code, stderr) = outcome(at, &["worker", "--allow", "nothing.fmu"]);
    assert_eq!(code, 3, "{stderr}");
}

fn sha256(file: &Path) -> String {
    use sha2::{Digest, Sha256};
    let hash = Sha256::digest(std::fs::read(file).unwrap());
    hash.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The kernel version, as far as it matters for Landlock.
fn has_landlock() -> bool {
    let release = std::fs::read_to_string("/proc/sys/kernel/osrelease").unwrap();
    let mut numbers = release.split(['.', '-']).map(|n| n.parse::<u32>().unwrap_or(0));
    (numbers.next(), numbers.next()) >= (Some(6), Some(7))
        && cosim::distributed::unconfined().is_none()
}

#[test]
fn an_fmu_of_a_worker_writes_only_in_its_folder_and_makes_no_connections() {
    let (folder, home) = (TempDir::new().unwrap(), TempDir::new().unwrap());
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = f64::from(listener.local_addr().unwrap().port());
    let system = Ssd::new().add_with("spy", Model::Nosy, &[("k", port)], None).stop(1.0);
    let (at, file) = (folder.path(), system.write());
    let environment = [("HOME", home.path().to_str().unwrap())];
    let run = |lent: &[&str]| {
        let (code, stderr) =
            on_worker(at, &file, &[&["--allow-upload"], lent].concat(), &environment);
        assert_eq!(code, 0, "{stderr}");
        (stderr, home.path().join("nosy.txt").exists())
    };
    if has_landlock() {
        let (said, written) = run(&[]);
        let wanted = "home: Permission denied; network: Permission denied; own folder: done";
        assert!(said.contains(wanted), "{said}");
        assert!(!written);
    } else {
        eprintln!("skipped: this kernel has no Landlock that knows networks");
    }
    let (said, written) = run(&["--no-confine"]);
    assert!(said.contains("home: done; network: done; own folder: done"), "{said}");
    assert!(written);
}

#[test]
fn a_configuration_file_weakens_no_protection() {
    let folder = TempDir::new().unwrap();
    let write = |text: &str| -> PathBuf {
        let file = folder.path().join("c.json5");
        std::fs::write(&file, text).unwrap();
        file
    };
    for (text, code, part) in [
        ("{ cosim: { connect: 'tcp/192.0.2.1:7447' } }", 1, "--insecure"),
        ("{ cosim: { conect: 'tcp/127.0.0.1:7447' } }", 3, "did you mean 'connect'?"),
        (
            "{ cosim: { connect: 'tls/127.0.0.1:7447', credentials: 'nowhere' } }",
            1,
            "nowhere/ca.pem",
        ),
        ("{ scouting: { multicast: { enabled: true } } }", 3, "[E509] scouting by multicast"),
    ] {
        let file = write(text);
        let arguments = ["worker", "--config", file.to_str().unwrap()];
        let (found, stderr) = outcome(folder.path(), &arguments);
        assert_eq!(found, code, "{text}: {stderr}");
        assert!(stderr.contains(part), "{text}: {stderr}");
    }
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
                let does = tries(&orchestrator, &session, verb, key, may);
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

/// Whether `member` can do that, seen from the orchestrator. If it `may`, the effect is waited for.
fn tries(
    orchestrator: &zenoh::Session,
    member: &zenoh::Session,
    verb: Verb,
    key: &str,
    may: bool,
) -> bool {
    let patience = if may { Duration::from_secs(10) } else { Duration::from_millis(150) };
    let answers = |session: &zenoh::Session| {
        let asked = session.get(key).payload("x").timeout(patience).wait().unwrap();
        asked.into_iter().any(|reply| reply.result().is_ok())
    };
    let lives = |session: &zenoh::Session| {
        let asked = session.liveliness().get(key).timeout(patience).wait().unwrap();
        asked.into_iter().any(|reply| reply.result().is_ok())
    };
    let serve = |session: &zenoh::Session| {
        let queryable = session.declare_queryable(key).callback(|query| {
            drop(query.reply(query.key_expr().clone(), "x").wait());
        });
        let queryable = queryable.wait().unwrap();
        fence(session);
        queryable
    };
    let hears = |from: &zenoh::Session, to: &zenoh::Session| {
        let heard = to.declare_subscriber(key).wait().unwrap();
        [to, from].into_iter().for_each(fence);
        from.put(key, "x").wait().unwrap();
        [from, to].into_iter().for_each(fence);
        heard.recv_timeout(patience).unwrap().is_some()
    };
    let announce = |session: &zenoh::Session| {
        let token = session.liveliness().declare_token(key).wait().unwrap();
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
