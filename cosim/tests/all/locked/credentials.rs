//! Keys, certificates and configuration files.

use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::time::Duration;

use rcgen::{CertificateParams, DnType, Issuer, KeyPair};
use tempfile::TempDir;

use super::{free_port, keys, start, text};
use crate::distributed::{cosim, outcome};

/// A folder of credentials made from files of others.
fn mixed(folder: &Path, name: &str, files: [(&str, String); 3]) {
    let place = folder.join(name);
    std::fs::create_dir(&place).unwrap();
    for (file, content) in files {
        std::fs::write(place.join(file), content).unwrap();
    }
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

#[test]
fn a_configuration_file_weakens_no_protection() {
    let folder = TempDir::new().unwrap();
    let write = |text: &str| -> PathBuf {
        let file = folder.path().join("c.json5");
        std::fs::write(&file, text).unwrap();
        file
    };
    let deep = format!("{{ cosim: {}{} }}", "[".repeat(30_000), "]".repeat(30_000));
    for (text, code, part) in [
        ("{ cosim: { connect: 'tcp/192.0.2.1:7447' } }", 1, "--insecure"),
        ("{ cosim: { conect: 'tcp/127.0.0.1:7447' } }", 3, "did you mean 'connect'?"),
        (
            "{ cosim: { connect: 'tls/127.0.0.1:7447', credentials: 'nowhere' } }",
            1,
            "nowhere/ca.pem",
        ),
        (&deep, 3, "more than 64 levels"),
        ("{ scouting: { multicast: { enabled: true } } }", 3, "[E509] scouting by multicast"),
    ] {
        let file = write(text);
        let arguments = ["worker", "--config", file.to_str().unwrap()];
        let (found, stderr) = outcome(folder.path(), &arguments);
        assert_eq!(found, code, "{text}: {stderr}");
        assert!(stderr.contains(part), "{text}: {stderr}");
    }
}
