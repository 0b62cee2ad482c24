//! Live instances and saved states by number.
//!
//! A handle is `generation << 32 | tag | slot + 1`, passed through C as if it were a pointer and
//! never followed; the tag tells the handles of instances and of states apart. Slots live in blocks
//! that are never freed, so looking up any number whatsoever is sound; a freed slot gets a new
//! generation, so an old handle does not fit it any more. Looking up takes two atomic loads and no
//! lock.

use std::cell::UnsafeCell;
use std::ffi::c_void;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Mutex, OnceLock, PoisonError};

use crate::kernel::{Request, Served};

const BLOCK: usize = 256;
const BLOCKS: usize = 4096;

/// What the C interface of a library needs of it.
pub trait Library: 'static {
    /// What it serves.
    type Instance: Served;

    /// A new instance.
    ///
    /// # Errors
    /// Why there is none, for the log.
    fn instantiate(request: Request<'_>) -> Result<Self::Instance, String>;

    /// Where its instances live: a static of the library.
    fn shelf() -> &'static Shelf<Self::Instance>;
}

/// The live instances of a library and their saved states.
pub struct Shelf<I: Served> {
    pub(super) instances: Handles<Live<I>>,
    pub(super) states: Handles<I::State>,
}

impl<I: Served> Shelf<I> {
    /// An empty one.
    #[must_use]
    #[expect(clippy::new_without_default, reason = "it is made once, for a static")]
    pub const fn new() -> Self {
        Self { instances: Handles::new(0), states: Handles::new(1 << 31) }
    }
}

/// An instance and the handles of its states, which go when it goes.
pub(super) struct Live<I> {
    pub(super) instance: I,
    pub(super) states: Vec<usize>,
}

/// Things by number.
pub(super) struct Handles<T> {
    tag: u32,
    table: [OnceLock<Box<[Slot<T>]>>; BLOCKS],
    /// Slots to use next, and how many were ever used.
    free: Mutex<(Vec<u32>, u32)>,
}

struct Slot<T> {
    /// Odd while something lives here.
    generation: AtomicU32,
    /// Set during a call, so that a logger calling back in, or a second thread, is turned away.
    busy: AtomicBool,
    thing: UnsafeCell<Option<Box<T>>>,
}

// SAFETY: `thing` is reached only by who holds `busy` (a caller of `with` or `remove`) or by who
// took the slot from the free list (`insert`), and may go from thread to thread.
unsafe impl<T: Send> Sync for Slot<T> {}

impl<T> Slot<T> {
    const fn new() -> Self {
        Self {
            generation: AtomicU32::new(0),
            busy: AtomicBool::new(false),
            thing: UnsafeCell::new(None),
        }
    }
}

/// Why a handle does not lead anywhere.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Nothing {
    /// It was freed, or never given out.
    Dead,
    /// A call on it has not returned yet.
    Busy,
}

/// Leaves a slot even when the work on it panics.
struct Leave<'a, T>(&'a Slot<T>);

impl<T> Drop for Leave<'_, T> {
    fn drop(&mut self) {
        self.0.busy.store(false, Ordering::Release);
    }
}

impl<T> Handles<T> {
    const fn new(tag: u32) -> Self {
        Self { tag, table: [const { OnceLock::new() }; BLOCKS], free: Mutex::new((Vec::new(), 0)) }
    }

    #[inline]
    fn slot(&self, index: usize) -> Option<&Slot<T>> {
        self.table.get(index / BLOCK)?.get()?.get(index % BLOCK)
    }

    /// Gives a thing a handle; `None` if there are a million already.
    pub(super) fn insert(&self, thing: Box<T>) -> Option<*mut c_void> {
        let mut free = self.free.lock().unwrap_or_else(PoisonError::into_inner);
        let index = match free.0.pop() {
            Some(index) => index,
            None => {
                let index = free.1;
                self.table
                    .get(index as usize / BLOCK)?
                    .get_or_init(|| (0..BLOCK).map(|_| Slot::new()).collect());
                free.1 += 1;
                index
            }
        };
        drop(free);
        let slot = self.slot(index as usize)?;
        // SAFETY: the slot came from the free list and its generation is even, so nobody else
        // reaches the cell.
        unsafe { *slot.thing.get() = Some(thing) };
        let generation = slot.generation.load(Ordering::Relaxed).wrapping_add(1);
        slot.generation.store(generation, Ordering::Release);
        let handle = (generation as usize) << 32 | (self.tag | (index + 1)) as usize;
        Some(std::ptr::without_provenance_mut(handle))
    }

    /// The slot a handle leads to, if its thing lives and is not in a call.
    #[inline]
    fn enter(&self, handle: *mut c_void) -> Result<(u32, Leave<'_, T>), Nothing> {
        let handle = handle.addr();
        let index = (handle as u32 ^ self.tag).checked_sub(1).ok_or(Nothing::Dead)?;
        let slot = self.slot(index as usize).ok_or(Nothing::Dead)?;
        let generation = (handle >> 32) as u32;
        if generation & 1 == 0 || slot.generation.load(Ordering::Acquire) != generation {
            return Err(Nothing::Dead);
        }
        if slot.busy.load(Ordering::Acquire) {
            return Err(Nothing::Busy);
        }
        slot.busy.store(true, Ordering::Relaxed);
        Ok((index, Leave(slot)))
    }

    /// Whether a handle leads to something.
    pub(super) fn lives(&self, handle: *mut c_void) -> bool {
        !matches!(self.enter(handle), Err(Nothing::Dead))
    }

    /// Calls `work` with the thing of a handle.
    #[inline]
    pub(super) fn with<R>(
        &self,
        handle: *mut c_void,
        work: impl FnOnce(&mut T) -> R,
    ) -> Result<R, Nothing> {
        let (_, slot) = self.enter(handle)?;
        // SAFETY: `enter` found the thing alive and marked it busy; `Leave` unmarks it only after
        // the reference is gone.
        match unsafe { &mut *slot.0.thing.get() } {
            Some(thing) => Ok(work(thing)),
            None => Err(Nothing::Dead),
        }
    }

    /// Takes a thing out; its handle is dead from here on.
    pub(super) fn remove(&self, handle: *mut c_void) -> Result<Box<T>, Nothing> {
        let (index, slot) = self.enter(handle)?;
        let generation = slot.0.generation.load(Ordering::Relaxed).wrapping_add(1);
        slot.0.generation.store(generation, Ordering::Release);
        // SAFETY: as in `with`; the new generation keeps everyone else out from here on.
        let thing = unsafe { (*slot.0.thing.get()).take() };
        drop(slot);
        let mut free = self.free.lock().unwrap_or_else(PoisonError::into_inner);
        free.0.push(index);
        thing.ok_or(Nothing::Dead)
    }
}
