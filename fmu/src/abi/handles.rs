//! Live instances by number.
//!
//! A handle is `generation << 32 | slot + 1`, passed through C as if it were a pointer and never
//! followed. Slots live in blocks that are never freed, so looking up any number whatsoever is
//! sound; a freed slot gets a new generation, so an old handle does not fit it any more.
//! Looking up takes two atomic loads and no lock.

use std::cell::UnsafeCell;
use std::ffi::c_void;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Mutex, OnceLock, PoisonError};

use crate::kernel::Instance;

const BLOCK: usize = 256;
const BLOCKS: usize = 4096;

struct Slot {
    /// Odd while an instance lives here.
    generation: AtomicU32,
    /// Set during a call, so that a logger calling back in, or a second thread, is turned away.
    busy: AtomicBool,
    instance: UnsafeCell<Option<Box<Instance>>>,
}

// SAFETY: `instance` is reached only by who holds `busy` (a caller of `with` or `remove`) or by
// who took the slot from the free list (`insert`); FMI lets one thread at a time call an instance.
unsafe impl Sync for Slot {}

impl Slot {
    const fn new() -> Self {
        Self {
            generation: AtomicU32::new(0),
            busy: AtomicBool::new(false),
            instance: UnsafeCell::new(None),
        }
    }
}

static TABLE: [OnceLock<Box<[Slot]>>; BLOCKS] = [const { OnceLock::new() }; BLOCKS];

/// Slots to use next, and how many were ever used.
static FREE: Mutex<(Vec<u32>, u32)> = Mutex::new((Vec::new(), 0));

/// Why a handle does not lead to an instance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum NoInstance {
    /// It was freed, or never given out.
    Dead,
    /// A call on it has not returned yet.
    Busy,
}

fn slot(index: u32) -> Option<&'static Slot> {
    let index = index as usize;
    TABLE.get(index / BLOCK)?.get()?.get(index % BLOCK)
}

/// Gives an instance a handle; `None` if there are a million already.
pub(super) fn insert(instance: Box<Instance>) -> Option<*mut c_void> {
    let mut free = FREE.lock().unwrap_or_else(PoisonError::into_inner);
    let index = match free.0.pop() {
        Some(index) => index,
        None => {
            let index = free.1;
            TABLE
                .get(index as usize / BLOCK)?
                .get_or_init(|| (0..BLOCK).map(|_| Slot::new()).collect());
            free.1 += 1;
            index
        }
    };
    drop(free);
    let slot = slot(index)?;
    // SAFETY: the slot came from the free list and its generation is even, so nobody else
    // reaches the cell.
    unsafe { *slot.instance.get() = Some(instance) };
    let generation = slot.generation.load(Ordering::Relaxed).wrapping_add(1);
    slot.generation.store(generation, Ordering::Release);
    let handle = (generation as usize) << 32 | (index as usize + 1);
    Some(std::ptr::without_provenance_mut(handle))
}

/// The slot a handle leads to, if its instance lives and is not in a call.
#[inline]
fn enter(handle: *mut c_void) -> Result<&'static Slot, NoInstance> {
    let handle = handle.addr();
    let index = (handle as u32).checked_sub(1).ok_or(NoInstance::Dead)?;
    let slot = slot(index).ok_or(NoInstance::Dead)?;
    let generation = (handle >> 32) as u32;
    if generation & 1 == 0 || slot.generation.load(Ordering::Acquire) != generation {
        return Err(NoInstance::Dead);
    }
    if slot.busy.load(Ordering::Acquire) {
        return Err(NoInstance::Busy);
    }
    slot.busy.store(true, Ordering::Relaxed);
    Ok(slot)
}

/// Calls `work` with the instance of a handle.
#[inline]
pub(super) fn with<R>(
    handle: *mut c_void,
    work: impl FnOnce(&mut Instance) -> R,
) -> Result<R, NoInstance> {
    /// Leaves the slot even when `work` panics.
    struct Leave(&'static Slot);
    impl Drop for Leave {
        fn drop(&mut self) {
            self.0.busy.store(false, Ordering::Release);
        }
    }
    let slot = Leave(enter(handle)?);
    // SAFETY: `enter` found the instance alive and marked it busy; `Leave` unmarks it only after
    // the reference is gone.
    match unsafe { &mut *slot.0.instance.get() } {
        Some(instance) => Ok(work(instance)),
        None => Err(NoInstance::Dead),
    }
}

/// Takes an instance out; its handle is dead from here on.
pub(super) fn remove(handle: *mut c_void) -> Result<Box<Instance>, NoInstance> {
    let slot = enter(handle)?;
    let generation = slot.generation.load(Ordering::Relaxed).wrapping_add(1);
    slot.generation.store(generation, Ordering::Release);
    // SAFETY: as in `with`; the new generation keeps everyone else out from here on.
    let instance = unsafe { (*slot.instance.get()).take() };
    slot.busy.store(false, Ordering::Release);
    let index = (handle.addr() as u32).wrapping_sub(1);
    FREE.lock()
        .unwrap_or_else(PoisonError::into_inner)
        .0
        .push(index);
    instance.ok_or(NoInstance::Dead)
}
