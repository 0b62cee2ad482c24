//! Live instances and saved states by number.
//!
//! A handle is `generation << 32 | tag | slot + 1`, passed through C as if it were a pointer and
//! never dereferenced; the tag distinguishes handles of instances from those of states. Looking up
//! any number is sound, and a freed slot gets a new generation, so an old handle no longer matches
//! it. A call enters its slot by one compare-and-exchange of the slot's generation together with
//! the mark that a call is in progress: of threads that come at once, with any functions, one gets
//! in and the others are rejected.
//!
//! The first slots are part of the library's own memory. Further slots are allocated when needed
//! and dropped when the library is unloaded, or by the last call that is still in progress.

use std::cell::UnsafeCell;
use std::ffi::c_void;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError, RwLock};

use crate::kernel::{Request, Served, spare};

/// Slots that need no allocation, and slots of each further allocation.
const BLOCK: usize = 1024;
/// Maximum number of slots.
const MOST: u32 = 1 << 20;
/// In a slot's word: a call is in progress.
const BUSY: u64 = 1;

/// What the C interface requires of a library.
pub trait Library: 'static {
    /// What it serves.
    type Instance: Served;
    /// Maximum memory for making an instance (bytes). It is requested in one piece first: if it is
    /// not available, there is no instance, but the host survives.
    const MEMORY: usize = 4 << 20;

    /// A new instance.
    ///
    /// # Errors
    /// The reason for the failure, for the log.
    fn instantiate(request: Request<'_>) -> Result<Self::Instance, String>;

    /// Storage for its instances: a static of the library.
    fn shelf() -> &'static Shelf<Self::Instance>;

    /// Drops everything made for all instances; called when the library is unloaded or the process
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

/// An instance and the handles of its states, which are freed with it.
pub(super) struct Live<I> {
    pub(super) instance: I,
    pub(super) states: Vec<usize>,
}

/// Objects by number.
pub(super) struct Handles<T, const TAG: u32> {
    first: [Slot<T>; BLOCK],
    beyond: RwLock<Vec<Arc<[Slot<T>]>>>,
    free: Mutex<Free>,
}

/// The slots that can be used next.
struct Free {
    /// One more than the index of the slot freed last, whose word contains the same for the one
    /// before it; 0: there is none.
    last: u32,
    /// How many slots were ever used.
    used: u32,
}

/// On its own cache line, so that threads with their own instances do not wait for each other.
#[repr(align(64))]
struct Slot<T> {
    /// `generation << 32` and, while the slot is in use (odd generations), [`BUSY`] during a call;
    /// otherwise the next free slot.
    word: AtomicU64,
    thing: UnsafeCell<Option<Box<T>>>,
}

// SAFETY: `thing` is accessed only by the thread that set `BUSY` (a caller of `with` or `remove`)
// or took the slot from the free list (`insert`), and may move between threads.
unsafe impl<T: Send> Sync for Slot<T> {}
// SAFETY: as above.
unsafe impl<T: Send> Send for Slot<T> {}

impl<T> Slot<T> {
    const fn new() -> Self {
        Self { word: AtomicU64::new(0), thing: UnsafeCell::new(None) }
    }

    /// Enters if the object of that generation is in this slot and no call is in progress.
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

/// Why a handle is not usable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Nothing {
    /// It was freed, or never issued.
    Dead,
    /// A call on it has not returned yet.
    Busy,
}

/// A call in a slot; it leaves even if the work panics.
struct Inside<'a, T> {
    slot: &'a Slot<T>,
    /// The word to store on leaving.
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

    /// Drops the slots beyond the first if they are empty and not in use.
    fn unload(&self) {
        let Ok(mut blocks) = self.beyond.try_write() else {
            return;
        };
        let lives = |slot: &Slot<T>| slot.word.load(Ordering::Relaxed) >> 32 & 1 == 1;
        if !blocks.iter().flat_map(|block| &block[..]).any(lives) {
            *blocks = Vec::new();
        }
    }

    /// Works with the slot of that index, if there is one.
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

    /// The index of a free slot; `None` if there are too many, or no memory for more.
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

    /// Gives an object a handle; `None` if there are a million already, or no memory for more.
    pub(super) fn insert(&self, thing: Box<T>) -> Option<*mut c_void> {
        let index = self.take()?;
        let generation = self.at(index, |slot| {
            // SAFETY: the slot came from the free list and its generation is even, so nothing else
            // accesses the cell.
            unsafe { *slot.thing.get() = Some(thing) };
            let generation = ((slot.word.load(Ordering::Relaxed) >> 32) as u32).wrapping_add(1);
            slot.word.store(u64::from(generation) << 32, Ordering::Release);
            generation
        })?;
        let handle = (generation as usize) << 32 | (TAG | (index as u32 + 1)) as usize;
        Some(std::ptr::without_provenance_mut(handle))
    }

    /// Works in the slot of a handle, if its object exists and is in no other call.
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

    /// Whether a handle is valid.
    pub(super) fn lives(&self, handle: *mut c_void) -> bool {
        let (index, generation) = Self::parts(handle);
        let alive = |slot: &Slot<T>| (slot.word.load(Ordering::Relaxed) >> 32) as u32 == generation;
        generation & 1 == 1 && self.at(index, alive) == Some(true)
    }

    /// Calls `work` with the object of a handle.
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

    /// Takes an object out; its handle is invalid from here on.
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
