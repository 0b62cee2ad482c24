//! Live instances and saved states by number.
//!
//! A handle is `generation << 32 | tag | slot + 1`, passed through C as if it were a pointer and
//! never followed; the tag tells the handles of instances and of states apart. Looking up any number
//! whatsoever is sound, and a freed slot gets a new generation, so an old handle does not fit it any
//! more. A call enters its slot by one compare-and-exchange of the slot's generation together with
//! the mark that a call is in it: of threads that come at once, with whatever functions, one gets in
//! and the others are turned away.
//!
//! The first slots are part of the library's own memory. What is beyond is made when it is needed
//! and dropped when the library is unloaded, or by the last call that is still in it.

use std::cell::UnsafeCell;
use std::ffi::c_void;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError, RwLock};

use crate::kernel::{Request, Served, spare};

/// Slots that need no allocation, and slots of each allocation beyond.
const BLOCK: usize = 1024;
/// Most slots.
const MOST: u32 = 1 << 20;
/// In a slot's word: a call is in it.
const BUSY: u64 = 1;

/// What the C interface of a library needs of it.
pub trait Library: 'static {
    /// What it serves.
    type Instance: Served;
    /// Memory that making an instance takes at most (bytes). It is asked for in one piece first:
    /// where there is none, there is no instance, but still a host.
    const MEMORY: usize = 4 << 20;

    /// A new instance.
    ///
    /// # Errors
    /// Why there is none, for the log.
    fn instantiate(request: Request<'_>) -> Result<Self::Instance, String>;

    /// Where its instances live: a static of the library.
    fn shelf() -> &'static Shelf<Self::Instance>;

    /// Drops what was made for all instances; called when the library is unloaded or the process
    /// ends, when threads may still be in calls.
    fn unload() {}
}

/// The live instances of a library and their saved states.
pub struct Shelf<I: Served> {
    pub(super) instances: Handles<Live<I>, 0>,
    pub(super) states: Handles<I::State, { 1 << 31 }>,
}

impl<I: Served> Shelf<I> {
    /// An empty one.
    #[must_use]
    #[expect(clippy::new_without_default, reason = "it is made once, for a static")]
    pub const fn new() -> Self {
        Self { instances: Handles::new(), states: Handles::new() }
    }

    /// Drops the slots that are part of no library's memory.
    pub(super) fn unload(&self) {
        self.instances.unload();
        self.states.unload();
    }
}

/// An instance and the handles of its states, which go when it goes.
pub(super) struct Live<I> {
    pub(super) instance: I,
    pub(super) states: Vec<usize>,
}

/// Things by number.
pub(super) struct Handles<T, const TAG: u32> {
    first: [Slot<T>; BLOCK],
    beyond: RwLock<Vec<Arc<[Slot<T>]>>>,
    free: Mutex<Free>,
}

/// Which slots can be used next.
struct Free {
    /// One more than the index of the slot freed last, whose word holds the same for the one before
    /// it; 0: there is none.
    last: u32,
    /// How many slots were ever used.
    used: u32,
}

/// On a cache line of its own, so that threads with instances of their own do not wait for each
/// other.
#[repr(align(64))]
struct Slot<T> {
    /// `generation << 32` and, while something lives here (odd generations), [`BUSY`] during a call;
    /// while nothing does, the next free slot.
    word: AtomicU64,
    thing: UnsafeCell<Option<Box<T>>>,
}

// SAFETY: `thing` is reached only by who set `BUSY` (a caller of `with` or `remove`) or by who took
// the slot from the free list (`insert`), and may go from thread to thread.
unsafe impl<T: Send> Sync for Slot<T> {}
// SAFETY: as above.
unsafe impl<T: Send> Send for Slot<T> {}

impl<T> Slot<T> {
    const fn new() -> Self {
        Self { word: AtomicU64::new(0), thing: UnsafeCell::new(None) }
    }

    /// Enters if the thing of that generation lives here and no call is in it.
    #[inline]
    fn enter(&self, generation: u32) -> Result<Inside<'_, T>, Nothing> {
        let idle = u64::from(generation) << 32;
        if generation & 1 == 0 {
            return Err(Nothing::Dead);
        }
        match self.word.compare_exchange(idle, idle | BUSY, Ordering::Acquire, Ordering::Relaxed) {
            Ok(_) => Ok(Inside { slot: self, after: idle }),
            Err(word) if word == idle | BUSY => Err(Nothing::Busy),
            Err(_) => Err(Nothing::Dead),
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

/// A call in a slot; it leaves even when the work panics.
struct Inside<'a, T> {
    slot: &'a Slot<T>,
    /// The word it leaves behind.
    after: u64,
}

impl<T> Drop for Inside<'_, T> {
    #[inline]
    fn drop(&mut self) {
        self.slot.word.store(self.after, Ordering::Release);
    }
}

impl<T, const TAG: u32> Handles<T, TAG> {
    const fn new() -> Self {
        Self {
            first: [const { Slot::new() }; BLOCK],
            beyond: RwLock::new(Vec::new()),
            free: Mutex::new(Free { last: 0, used: 0 }),
        }
    }

    /// Drops the slots beyond the first if nothing lives there, and nobody is at them.
    fn unload(&self) {
        let Ok(mut blocks) = self.beyond.try_write() else {
            return;
        };
        let lives = |slot: &Slot<T>| slot.word.load(Ordering::Relaxed) >> 32 & 1 == 1;
        if !blocks.iter().flat_map(|block| &block[..]).any(lives) {
            *blocks = Vec::new();
        }
    }

    /// Works with a slot, if there is one of that index.
    #[inline(always)]
    fn at<R>(&self, index: usize, work: impl FnOnce(&Slot<T>) -> R) -> Option<R> {
        let beyond;
        let slot = match self.first.get(index) {
            Some(slot) => slot,
            None => {
                beyond = self.beyond(index)?;
                beyond.get(index % BLOCK)?
            }
        };
        Some(work(slot))
    }

    #[cold]
    #[inline(never)]
    fn beyond(&self, index: usize) -> Option<Arc<[Slot<T>]>> {
        let blocks = self.beyond.read().unwrap_or_else(PoisonError::into_inner);
        blocks.get(index / BLOCK - 1).cloned()
    }

    /// The index of a slot that nobody uses; `None` if there are too many, or no memory for more.
    fn take(&self) -> Option<usize> {
        let mut free = self.free.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(index) = free.last.checked_sub(1) {
            let before =
                self.at(index as usize, |slot| slot.word.load(Ordering::Relaxed) as u32)?;
            free.last = before;
            return Some(index as usize);
        }
        let index = free.used as usize;
        if free.used >= MOST {
            return None;
        }
        if index >= BLOCK && self.at(index, |_| ()).is_none() {
            spare(2 * BLOCK * size_of::<Slot<T>>()).ok()?;
            let mut blocks = self.beyond.write().unwrap_or_else(PoisonError::into_inner);
            blocks.push((0..BLOCK).map(|_| Slot::new()).collect());
        }
        free.used += 1;
        Some(index)
    }

    /// Gives a thing a handle; `None` if there are a million already, or no memory for more.
    pub(super) fn insert(&self, thing: Box<T>) -> Option<*mut c_void> {
        let index = self.take()?;
        let generation = self.at(index, |slot| {
            // SAFETY: the slot came from the free list and its generation is even, so nobody else
            // reaches the cell.
            unsafe { *slot.thing.get() = Some(thing) };
            let generation = ((slot.word.load(Ordering::Relaxed) >> 32) as u32).wrapping_add(1);
            slot.word.store(u64::from(generation) << 32, Ordering::Release);
            generation
        })?;
        let handle = (generation as usize) << 32 | (TAG | (index as u32 + 1)) as usize;
        Some(std::ptr::without_provenance_mut(handle))
    }

    /// Works in the slot that a handle leads to, if its thing lives and is in no other call.
    #[inline]
    fn enter<R>(
        &self,
        handle: *mut c_void,
        work: impl FnOnce(usize, Inside<'_, T>) -> R,
    ) -> Result<R, Nothing> {
        let (index, generation) = Self::parts(handle);
        let work = |slot: &Slot<T>| Ok(work(index, slot.enter(generation)?));
        self.at(index, work).unwrap_or(Err(Nothing::Dead))
    }

    /// The index and the generation in a handle.
    #[inline]
    fn parts(handle: *mut c_void) -> (usize, u32) {
        let handle = handle.addr();
        ((handle as u32 ^ TAG).wrapping_sub(1) as usize, (handle >> 32) as u32)
    }

    /// Whether a handle leads to something.
    pub(super) fn lives(&self, handle: *mut c_void) -> bool {
        let (index, generation) = Self::parts(handle);
        let alive = |slot: &Slot<T>| (slot.word.load(Ordering::Relaxed) >> 32) as u32 == generation;
        generation & 1 == 1 && self.at(index, alive) == Some(true)
    }

    /// Calls `work` with the thing of a handle.
    #[inline]
    pub(super) fn with<R>(
        &self,
        handle: *mut c_void,
        work: impl FnOnce(&mut T) -> R,
    ) -> Result<R, Nothing> {
        self.enter(handle, |_, inside| {
            // SAFETY: `enter` marked the slot busy; it leaves only after the reference is gone.
            match unsafe { &mut *inside.slot.thing.get() } {
                Some(thing) => Ok(work(thing)),
                None => Err(Nothing::Dead),
            }
        })?
    }

    /// Takes a thing out; its handle is dead from here on.
    pub(super) fn remove(&self, handle: *mut c_void) -> Result<Box<T>, Nothing> {
        self.enter(handle, |index, mut inside| {
            // SAFETY: as in `with`.
            let thing = unsafe { (*inside.slot.thing.get()).take() };
            let mut free = self.free.lock().unwrap_or_else(PoisonError::into_inner);
            let generation = ((inside.after >> 32) as u32).wrapping_add(1);
            inside.after = u64::from(generation) << 32 | u64::from(free.last);
            drop(inside);
            free.last = index as u32 + 1;
            thing.ok_or(Nothing::Dead)
        })?
    }
}
