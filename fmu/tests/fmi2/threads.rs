//! Threads that share an instance, which FMI forbids: errors and no harm.

use std::sync::Barrier;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use fmu_kit::kernel::Status;

use crate::components::fmi2;
use crate::driver::{CS, Fmu};

const THREADS: usize = 4;

/// Lets threads work on an instance at once, many times over.
fn together(rounds: usize, work: impl Fn(usize) + Sync) {
    let (barrier, instance) = (Barrier::new(THREADS), AtomicUsize::new(0));
    thread::scope(|scope| {
        for thread in 0..THREADS {
            let (barrier, instance, work) = (&barrier, &instance, &work);
            scope.spawn(move || {
                // Freed by the work; the logs stay until everything is done.
                let mut all = Vec::new();
                for _ in 0..rounds {
                    if thread == 0 {
                        let made = Fmu::started("Noise", CS);
                        instance.store(made.c.addr(), Ordering::Relaxed);
                        all.push(made);
                    }
                    barrier.wait();
                    work(instance.load(Ordering::Relaxed));
                    barrier.wait();
                }
            });
        }
    });
}

fn reset(instance: usize) -> Status {
    unsafe { fmi2::fmi2Reset(std::ptr::without_provenance_mut(instance)) }
}

fn free(instance: usize) {
    unsafe { fmi2::fmi2FreeInstance(std::ptr::without_provenance_mut(instance)) }
}

#[test]
fn of_threads_that_free_at_once_one_does() {
    together(2000, |instance| {
        free(instance);
        assert_eq!(reset(instance), Status::Error);
    });
}

#[test]
fn of_threads_that_call_at_once_one_gets_in_at_a_time() {
    let done = AtomicUsize::new(0);
    let rounds = 500;
    together(rounds, |instance| {
        // The logger's memory is not thread-safe: only calls that log nothing.
        done.fetch_add(usize::from(reset(instance) == Status::Ok), Ordering::Relaxed);
    });
    assert!(done.load(Ordering::Relaxed) >= rounds);
}

#[test]
fn more_instances_than_slots_of_the_library_itself() {
    let many: Vec<Fmu> = (0..2500).map(|_| Fmu::new("Noise", CS)).collect();
    let handles: Vec<usize> = many.iter().map(|fmu| fmu.c.addr()).collect();
    assert!(handles.iter().all(|handle| reset(*handle) == Status::Ok));
    drop(many);
    assert!(handles.iter().all(|handle| reset(*handle) == Status::Error));
}
