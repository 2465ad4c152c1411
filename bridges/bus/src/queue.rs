//! A queue with many senders and one receiver that spins a little before it parks.
//!
//! In lock-step an answer is usually microseconds away, and waking a parked thread costs tens of microseconds each
//! time. So the receiver first looks for a bounded while, then sleeps: a run that waits long burns nothing.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering, fence};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, Thread};
use std::time::{Duration, Instant};

/// How long a receiver looks before it parks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Spin(pub Duration);

impl Spin {
    /// Park at once.
    pub const NONE: Self = Self(Duration::ZERO);
}

/// About the cost of a wake-up; none on a single core, where the sender could not run meanwhile.
impl Default for Spin {
    fn default() -> Self {
        let cores = thread::available_parallelism().map_or(1, usize::from);
        if cores > 1 { Self(Duration::from_micros(40)) } else { Self::NONE }
    }
}

/// Looks at the queue between two looks at the clock and at other threads.
const LOOKS: u32 = 32;

#[derive(Debug)]
struct Shared<T> {
    items: Mutex<VecDeque<T>>,
    /// Length of `items`, so that an empty queue is seen without its lock.
    length: AtomicUsize,
    /// The receiver is about to park or parked.
    parked: AtomicBool,
    receiver: Mutex<Option<Thread>>,
}

impl<T> Shared<T> {
    /// A panic of another sender leaves a queue that is whole.
    fn lock(&self) -> MutexGuard<'_, VecDeque<T>> {
        self.items.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Makes a queue.
pub fn mailbox<T>(spin: Spin) -> (Post<T>, Mailbox<T>) {
    let shared = Arc::new(Shared {
        items: Mutex::new(VecDeque::new()),
        length: AtomicUsize::new(0),
        parked: AtomicBool::new(false),
        receiver: Mutex::new(None),
    });
    (Post(shared.clone()), Mailbox { shared, spin })
}

/// Sending side; cheap to clone, never blocks longer than another sender needs.
#[derive(Debug)]
pub struct Post<T>(Arc<Shared<T>>);

impl<T> Clone for Post<T> {
    fn clone(&self) -> Self {
        Self(self.0.clone())
    }
}

impl<T> Post<T> {
    /// Appends an item and wakes the receiver if it sleeps.
    pub fn send(&self, item: T) {
        let mut items = self.0.lock();
        items.push_back(item);
        self.0.length.store(items.len(), Ordering::Release);
        drop(items);
        // Pairs with the fence in `park`: either the receiver sees the length or this sees that it parks.
        fence(Ordering::SeqCst);
        if self.0.parked.swap(false, Ordering::Relaxed) {
            let receiver = self.0.receiver.lock().unwrap_or_else(PoisonError::into_inner);
            if let Some(thread) = receiver.as_ref() {
                thread.unpark();
            }
        }
    }
}

/// Receiving side.
#[derive(Debug)]
pub struct Mailbox<T> {
    shared: Arc<Shared<T>>,
    spin: Spin,
}

impl<T> Mailbox<T> {
    /// Whether nothing is there; one load, for use in inner loops.
    pub fn is_empty(&self) -> bool {
        self.shared.length.load(Ordering::Acquire) == 0
    }

    /// The oldest item, if there is one.
    pub fn try_receive(&mut self) -> Option<T> {
        if self.is_empty() {
            return None;
        }
        let mut items = self.shared.lock();
        let item = items.pop_front();
        self.shared.length.store(items.len(), Ordering::Release);
        item
    }

    /// The oldest item, waiting for one until `deadline`.
    pub fn receive_until(&mut self, deadline: Instant) -> Option<T> {
        if let Some(item) = self.try_receive() {
            return Some(item);
        }
        let start = Instant::now();
        let stop = deadline.min(start + self.spin.0);
        while Instant::now() < stop {
            for _ in 0..LOOKS {
                if !self.is_empty() {
                    return self.try_receive();
                }
                std::hint::spin_loop();
            }
            thread::yield_now();
        }
        loop {
            if let Some(item) = self.try_receive() {
                return Some(item);
            }
            let left = deadline.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return None;
            }
            self.park(left);
        }
    }

    fn park(&self, at_most: Duration) {
        *self.shared.receiver.lock().unwrap_or_else(PoisonError::into_inner) = Some(thread::current());
        self.shared.parked.store(true, Ordering::Relaxed);
        fence(Ordering::SeqCst);
        if self.is_empty() {
            thread::park_timeout(at_most);
        }
        self.shared.parked.store(false, Ordering::Relaxed);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn soon(ms: u64) -> Instant {
        Instant::now() + Duration::from_millis(ms)
    }

    #[test]
    fn items_come_in_order_and_then_time_passes() {
        let (post, mut mailbox) = mailbox(Spin::default());
        for i in 0..3 {
            post.send(i);
        }
        assert_eq!((0..3).map_while(|_| mailbox.receive_until(soon(0))).collect::<Vec<_>>(), [0, 1, 2]);
        let start = Instant::now();
        assert_eq!(mailbox.receive_until(soon(30)), None);
        assert!(start.elapsed() >= Duration::from_millis(30));
    }

    #[test]
    fn a_parked_receiver_is_woken() {
        for spin in [Spin::NONE, Spin(Duration::from_micros(40))] {
            let (post, mut mailbox) = mailbox(spin);
            let sender = thread::spawn(move || {
                thread::sleep(Duration::from_millis(20));
                post.send(7);
            });
            let start = Instant::now();
            assert_eq!(mailbox.receive_until(soon(5000)), Some(7));
            assert!(start.elapsed() < Duration::from_secs(2));
            sender.join().unwrap();
        }
    }

    /// A lost wake-up would leave the receiver asleep until its deadline.
    #[test]
    fn nothing_is_lost_between_many_senders_and_a_receiver_that_parks_often() {
        const EACH: usize = 20_000;
        for spin in [Spin::NONE, Spin(Duration::from_micros(2))] {
            let (post, mut mailbox) = mailbox(spin);
            let senders: Vec<_> = (0..3)
                .map(|s| {
                    let post = post.clone();
                    thread::spawn(move || {
                        for i in 0..EACH {
                            post.send((s, i));
                            if i % 64 == 0 {
                                thread::yield_now();
                            }
                        }
                    })
                })
                .collect();
            let mut next = [0; 3];
            for _ in 0..3 * EACH {
                let (s, i) = mailbox.receive_until(soon(3000)).expect("an item was lost or a wake-up was");
                assert_eq!(i, next[s], "order of one sender");
                next[s] += 1;
            }
            assert!(mailbox.is_empty());
            for sender in senders {
                sender.join().unwrap();
            }
        }
    }

    #[test]
    fn ping_pong_through_two_parked_queues_never_stalls() {
        let (ping, mut pinged) = mailbox(Spin::NONE);
        let (pong, mut ponged) = mailbox(Spin::NONE);
        let echo = thread::spawn(move || {
            for _ in 0..2000 {
                pong.send(pinged.receive_until(soon(3000)).expect("ping"));
            }
        });
        for i in 0..2000 {
            ping.send(i);
            assert_eq!(ponged.receive_until(soon(3000)), Some(i));
        }
        echo.join().unwrap();
    }
}
