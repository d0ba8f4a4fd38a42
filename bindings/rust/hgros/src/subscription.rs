//! Receiving through queues.

use crate::convert::{nanoseconds, text};
use crate::error::{check, Result, Status};
use crate::message::Message;
use crate::schema::{Schema, Type};
use crate::session::Session;
use hgros_sys as sys;
use std::marker::PhantomData;
use std::os::unix::io::{AsFd, AsRawFd, BorrowedFd, RawFd};
use std::ptr::{null, null_mut, NonNull};
use std::time::Duration;

/// Which messages wait for the receiver.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub enum Queue {
    /// The newest ones; older ones are dropped and counted.
    KeepLast(u64),
    /// All, with room for this many: publishers get [`Status::Full`] while there is no room, or wait.
    KeepAll(u64),
    /// The same, with room for about this many bytes at most.
    KeepAllBytes { messages: u64, bytes: u64 },
}

impl Default for Queue {
    fn default() -> Self {
        Self::KeepLast(16)
    }
}

/// Which thread runs the callback of a [`Listener`](crate::Listener).
#[derive(Clone, Copy, Debug, Default, Eq, PartialEq)]
pub enum Executor {
    /// Worker threads of the session: for callbacks of any length.
    #[default]
    Workers,
    /// The thread that delivers: lowest latency; keep the callback short.
    Inline,
    /// A thread of its own.
    Dedicated,
}

/// Options of a subscription. A [`Queue`] alone will do.
#[derive(Clone, Debug, Default)]
pub struct SubscribeOptions {
    pub queue: Queue,
    /// For logs, tables and configuration; empty: channel and number.
    pub name: String,
    /// For callbacks only.
    pub executor: Executor,
}

impl From<Queue> for SubscribeOptions {
    fn from(queue: Queue) -> Self {
        Self {
            queue,
            ..Self::default()
        }
    }
}

/// Counters since a subscription began.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub struct Stats {
    /// Messages that reached it, including those dropped later.
    pub received: u64,
    /// Removed from a full queue.
    pub dropped: u64,
    /// Taken, or given to the callback.
    pub taken: u64,
    /// Waiting now.
    pub queued: u64,
    /// Not delivered: of another type.
    pub mismatched: u64,
}

/// What a queue gives: a protobuf message, or a [`Message`] as it came.
pub trait Receive: Sized {
    fn receive(message: Message) -> Result<Self>;
}

impl<T: Type> Receive for T {
    fn receive(message: Message) -> Result<Self> {
        message.decode()
    }
}

impl Receive for Message {
    fn receive(message: Message) -> Result<Self> {
        Ok(message)
    }
}

/// A queue of received messages. Any number of threads may take from it; each message goes to one.
///
/// Its descriptor is readable while messages wait, and once the queue has ended: for poll, epoll and event loops.
/// Neither read nor write it; call [`Subscription::try_recv`] until it returns None.
pub struct Subscription<T> {
    handle: NonNull<sys::hgros_subscription>,
    messages: PhantomData<fn() -> T>,
}

// SAFETY: any thread may take from the queue and end it; it is closed by its only owner, when nobody borrows it.
unsafe impl<T> Send for Subscription<T> {}
// SAFETY: as above.
unsafe impl<T> Sync for Subscription<T> {}

impl Session {
    /// Receives a channel of a protobuf type. Messages of another type are counted, not delivered, and the log names
    /// both types.
    pub fn subscribe<T: Type>(
        &self,
        channel: &str,
        options: impl Into<SubscribeOptions>,
    ) -> Result<Subscription<T>> {
        self.open_queue(channel, Some(&Schema::of::<T>()?), &options.into())
    }

    /// Receives a channel of any type, or of that of `schema`, as it comes.
    pub fn subscribe_raw(
        &self,
        channel: &str,
        schema: Option<&Schema>,
        options: impl Into<SubscribeOptions>,
    ) -> Result<Subscription<Message>> {
        self.open_queue(channel, schema, &options.into())
    }

    fn open_queue<T>(
        &self,
        channel: &str,
        schema: Option<&Schema>,
        options: &SubscribeOptions,
    ) -> Result<Subscription<T>> {
        let channel = text("channel", channel)?;
        let mut handle = null_mut();
        with_options(schema, options, |options| {
            // SAFETY: the arguments are valid during the call.
            unsafe {
                sys::hgros_subscribe_queue(self.as_ptr(), channel.as_ptr(), options, &mut handle)
            }
        })?;
        Ok(Subscription {
            handle: NonNull::new(handle).expect("a queue was made"),
            messages: PhantomData,
        })
    }
}

/// Calls a function with options of the C interface.
pub(crate) fn with_options(
    schema: Option<&Schema>,
    options: &SubscribeOptions,
    call: impl FnOnce(*const sys::hgros_subscribe_options) -> sys::hgros_status,
) -> Result<()> {
    let name = text("name of the subscription", &options.name)?;
    let mut chosen = sys::hgros_subscribe_options {
        name: name.as_ptr(),
        schema: schema.map_or(null(), Schema::as_ptr),
        executor: match options.executor {
            Executor::Workers => sys::HGROS_EXECUTOR_WORKERS,
            Executor::Inline => sys::HGROS_EXECUTOR_INLINE,
            Executor::Dedicated => sys::HGROS_EXECUTOR_DEDICATED,
        },
        ..Default::default()
    };
    match options.queue {
        Queue::KeepLast(messages) => chosen.keep_last = messages,
        Queue::KeepAll(messages) => chosen.keep_all = messages,
        Queue::KeepAllBytes { messages, bytes } => {
            chosen.keep_all = messages;
            chosen.keep_all_bytes = bytes;
        }
    }
    check(call(&chosen))
}

pub(crate) fn stats_of(handle: NonNull<sys::hgros_subscription>) -> Result<Stats> {
    let mut stats = sys::hgros_subscription_stats::default();
    // SAFETY: both pointers are valid.
    check(unsafe { sys::hgros_subscription_get_stats(handle.as_ptr(), &mut stats) })?;
    Ok(Stats {
        received: stats.received,
        dropped: stats.dropped,
        taken: stats.run,
        queued: stats.queued,
        mismatched: stats.mismatched,
    })
}

impl<T> Subscription<T> {
    /// Takes the oldest message as it came, without decoding it: its bytes, its type, where it comes from.
    pub fn take(&self, timeout: Duration) -> Result<Message> {
        let mut message = null_mut();
        // SAFETY: the handle is valid, and the message belongs to the caller.
        unsafe {
            check(sys::hgros_queue_take(
                self.handle.as_ptr(),
                nanoseconds(timeout),
                &mut message,
            ))?;
            Ok(Message::from(message))
        }
    }

    /// Ends the subscription, and wakes the threads that wait for it with [`Status::Closed`].
    pub fn end(&self) {
        // SAFETY: the handle is valid; other threads may use it meanwhile.
        unsafe { sys::hgros_subscription_end(self.handle.as_ptr()) };
    }

    /// Counters since the subscription began.
    pub fn stats(&self) -> Result<Stats> {
        stats_of(self.handle)
    }
}

impl<T: Receive> Subscription<T> {
    /// Waits for the oldest message. The error is [`Status::Closed`] once the subscription or its session has ended.
    pub fn recv(&self) -> Result<T> {
        self.recv_timeout(Duration::MAX)
    }

    /// The same for a limited time: [`Status::TimedOut`].
    pub fn recv_timeout(&self, timeout: Duration) -> Result<T> {
        T::receive(self.take(timeout)?)
    }

    /// Takes the oldest message; None if none waits.
    pub fn try_recv(&self) -> Result<Option<T>> {
        none_if(self.recv_timeout(Duration::ZERO), Status::TimedOut)
    }

    /// The messages as they come, until the subscription or its session ends.
    pub fn iter(&self) -> Iter<'_, T> {
        self.iter_timeout(Duration::MAX)
    }

    /// The same, but ends with [`Status::TimedOut`] as the last item if no message came for so long.
    pub fn iter_timeout(&self, timeout: Duration) -> Iter<'_, T> {
        Iter {
            subscription: self,
            timeout,
            over: false,
        }
    }
}

fn none_if<T>(result: Result<T>, status: Status) -> Result<Option<T>> {
    match result {
        Ok(value) => Ok(Some(value)),
        Err(error) if error.status() == status => Ok(None),
        Err(error) => Err(error),
    }
}

/// Messages as they come. An error that is not the end, such as a message that cannot be decoded, is one item.
pub struct Iter<'a, T> {
    subscription: &'a Subscription<T>,
    timeout: Duration,
    over: bool,
}

impl<T: Receive> Iterator for Iter<'_, T> {
    type Item = Result<T>;

    fn next(&mut self) -> Option<Result<T>> {
        if self.over {
            return None;
        }
        let next =
            none_if(self.subscription.recv_timeout(self.timeout), Status::Closed).transpose();
        self.over = match &next {
            None => true,
            Some(item) => matches!(item, Err(error) if error.status() == Status::TimedOut),
        };
        next
    }
}

impl<'a, T: Receive> IntoIterator for &'a Subscription<T> {
    type Item = Result<T>;
    type IntoIter = Iter<'a, T>;

    fn into_iter(self) -> Iter<'a, T> {
        self.iter()
    }
}

impl<T> AsRawFd for Subscription<T> {
    fn as_raw_fd(&self) -> RawFd {
        // SAFETY: the handle is valid.
        unsafe { sys::hgros_queue_descriptor(self.handle.as_ptr()) }
    }
}

impl<T> AsFd for Subscription<T> {
    fn as_fd(&self) -> BorrowedFd<'_> {
        // SAFETY: every queue has a descriptor, which is valid as long as the handle.
        unsafe { BorrowedFd::borrow_raw(self.as_raw_fd()) }
    }
}

impl<T> Drop for Subscription<T> {
    fn drop(&mut self) {
        // SAFETY: the handle is this object's own.
        unsafe { sys::hgros_subscription_close(self.handle.as_ptr()) };
    }
}
