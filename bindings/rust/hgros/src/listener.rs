//! Receiving with callbacks.

use crate::callback::{lock, Callback};
use crate::convert::text;
use crate::error::Result;
use crate::message::Message;
use crate::schema::{Schema, Type};
use crate::session::Session;
use crate::subscription::{stats_of, with_options, Stats, SubscribeOptions};
use hgros_sys as sys;
use std::os::raw::c_void;
use std::ptr::{null_mut, NonNull};
use std::sync::{Arc, Mutex};

/// A subscription with a callback, which ends when this is dropped. Outside callbacks of its session that waits for the
/// running call.
#[must_use = "the subscription ends when the listener is dropped"]
pub struct Listener(NonNull<sys::hgros_subscription>);

// SAFETY: any thread may use the handle; it is closed by its only owner, when nobody borrows it.
unsafe impl Send for Listener {}
// SAFETY: as above.
unsafe impl Sync for Listener {}

impl Session {
    /// Calls a function with every message of a protobuf type, one by one, on a thread of the session.
    pub fn on<T: Type>(
        &self,
        channel: &str,
        options: impl Into<SubscribeOptions>,
        mut callback: impl FnMut(T) + Send + 'static,
    ) -> Result<Listener> {
        let reports = Arc::clone(&self.reports);
        let unread = format!("A message of channel {channel}");
        let decode = move |message: &Message| match message.decode() {
            Ok(decoded) => callback(decoded),
            Err(error) => reports.report(&unread, error.sentence()),
        };
        self.listen(channel, Some(&Schema::of::<T>()?), &options.into(), decode)
    }

    /// Calls a function with every message of any type, or of that of `schema`. Clone a message to keep it.
    pub fn on_raw(
        &self,
        channel: &str,
        schema: Option<&Schema>,
        options: impl Into<SubscribeOptions>,
        callback: impl FnMut(&Message) + Send + 'static,
    ) -> Result<Listener> {
        self.listen(channel, schema, &options.into(), callback)
    }

    fn listen<F: FnMut(&Message) + Send + 'static>(
        &self,
        channel: &str,
        schema: Option<&Schema>,
        options: &SubscribeOptions,
        callback: F,
    ) -> Result<Listener> {
        let what = format!("The callback of channel \"{channel}\"");
        let channel = text("channel", channel)?;
        let mut handle = null_mut();
        with_options(schema, options, |options| {
            let user = Callback::new(&self.reports, what, Mutex::new(callback)).into_user();
            let (call, release) = (
                Some(give::<F> as _),
                Some(Callback::<Mutex<F>>::release as _),
            );
            // SAFETY: the arguments are valid during the call, and the library keeps `user` until it calls `release`.
            unsafe {
                sys::hgros_subscribe(
                    self.as_ptr(),
                    channel.as_ptr(),
                    options,
                    call,
                    user,
                    release,
                    &mut handle,
                )
            }
        })?;
        Ok(Listener(
            NonNull::new(handle).expect("a subscription was made"),
        ))
    }
}

unsafe extern "C" fn give<F>(user: *mut c_void, message: *const sys::hgros_message)
where
    F: FnMut(&Message) + Send + 'static,
{
    // SAFETY: what the library got in listen(), and a message that is valid until this returns.
    let (callback, message) = (Callback::<Mutex<F>>::from(user), Message::borrowed(message));
    // A panic is reported.
    let _ = callback.run(|function| lock(function)(&message));
}

impl Listener {
    /// Counters since the subscription began.
    pub fn stats(&self) -> Result<Stats> {
        stats_of(self.0)
    }
}

impl Drop for Listener {
    fn drop(&mut self) {
        // SAFETY: the handle is this object's own.
        unsafe { sys::hgros_subscription_close(self.0.as_ptr()) };
    }
}
