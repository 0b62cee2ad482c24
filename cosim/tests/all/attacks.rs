//! What FMUs try, in the three places where they run: in the process of `cosim`, isolated, and on
//! workers. SECURITY.md contains the same table.

use std::os::unix::fs::MetadataExt;
use std::path::Path;
use std::process::Output;

use tempfile::TempDir;

use crate::distributed::{cosim, remaining};
use crate::locked::on_worker;
use crate::models::Model;
use crate::ssd::Ssd;

/// The outcome of an attack.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Came {
    /// It succeeded.
    Done,
    /// The kernel refused it.
    Refused,
    /// The run ended with an error that reports it.
    Ended,
    /// It was undone, and reported.
    SetBack,
}
use Came::{Done, Ended, Refused, SetBack};

/// An attack: as text, as C, and its outcome in the process, isolated, and on a worker.
const ATTACKS: [(&str, &str, [Came; 3]); 28] = [
    (
        "writes a file in the home folder",
        "REPORT(open(in_home(\"new\"), O_CREAT | O_WRONLY, 0600))",
        [Done, Refused, Refused],
    ),
    (
        "reads a file of the user",
        "REPORT(read_file(in_home(\"secret\")))",
        [Done, Refused, Refused],
    ),
    (
        "reads it with another thread of the process",
        "REPORT(read_elsewhere(in_home(\"secret\")))",
        [Done, Refused, Refused],
    ),
    (
        "changes the rights of a file",
        "REPORT(chmod(in_home(\"secret\"), 0644))",
        [Done, Refused, Refused],
    ),
    (
        "changes the owner of a file",
        "REPORT(chown(in_home(\"secret\"), getuid(), getgid()))",
        [Done, Refused, Refused],
    ),
    (
        "changes the times of a file",
        "REPORT(utimensat(AT_FDCWD, in_home(\"secret\"), NULL, 0))",
        [Done, Refused, Refused],
    ),
    ("removes a file", "REPORT(unlink(in_home(\"doomed\")))", [Done, Refused, Refused]),
    ("sends a datagram", "REPORT(send_udp(9))", [Done, Refused, Refused]),
    ("opens a Unix socket", "REPORT(socket(AF_UNIX, SOCK_STREAM, 0))", [Done, Refused, Refused]),
    (
        "starts a process that outlives the run",
        "const int child = fork(); if (!child) { setsid(); if (fork()) _exit(0); linger(in_home(\"lingers\")); } REPORT(child)",
        [Done, Refused, Refused],
    ),
    (
        "starts a program",
        "int ended = 0; const int child = fork(); \
         if (!child) { execl(\"/bin/true\", \"true\", NULL); _exit(127); } \
         if (child > 0) waitpid(child, &ended, 0); \
         REPORT(ended ? (errno = EACCES, -1) : child)",
        [Done, Refused, Refused],
    ),
    (
        "looks into the process that started it",
        "REPORT(read_file(in_proc(getppid(), \"environ\")))",
        [Done, Refused, Refused],
    ),
    (
        "sends a signal to the process that started it",
        "REPORT(getppid() ? kill(getppid(), SIGURG) : (errno = EPERM, -1))",
        [Done, Refused, Refused],
    ),
    (
        "changes the processors of the process that started it",
        "cpu_set_t s; sched_getaffinity(0, sizeof s, &s); \
         REPORT(getppid() ? sched_setaffinity(getppid(), sizeof s, &s) : (errno = EPERM, -1))",
        [Done, Refused, Refused],
    ),
    ("ends the process with abort()", "abort()", [Ended, Ended, Ended]),
    ("stops itself", "REPORT(raise(SIGSTOP) ? -1 : 0)", [Done, Refused, Refused]),
    ("ends the process with exit(0)", "exit(0)", [Ended, Ended, Ended]),
    ("ends the process with _exit(0)", "_exit(0)", [Ended, Ended, Ended]),
    ("ends the process by a system call", "syscall(SYS_exit_group, 0)", [Done, Ended, Ended]),
    ("kills its process", "kill(getpid(), SIGKILL); REPORT(-1)", [Ended, Refused, Refused]),
    ("sets the rounding of its neighbours", "fesetround(FE_UPWARD)", [SetBack, SetBack, SetBack]),
    (
        "flushes their subnormals to zero",
        "__builtin_ia32_ldmxcsr(__builtin_ia32_stmxcsr() | 0x8040)",
        [SetBack, SetBack, SetBack],
    ),
    ("changes the locale", "setlocale(LC_ALL, \"C.UTF-8\")", [SetBack, SetBack, SetBack]),
    ("changes the working folder", "if (chdir(\"/usr\")) REPORT(-1)", [SetBack, SetBack, SetBack]),
    (
        "takes SIGTERM and blocks SIGINT",
        "signal(SIGTERM, SIG_IGN); sigset_t s; sigemptyset(&s); sigaddset(&s, SIGINT); sigprocmask(SIG_BLOCK, &s, NULL)",
        [SetBack, SetBack, SetBack],
    ),
    ("changes the umask", "umask(0)", [SetBack, SetBack, SetBack]),
    ("closes the standard streams", "close(0); close(1); close(2)", [SetBack, SetBack, SetBack]),
    (
        "sends the standard streams elsewhere",
        "const int other = open(\"/dev/null\", O_RDWR); for (int k = 0; k < 3; k++) dup2(other, k)",
        [SetBack, SetBack, SetBack],
    ),
];

const PLACES: [&str; 3] = ["in process", "`--isolate`", "worker"];

/// A home folder with something to steal.
struct Home(TempDir);

impl Home {
    fn new() -> Self {
        let folder = TempDir::new().unwrap();
        for name in ["secret", "doomed"] {
            std::fs::write(folder.path().join(name), "x").unwrap();
        }
        Self(folder)
    }

    fn path(&self) -> &Path {
        self.0.path()
    }

    /// Names, rights and times of its files.
    fn contents(&self) -> Vec<(std::ffi::OsString, u32, i64, i64)> {
        let files = std::fs::read_dir(self.path()).unwrap().map(Result::unwrap);
        let files = files.map(|file| {
            let about = file.metadata().unwrap();
            (file.file_name(), about.mode(), about.mtime(), about.mtime_nsec())
        });
        let mut files: Vec<_> = files.collect();
        files.sort();
        files
    }
}

pub(crate) fn attacker(folder: &Path, attack: &str) -> std::path::PathBuf {
    let define = format!("ATTACK={attack}");
    Model::Gain.variant(&folder.join("attacker.fmu"), &[define.as_str()], |text| text)
}

/// Runs an FMU in one of the places.
fn run_in(place: usize, folder: &Path, home: &Path, fmu: &Path) -> Output {
    let fmu = fmu.to_str().unwrap();
    let system = folder.join("s.ssd");
    std::fs::write(&system, one_component(fmu)).unwrap();
    let system = system.to_str().unwrap();
    let arguments: &[&str] = match place {
        0 => &["run", system, "-o", "out.csv"],
        1 => &["run", system, "-o", "out.csv", "--isolate"],
        _ => &["run", system, "-o", "out.csv", "--workers", "1", "--recoveries", "3"],
    };
    cosim(folder, arguments).env("HOME", home).output().unwrap()
}

pub(crate) fn one_component(fmu: &str) -> String {
    format!(
        "<ssd:SystemStructureDescription xmlns:ssd='http://ssp-standard.org/SSP1/SystemStructureDescription' \
         version='1.0' name='s'><ssd:System name='s'><ssd:Elements><ssd:Component name='attacker' \
         type='application/x-fmu-sharedlibrary' source='{fmu}'/></ssd:Elements></ssd:System>\
         <ssd:DefaultExperiment startTime='0' stopTime='1'/></ssd:SystemStructureDescription>"
    )
}

fn came(output: &Output) -> (Option<Came>, String) {
    let shown = String::from_utf8_lossy(&output.stderr).into_owned();
    let reported: Vec<&str> =
        shown.lines().filter_map(|line| Some(line.split_once("attack: ")?.1)).collect();
    // In namespaces of its own a process sees neither others nor their files.
    let refusals = ["Operation not permitted", "Permission denied", "No such file or directory"];
    let came = if shown.contains("it was set back") {
        Some(SetBack)
    } else if let Some(other) = reported.iter().find(|reported| **reported != "done") {
        refusals.contains(other).then_some(Refused)
    } else if !output.status.success() {
        Some(Ended)
    } else {
        Some(Done)
    };
    (came, shown)
}

#[test]
fn on_workers_the_user_decides_which_files_are_read_and_the_system_does_not() {
    if cosim::confine::unconfined().is_some() {
        eprintln!("skipped: this kernel has no Landlock that knows networks");
        return;
    }
    let (folder, home) = (TempDir::new().unwrap(), Home::new());
    let secret = home.path().join("secret");
    let secret = secret.to_str().unwrap();
    let fmu = attacker(folder.path(), "REPORT(read_file(in_home(\"secret\")))");
    let named = format!(
        "><ssd:ParameterBindings><ssd:ParameterBinding><ssd:ParameterValues>\
         <ssv:ParameterSet xmlns:ssv='http://ssp-standard.org/SSP1/SystemStructureParameterValues' \
         version='1.0' name='p'><ssv:Parameters><ssv:Parameter name='text'>\
         <ssv:String value='{secret}'/></ssv:Parameter></ssv:Parameters></ssv:ParameterSet>\
         </ssd:ParameterValues></ssd:ParameterBinding></ssd:ParameterBindings></ssd:Component>"
    );
    let system = one_component(fmu.to_str().unwrap()).replacen(
        "/></ssd:Elements>",
        &format!("{named}</ssd:Elements>"),
        1,
    );
    std::fs::write(folder.path().join("s.ssd"), system).unwrap();
    let run = |more: &[&str]| {
        let arguments = [&["run", "s.ssd", "-o", "out.csv", "--workers", "1"][..], more].concat();
        came(&cosim(folder.path(), &arguments).env("HOME", home.path()).output().unwrap())
    };
    let by_name = format!("attacker.text={secret}");
    for (more, wanted) in [
        (&[][..], Refused),
        (&["--start-value", &by_name], Done),
        (&["--allow-read", secret], Done),
    ] {
        let (found, shown) = run(more);
        assert_eq!(found, Some(wanted), "{more:?}: {shown}");
    }
}

#[test]
fn what_comes_of_attacks_is_what_the_documentation_says() {
    if cosim::confine::unconfined().is_some() {
        eprintln!("skipped: this kernel has no Landlock that knows networks");
        return;
    }
    let folder = TempDir::new().unwrap();
    let mut wrong = Vec::new();
    for (name, attack, wanted) in ATTACKS {
        let fmu = attacker(folder.path(), attack);
        for (place, wanted) in wanted.into_iter().enumerate() {
            // A stopped process would have to time out.
            if (name, place) == ("stops itself", 0) {
                continue;
            }
            let home = Home::new();
            let before = home.contents();
            let output = run_in(place, folder.path(), home.path(), &fmu);
            let (found, shown) = came(&output);
            if wanted == Refused && home.contents() != before {
                wrong.push(format!("{name}, {}: it had an effect\n{shown}", PLACES[place]));
            }
            if found != Some(wanted) {
                wrong
                    .push(format!("{name}, {}: {found:?}, not {wanted:?}\n{shown}", PLACES[place]));
            }
            let lingers = std::fs::read_to_string(home.path().join("lingers"));
            let lingers: Vec<u32> = lingers.iter().filter_map(|id| id.parse().ok()).collect();
            let left = remaining(&lingers);
            if !left.is_empty() {
                wrong.push(format!("{name}, {}: {left:?} is left", PLACES[place]));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// The table in the form of the documentation.
fn table() -> String {
    let mut lines =
        vec![format!("| an FMU | {} |", PLACES.join(" | ")), "|---|---|---|---|".to_owned()];
    for (name, _, came) in ATTACKS {
        let came = came.map(|came| match came {
            Done => "succeeds",
            Refused => "is refused",
            Ended => "ends the run with an error",
            SetBack => "is set back and reported",
        });
        lines.push(format!("| {name} | {} |", came.join(" | ")));
    }
    lines.join("\n")
}

#[test]
fn the_table_stands_in_security_md() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../SECURITY.md");
    let text = std::fs::read_to_string(file).unwrap();
    assert!(text.contains(&table()), "SECURITY.md should have:\n{}", table());
}

/// Another FMU computes the same results, whatever an FMU does to the process, in one process and
/// in two.
#[test]
fn a_neighbour_computes_the_same() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    let system = Ssd::new()
        .add("clock", Model::Clock)
        .add("first", Model::Gain)
        .add("second", Model::Integrator)
        .connect("clock.y", "first.u")
        .connect("first.y", "second.u")
        .stop(200.0);
    let text = std::fs::read_to_string(system.write()).unwrap();
    let run = |fmu: &Path, more: &[&str]| {
        let gain = Model::Gain.fmu();
        let text = text.replace(gain.to_str().unwrap(), fmu.to_str().unwrap());
        std::fs::write(at.join("three.ssd"), text).unwrap();
        let arguments = [&["run", "three.ssd", "-o", "three.csv"][..], more].concat();
        let output = cosim(at, &arguments).output().unwrap();
        let shown = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{shown}");
        (std::fs::read(at.join("three.csv")).unwrap(), shown)
    };
    let (wanted, _) = run(&attacker(at, "(void)m"), &[]);
    // Once in the first steps, which slaves make, or in a direct one.
    let reports = |attack: &str, step: &str, more: &[&str]| {
        let defines = [format!("ATTACK={attack}"), format!("ATTACK_AT={step}")];
        let defines = defines.each_ref().map(String::as_str);
        let fmu = Model::Gain.variant(&at.join("attacker.fmu"), &defines, |text| text);
        let (found, shown) = run(&fmu, more);
        assert!(found == wanted, "{attack} {step} {more:?}: {shown}");
        let reported = "changed the floating-point environment";
        let line = shown.lines().find(|line| line.contains(reported));
        line.unwrap_or_else(|| panic!("{attack} {step} {more:?}: {shown}")).to_owned()
    };
    for attack in [
        "fesetround(FE_UPWARD)",
        "fesetround(FE_DOWNWARD)",
        "fesetround(FE_TOWARDZERO)",
        "__builtin_ia32_ldmxcsr(__builtin_ia32_stmxcsr() | 0x2000)",
        "__builtin_ia32_ldmxcsr(__builtin_ia32_stmxcsr() | 0x4000)",
        "unsigned short w; __asm__(\"fnstcw %0\" : \"=m\"(w)); w &= ~0x300; __asm__(\"fldcw %0\" :: \"m\"(w))",
        "__builtin_ia32_ldmxcsr(__builtin_ia32_stmxcsr() | 0x8000)",
        "__builtin_ia32_ldmxcsr(__builtin_ia32_stmxcsr() | 0x40)",
        "feenableexcept(FE_INEXACT)",
    ] {
        for step in ["3", "1000"] {
            for more in [&[][..], &["--workers", "2"]] {
                let line = reports(attack, step, more);
                let is_named = line.contains("first") && !line.contains("another component");
                assert!(is_named, "{attack} {step} {more:?}: {line}");
            }
        }
    }
    // If it only changes which exceptions trap, a direct step is not found at once.
    let traps = "__builtin_ia32_ldmxcsr(__builtin_ia32_stmxcsr() & ~0x200)";
    let line = reports(traps, "1000", &[]);
    assert!(line.contains("this or another component"), "{line}");
}

/// What an FMU that is not trusted prints contains no commands for a terminal.
#[test]
fn what_an_fmu_prints_commands_no_terminal() {
    let folder = TempDir::new().unwrap();
    let printing = "fprintf(stderr, \"a\\033]0;owned\\007b\\n\")";
    let fmu = attacker(folder.path(), printing);
    for place in [1, 2] {
        let output = run_in(place, folder.path(), folder.path(), &fmu);
        let shown = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success() && shown.contains("owned"), "{shown}");
        assert!(!shown.contains(['\u{1b}', '\u{7}']), "{}: {shown:?}", PLACES[place]);
    }
}

/// An FMU on a worker does not see the environment of the user.
#[test]
fn secrets_in_the_environment_stay_there() {
    let folder = TempDir::new().unwrap();
    let fmu = attacker(folder.path(), "REPORT(getenv(\"SECRET\") ? 0 : (errno = EPERM, -1))");
    for (place, wanted) in [(0, Done), (1, Refused), (2, Refused)] {
        let fmu = fmu.to_str().unwrap();
        std::fs::write(folder.path().join("s.ssd"), one_component(fmu)).unwrap();
        let more: &[&str] = [&[][..], &["--isolate"], &["--workers", "1"]][place];
        let arguments = [&["run", "s.ssd", "-o", "out.csv"][..], more].concat();
        let output = cosim(folder.path(), &arguments).env("SECRET", "x").output().unwrap();
        let (found, shown) = came(&output);
        assert_eq!(found, Some(wanted), "{}: {shown}", PLACES[place]);
    }
}

/// Everything an FMU starts ends with the run, even if nothing confines it.
#[test]
fn what_an_fmu_starts_ends_with_the_run() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    let lingering = "if (!fork()) { setsid(); if (fork()) _exit(0); linger(in_home(\"lingers\")); } \
                     for (int k = 0; k < 2000 && access(in_home(\"lingers\"), F_OK); k++) usleep(1000)";
    let fmu = attacker(at, lingering);
    let system = at.join("s.ssd");
    std::fs::write(&system, one_component(fmu.to_str().unwrap())).unwrap();
    for place in ["simulate", "run", "worker"] {
        let home = Home::new();
        let (code, shown) = match place {
            "worker" => {
                let environment = [("HOME", home.path().to_str().unwrap())];
                on_worker(at, &system, &["--allow-upload", "--no-confine"], &environment)
            }
            verb => {
                let file = if verb == "run" { &system } else { &fmu };
                let arguments = [verb, file.to_str().unwrap(), "-o", "out.csv"];
                let output = cosim(at, &arguments).env("HOME", home.path()).output().unwrap();
                let shown = String::from_utf8_lossy(&output.stderr).into_owned();
                (output.status.code().unwrap_or(-1), shown)
            }
        };
        assert_eq!(code, 0, "{place}: {shown}");
        let lingers = std::fs::read_to_string(home.path().join("lingers")).unwrap();
        let left = remaining(&[lingers.parse().unwrap()]);
        assert!(left.is_empty(), "{place}");
    }
}

/// An FMU that stops its process, without confinement or by a timer, looks like one stopped by a
/// user. It is not retried forever.
#[test]
fn an_fmu_that_stops_itself_ends_the_run() {
    let folder = TempDir::new().unwrap();
    let system = folder.path().join("s.ssd");
    for (attack, lent) in [
        ("raise(SIGSTOP)", &["--allow-upload", "--no-confine"][..]),
        ("timed(SIGSTOP)", &["--allow-upload"]),
        ("timed(SIGKILL)", &["--allow-upload"]),
    ] {
        let fmu = attacker(folder.path(), attack);
        std::fs::write(&system, one_component(fmu.to_str().unwrap())).unwrap();
        let (code, shown) = on_worker(folder.path(), &system, lent, &[]);
        assert_eq!(code, 1, "{attack}: {shown}");
        let named = shown.contains("[E502]") && shown.contains("stops or kills its own process");
        assert!(named, "{attack}: {shown}");
    }
}

/// A group whose process ends before it is ready is not waited for.
#[test]
fn a_group_that_dies_while_it_begins_is_noticed() {
    let folder = TempDir::new().unwrap();
    let (source, library) = (folder.path().join("dies.c"), folder.path().join("dies.so"));
    let text = "#include <stdio.h>\n#include <string.h>\n#include <unistd.h>\n\
                __attribute__((constructor)) static void die(void) { char line[4096];\n\
                FILE *file = fopen(\"/proc/self/cmdline\", \"r\");\n\
                size_t count = file ? fread(line, 1, sizeof line - 1, file) : 0; line[count] = 0;\n\
                if (count && !strcmp(line + strlen(line) + 1, \"group\")) _exit(7); }\n";
    std::fs::write(&source, text).unwrap();
    let mut compiler = std::process::Command::new("cc");
    compiler.args(["-shared", "-fPIC", "-o"]).args([&library, &source]);
    assert!(compiler.status().unwrap().success());
    let system = folder.path().join("s.ssd");
    let fmu = Model::Gain.fmu();
    std::fs::write(&system, one_component(fmu.to_str().unwrap())).unwrap();
    let environment = [("LD_PRELOAD", library.to_str().unwrap())];
    let (code, shown) =
        on_worker(folder.path(), &system, &["--allow-upload", "--no-confine"], &environment);
    assert_eq!(code, 1, "{shown}");
    assert!(shown.contains("ended before it was ready"), "{shown}");
    assert!(shown.contains("ended with code 7"), "{shown}");
}
