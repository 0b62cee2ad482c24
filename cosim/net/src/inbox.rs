//! A queue from the callbacks of a session to the one thread that handles their messages.
//!
//! Waking a thread costs more than everything that is done with a message. A waiting thread
//! therefore says how many messages it needs and is not woken for fewer for a short time, unless
//! one is urgent. It is woken after the lock is released, because it needs the lock next.

use std::collections::VecDeque;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// For this long, fewer messages than needed do not wake the thread; steps that take longer are not
/// affected.
const WHILE: Duration = Duration::from_millis(1);

/// Messages for one thread.
pub(super) struct Inbox<T>(Arc<Shared<T>>);

/// Puts messages into an [`Inbox`].
pub(super) struct Slot<T>(Arc<Shared<T>>);

struct Shared<T> {
    state: Mutex<State<T>>,
    woken: Condvar,
}

struct State<T> {
    messages: VecDeque<T>,
    /// A thread sleeps until there are this many messages.
    wanted: Option<usize>,
}

impl<T> Inbox<T> {
    /// An empty one.
    pub(super) fn new() -> Self {
        let state = Mutex::new(State { messages: VecDeque::new(), wanted: None });
        Self(Arc::new(Shared { state, woken: Condvar::new() }))
    }

    /// A handle for a callback.
    pub(super) fn slot(&self) -> Slot<T> {
        Slot(self.0.clone())
    }

    /// The next message. If there is none, sleeps for at most `patience` until one arrives; for a
    /// short time at first until `wanted` have arrived, or an urgent one.
    pub(super) fn next(&self, wanted: usize, patience: Duration) -> Option<T> {
        let mut state = self.0.lock();
        let mut patience = patience;
        if state.messages.is_empty() && wanted > 1 {
            state = self.0.sleep(state, wanted, patience.min(WHILE));
            patience = patience.saturating_sub(WHILE);
        }
        if state.messages.is_empty() {
            state = self.0.sleep(state, 1, patience);
        }
        state.messages.pop_front()
    }
}

impl<T> Slot<T> {
    /// Adds a message.
    pub(super) fn put(&self, message: T) {
        self.leave(message, false);
    }

    /// Adds a message that must be handled now.
    pub(super) fn put_urgent(&self, message: T) {
        self.leave(message, true);
    }

    fn leave(&self, message: T, urgent: bool) {
        let mut state = self.0.lock();
        state.messages.push_back(message);
        let count = state.messages.len();
        let awaited = state.wanted.take_if(|wanted| urgent || count >= *wanted);
        drop(state);
        if awaited.is_some() {
            self.0.woken.notify_one();
        }
    }
}

impl<T> Clone for Slot<T> {
    fn clone(&self) -> Self {
        Self(self.0.clone())
    }
}

impl<T> Shared<T> {
    /// Sleeps until `wanted` messages are there, an urgent one arrives, or the time is over.
    fn sleep<'a>(
        &'a self,
        mut state: MutexGuard<'a, State<T>>,
        wanted: usize,
        time: Duration,
    ) -> MutexGuard<'a, State<T>> {
        state.wanted = Some(wanted);
        let sleeps = |state: &mut State<T>| state.wanted.is_some();
        let mut state = if time == Duration::MAX {
            self.woken.wait_while(state, sleeps).unwrap_or_else(PoisonError::into_inner)
        } else {
            let slept = self.woken.wait_timeout_while(state, time, sleeps);
            slept.unwrap_or_else(PoisonError::into_inner).0
        };
        state.wanted = None;
        state
    }

    fn lock(&self) -> MutexGuard<'_, State<T>> {
        // The queue is consistent even if a thread panicked while it held the lock.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LONG: Duration = Duration::from_secs(60);

    #[test]
    fn messages_come_in_order_and_those_that_are_there_at_once() {
        let inbox = Inbox::new();
        (0..3).for_each(|number| inbox.slot().put(number));
        let taken: Vec<i32> = (0..3).filter_map(|_| inbox.next(9, LONG)).collect();
        assert_eq!(taken, [0, 1, 2]);
        assert_eq!(inbox.next(1, Duration::ZERO), None);
    }

    #[test]
    fn a_sleeping_thread_is_woken_by_as_many_as_it_waits_for_or_by_an_urgent_one() {
        let shared = Inbox::new().0;
        let slot = Slot(shared.clone());
        let sleep = |wanted| {
            let state = shared.sleep(shared.lock(), wanted, LONG);
            state.messages.iter().copied().collect::<Vec<i32>>()
        };
        // A sleeping thread sets `wanted` before it releases the lock.
        let when_asleep = |leave: fn(&Slot<i32>)| {
            let slot = slot.clone();
            std::thread::spawn(move || {
                while slot.0.lock().wanted.is_none() {
                    std::thread::yield_now();
                }
                leave(&slot);
            })
        };
        let sender = when_asleep(|slot| (1..=3).for_each(|number| slot.put(number)));
        assert_eq!(sleep(3), [1, 2, 3]);
        sender.join().unwrap();
        let sender = when_asleep(|slot| slot.put_urgent(4));
        assert_eq!(sleep(9), [1, 2, 3, 4]);
        sender.join().unwrap();
    }

    #[test]
    fn one_that_stays_alone_is_taken_after_a_while() {
        let inbox = Inbox::new();
        let slot = inbox.slot();
        let sender = std::thread::spawn(move || {
            while slot.0.lock().wanted.is_none() {
                std::thread::yield_now();
            }
            slot.put(1);
        });
        assert_eq!(inbox.next(2, LONG), Some(1));
        sender.join().unwrap();
    }
}
