//! System calls that a confined FMU does not get, each for itself.

use tempfile::TempDir;

use crate::attacks::{attacker, one_component};
use crate::distributed::outcome;

/// Calls into other namespaces and about other processes.
const CALLS: [&str; 20] = [
    "unshare(CLONE_NEWUSER)",
    "unshare(CLONE_NEWNET)",
    "setns(0, 0)",
    "begin(CLONE_NEWUSER)",
    "begin(CLONE_NEWPID | CLONE_NEWUSER)",
    "begin(CLONE_NEWNET)",
    "sched_setscheduler(getppid(), SCHED_BATCH, &none)",
    "sched_setparam(getppid(), &none)",
    "syscall(SYS_sched_setattr, getppid(), many, 0)",
    "sched_setaffinity(getppid(), sizeof all, &all)",
    "setpriority(PRIO_PROCESS, getppid(), 1)",
    "setpriority(PRIO_USER, 0, 1)",
    "syscall(SYS_ioprio_set, 1, getppid(), 3 << 13)",
    "syscall(SYS_prlimit64, getppid(), RLIMIT_CORE, many, 0)",
    "syscall(SYS_migrate_pages, getppid(), 8, many, many)",
    "syscall(SYS_move_pages, getppid(), 0, 0, 0, 0, 0)",
    "syscall(SYS_process_vm_readv, getppid(), 0, 0, 0, 0, 0)",
    "syscall(SYS_process_vm_writev, getppid(), 0, 0, 0, 0, 0)",
    "syscall(SYS_ptrace, 16, getppid(), 0, 0)",
    "syscall(SYS_kcmp, getppid(), getppid(), 0, 0, 0)",
];

#[test]
fn calls_into_namespaces_and_about_other_processes_are_refused() {
    if cosim::confine::unconfined().is_some() {
        eprintln!("skipped: this kernel has no Landlock that knows networks");
        return;
    }
    let folder = TempDir::new().unwrap();
    let named = "struct sched_param none = {0}; long many[16] = {sizeof many}; \
                 cpu_set_t all; sched_getaffinity(0, sizeof all, &all);";
    let calls: Vec<String> = CALLS.iter().map(|call| format!("TRY({call})")).collect();
    let fmu = attacker(folder.path(), &format!("{named} {}", calls.join("; ")));
    let system = one_component(fmu.to_str().unwrap());
    std::fs::write(folder.path().join("s.ssd"), system).unwrap();
    for more in [&["--isolate"][..], &["--isolate", "--execution-tool"], &["--workers", "1"]] {
        let arguments = [&["run", "s.ssd", "-o", "out.csv"][..], more].concat();
        let (code, shown) = outcome(folder.path(), &arguments);
        assert_eq!(code, 0, "{more:?}: {shown}");
        for call in CALLS {
            let refused = format!("tried {call}: Operation not permitted");
            assert!(shown.contains(&refused), "{more:?} {call}: {shown}");
        }
    }
}
