//! The system calls that FMUs do not get (seccomp): those that change permissions and times of
//! files, open sockets, start programs, stop or kill processes, inspect other processes, or are
//! meant for administrators. Landlock does not cover these.
//!
//! The filter is a program for the kernel's BPF machine: it loads the number of a call and, where
//! that is not enough, one of its arguments.
#![allow(unsafe_code, reason = "system calls without a safe form")]

use std::io;

use libc::{c_long, sock_filter};

/// Whether a process may start others.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Programs {
    /// It may, because all of them end with it.
    Allowed,
    /// It runs alone.
    Refused,
}

/// The kernel's name for this architecture (`AUDIT_ARCH_...`).
#[cfg(target_arch = "x86_64")]
const MACHINE: u32 = 0xc000_003e;
#[cfg(target_arch = "aarch64")]
const MACHINE: u32 = 0xc000_00b7;

/// Calls of the x32 ABI, which x86-64 has as well.
#[cfg(target_arch = "x86_64")]
const OTHER_ABI: u32 = 0x4000_0000;

/// Permissions, owners, times and attributes of files, and devices.
const ATTRIBUTES: &[c_long] = &[
    libc::SYS_fchmod,
    libc::SYS_fchmodat,
    452, // fchmodat2
    libc::SYS_fchown,
    libc::SYS_fchownat,
    libc::SYS_utimensat,
    libc::SYS_setxattr,
    libc::SYS_lsetxattr,
    libc::SYS_fsetxattr,
    libc::SYS_removexattr,
    libc::SYS_lremovexattr,
    libc::SYS_fremovexattr,
    463, // setxattrat
    466, // removexattrat
    469, // file_setattr
    libc::SYS_mknodat,
];

/// The same under names that only x86-64 has.
#[cfg(target_arch = "x86_64")]
const OLD_ATTRIBUTES: &[c_long] = &[
    libc::SYS_chmod,
    libc::SYS_chown,
    libc::SYS_lchown,
    libc::SYS_utime,
    libc::SYS_utimes,
    libc::SYS_futimesat,
    libc::SYS_mknod,
];
#[cfg(not(target_arch = "x86_64"))]
const OLD_ATTRIBUTES: &[c_long] = &[];

/// Channels to other processes: networks, shared memory and queues of the same user.
const CHANNELS: &[c_long] = &[
    libc::SYS_socket,
    libc::SYS_connect,
    libc::SYS_bind,
    libc::SYS_listen,
    libc::SYS_shmget,
    libc::SYS_shmat,
    libc::SYS_shmctl,
    libc::SYS_msgget,
    libc::SYS_msgsnd,
    libc::SYS_msgrcv,
    libc::SYS_msgctl,
    libc::SYS_semget,
    libc::SYS_semop,
    libc::SYS_semctl,
    libc::SYS_mq_open,
    libc::SYS_mq_unlink,
    // They would do all of these on behalf of the caller.
    libc::SYS_io_uring_setup,
    libc::SYS_io_uring_enter,
    libc::SYS_io_uring_register,
];

/// Calls that inspect other processes, change the environment of the process, or are meant for
/// administrators.
const KERNEL: &[c_long] = &[
    libc::SYS_ptrace,
    libc::SYS_process_vm_writev,
    libc::SYS_kcmp,
    438, // pidfd_getfd
    440, // process_madvise
    libc::SYS_unshare,
    libc::SYS_setns,
    libc::SYS_chroot,
    libc::SYS_pivot_root,
    libc::SYS_mount,
    libc::SYS_umount2,
    428, // open_tree
    429, // move_mount
    430, // fsopen
    431, // fsconfig
    432, // fsmount
    433, // fspick
    442, // mount_setattr
    libc::SYS_open_by_handle_at,
    libc::SYS_name_to_handle_at,
    libc::SYS_bpf,
    libc::SYS_perf_event_open,
    libc::SYS_userfaultfd,
    libc::SYS_fanotify_init,
    libc::SYS_add_key,
    libc::SYS_request_key,
    libc::SYS_keyctl,
    libc::SYS_kexec_load,
    libc::SYS_init_module,
    libc::SYS_finit_module,
    libc::SYS_delete_module,
    libc::SYS_reboot,
    libc::SYS_swapon,
    libc::SYS_swapoff,
    libc::SYS_quotactl,
    libc::SYS_acct,
    libc::SYS_syslog,
    libc::SYS_personality,
    libc::SYS_settimeofday,
    libc::SYS_clock_settime,
    libc::SYS_adjtimex,
    libc::SYS_clock_adjtime,
    libc::SYS_sethostname,
    libc::SYS_setdomainname,
    libc::SYS_setpriority,
    libc::SYS_ioprio_set,
];
#[cfg(target_arch = "x86_64")]
const OLD_KERNEL: &[c_long] = &[libc::SYS_iopl, libc::SYS_ioperm, libc::SYS_modify_ldt];
#[cfg(not(target_arch = "x86_64"))]
const OLD_KERNEL: &[c_long] = &[];

/// Calls that start programs; new processes are distinguished from threads by an argument.
const EXECUTE: &[c_long] = &[libc::SYS_execve, libc::SYS_execveat];
#[cfg(target_arch = "x86_64")]
const FORK: &[c_long] = &[libc::SYS_fork, libc::SYS_vfork];
#[cfg(not(target_arch = "x86_64"))]
const FORK: &[c_long] = &[];

/// Which argument of a call is a signal.
const SIGNALS: &[(c_long, u32)] = &[
    (libc::SYS_kill, 1),
    (libc::SYS_tkill, 1),
    (libc::SYS_tgkill, 2),
    (libc::SYS_rt_sigqueueinfo, 1),
    (libc::SYS_rt_tgsigqueueinfo, 2),
    (424, 1), // pidfd_send_signal
];
/// Signals that look to others as if a user had stopped or killed the process.
const STOPPING: &[libc::c_int] =
    &[libc::SIGKILL, libc::SIGSTOP, libc::SIGTSTP, libc::SIGTTIN, libc::SIGTTOU];

/// For terminals: typing on behalf of the user.
const TYPING: &[libc::c_ulong] = &[0x5412 /* TIOCSTI */, 0x541c /* TIOCLINUX */];
/// For processes: outliving the parent.
const TIES: &[libc::c_int] = &[libc::PR_SET_PDEATHSIG, libc::PR_SET_CHILD_SUBREAPER];

/// Calls about how another process is scheduled and where its memory is; the first argument is the
/// process, 0 for the caller.
const SCHEDULING: &[c_long] = &[
    libc::SYS_sched_setaffinity,
    libc::SYS_sched_setscheduler,
    libc::SYS_sched_setparam,
    libc::SYS_sched_setattr,
    libc::SYS_move_pages,
    libc::SYS_migrate_pages,
];

/// New namespaces, as flags of `clone`.
const NAMESPACES: libc::c_int = libc::CLONE_NEWNS
    | libc::CLONE_NEWCGROUP
    | libc::CLONE_NEWUTS
    | libc::CLONE_NEWIPC
    | libc::CLONE_NEWUSER
    | libc::CLONE_NEWPID
    | libc::CLONE_NEWNET;

const ALLOW: u32 = libc::SECCOMP_RET_ALLOW;

fn errno(number: libc::c_int) -> u32 {
    libc::SECCOMP_RET_ERRNO | number as u32
}

/// Offsets of number, architecture and arguments in the data that the kernel passes to a filter.
const NUMBER: u32 = 0;
const ARCHITECTURE: u32 = 4;
fn argument(position: u32) -> u32 {
    // Little-endian: the lower half comes first.
    16 + 8 * position
}

/// A filter under construction: instructions in sequence.
struct Program(Vec<sock_filter>);

impl Program {
    fn push(&mut self, code: u32, jt: u8, jf: u8, k: u32) {
        self.0.push(sock_filter { code: code as u16, jt, jf, k });
    }

    fn load(&mut self, place: u32) {
        self.push(libc::BPF_LD | libc::BPF_W | libc::BPF_ABS, 0, 0, place);
    }

    fn give(&mut self, what: u32) {
        self.push(libc::BPF_RET | libc::BPF_K, 0, 0, what);
    }

    /// Returns `what` if the loaded value is equal.
    fn when(&mut self, value: u32, what: u32) {
        self.push(libc::BPF_JMP | libc::BPF_JEQ | libc::BPF_K, 0, 1, value);
        self.give(what);
    }

    fn calls(&mut self, calls: &[c_long], what: u32) {
        calls.iter().for_each(|&call| self.when(call as u32, what));
    }

    /// For one call: what `inside` writes, after which the number is loaded again.
    fn of(&mut self, call: c_long, inside: impl FnOnce(&mut Self)) {
        let mut own = Self(Vec::new());
        inside(&mut own);
        own.load(NUMBER);
        self.push(libc::BPF_JMP | libc::BPF_JEQ | libc::BPF_K, 0, own.0.len() as u8, call as u32);
        self.0.extend(own.0);
    }

    /// Returns `what` for one call if that argument is one of these values.
    fn argument(&mut self, call: c_long, position: u32, values: &[u32], what: u32) {
        self.of(call, |inside| {
            inside.load(argument(position));
            values.iter().for_each(|&value| inside.when(value, what));
        });
    }
}

fn program(programs: Programs) -> Vec<sock_filter> {
    let (denied, no_network) = (errno(libc::EPERM), errno(libc::EACCES));
    let mut p = Program(Vec::new());
    p.load(ARCHITECTURE);
    p.push(libc::BPF_JMP | libc::BPF_JEQ | libc::BPF_K, 1, 0, MACHINE);
    p.give(libc::SECCOMP_RET_KILL_PROCESS);
    p.load(NUMBER);
    #[cfg(target_arch = "x86_64")]
    {
        p.push(libc::BPF_JMP | libc::BPF_JGE | libc::BPF_K, 0, 1, OTHER_ABI);
        p.give(errno(libc::ENOSYS));
    }
    for calls in [ATTRIBUTES, OLD_ATTRIBUTES, KERNEL, OLD_KERNEL] {
        p.calls(calls, denied);
    }
    p.calls(CHANNELS, no_network);
    for &(call, position) in SIGNALS {
        let stopping: Vec<u32> = STOPPING.iter().map(|&signal| signal as u32).collect();
        p.argument(call, position, &stopping, denied);
    }
    let typing: Vec<u32> = TYPING.iter().map(|&request| request as u32).collect();
    p.argument(libc::SYS_ioctl, 1, &typing, denied);
    let ties: Vec<u32> = TIES.iter().map(|&option| option as u32).collect();
    p.argument(libc::SYS_prctl, 0, &ties, denied);
    // A process may set its own limits: they can only be lowered.
    p.of(libc::SYS_prlimit64, |inside| {
        inside.load(argument(0));
        inside.push(libc::BPF_JMP | libc::BPF_JEQ | libc::BPF_K, 1, 0, 0);
        inside.give(denied);
    });
    // It reads its own memory this way so that an invalid address is an error: texts of messages.
    p.of(libc::SYS_process_vm_readv, |inside| {
        inside.load(argument(0));
        inside.push(libc::BPF_JMP | libc::BPF_JEQ | libc::BPF_K, 1, 0, std::process::id());
        inside.give(denied);
    });
    for &call in SCHEDULING {
        p.of(call, |inside| {
            inside.load(argument(0));
            inside.push(libc::BPF_JMP | libc::BPF_JEQ | libc::BPF_K, 2, 0, 0);
            inside.push(libc::BPF_JMP | libc::BPF_JEQ | libc::BPF_K, 1, 0, std::process::id());
            inside.give(denied);
        });
    }
    p.of(libc::SYS_clone, |inside| {
        inside.load(argument(0));
        inside.push(libc::BPF_JMP | libc::BPF_JSET | libc::BPF_K, 0, 1, NAMESPACES as u32);
        inside.give(denied);
    });
    // Its arguments lie in memory, where a filter cannot look; the C library falls back.
    p.calls(&[libc::SYS_clone3], errno(libc::ENOSYS));
    if programs == Programs::Refused {
        p.calls(EXECUTE, denied);
        p.calls(FORK, denied);
        p.of(libc::SYS_clone, |inside| {
            inside.load(argument(0));
            let thread = libc::CLONE_THREAD as u32;
            inside.push(libc::BPF_JMP | libc::BPF_JSET | libc::BPF_K, 1, 0, thread);
            inside.give(denied);
        });
    }
    p.give(ALLOW);
    p.0
}

/// For all threads of this process, permanently.
pub(super) fn refuse(programs: Programs) -> io::Result<()> {
    let mut program = program(programs);
    let length = program.len().try_into().map_err(io::Error::other)?;
    let filter = libc::sock_fprog { len: length, filter: program.as_mut_ptr() };
    // SAFETY: the first call sets a flag of the process. The second reads the program, which lives
    // until it returns.
    unsafe {
        if libc::prctl(libc::PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0 {
            return Err(io::Error::last_os_error());
        }
        let (set, all) = (libc::SECCOMP_SET_MODE_FILTER, libc::SECCOMP_FILTER_FLAG_TSYNC);
        match libc::syscall(libc::SYS_seccomp, set, all, &raw const filter) {
            0 => Ok(()),
            _ => Err(io::Error::last_os_error()),
        }
    }
}

/// Whether a kernel has no filters.
pub(super) fn is_unknown(why: &io::Error) -> bool {
    matches!(why.raw_os_error(), Some(libc::ENOSYS | libc::EINVAL))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Jumps stay inside, the last instruction is a return, and the kernel takes at most 4096.
    #[test]
    fn the_filter_is_a_program_that_ends() {
        for programs in [Programs::Allowed, Programs::Refused] {
            let program = program(programs);
            assert!(program.len() <= 4096, "{}", program.len());
            for (at, instruction) in program.iter().enumerate() {
                let farthest = at + 1 + usize::from(instruction.jt.max(instruction.jf));
                assert!(farthest < program.len() || at + 1 == program.len(), "{at}");
            }
            let last = program.last().unwrap();
            assert_eq!(u32::from(last.code), libc::BPF_RET | libc::BPF_K);
        }
    }
}
