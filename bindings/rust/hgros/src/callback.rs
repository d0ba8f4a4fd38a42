//! How the library calls closures: by a pointer to a box, which it lets go when no call can come any more.

use crate::convert::sentence;
use hgros_sys as sys;
use std::any::Any;
use std::os::raw::c_void;
use std::panic::{catch_unwind, AssertUnwindSafe};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// What the callbacks of a session share with it.
pub(crate) struct CallbackReports {
    /// Where failures are logged; None before the session is open and once it is closed.
    session: Mutex<Option<LogTarget>>,
    failures: AtomicU64,
}

struct LogTarget(*mut sys::hgros_session);
// SAFETY: any thread may use a session. It is only used under the lock, from which it is taken before it is closed.
unsafe impl Send for LogTarget {}

impl CallbackReports {
    pub fn new() -> Self {
        Self {
            session: Mutex::new(None),
            failures: AtomicU64::new(0),
        }
    }

    pub fn open(&self, session: *mut sys::hgros_session) {
        *lock(&self.session) = Some(LogTarget(session));
    }

    pub fn close(&self) {
        *lock(&self.session) = None;
    }

    pub fn failures(&self) -> u64 {
        self.failures.load(Ordering::Relaxed)
    }

    /// Counts a failure, and writes a line about it into the session's log. Of those of one `what` that come again and
    /// again, the log has fewer and fewer.
    pub fn report(&self, what: &str, line: &str) {
        self.failures.fetch_add(1, Ordering::Relaxed);
        if let Some(target) = &*lock(&self.session) {
            let line = sentence(&line.replace(char::is_control, " "));
            let alike = sentence(&what.replace(char::is_control, " "));
            // SAFETY: the session is not closed while this thread has the lock. If the line cannot be written, the
            // count still tells.
            unsafe {
                sys::hgros_session_log_limited(
                    target.0,
                    sys::HGROS_LOG_ERROR,
                    alike.as_ptr(),
                    line.as_ptr(),
                )
            };
        }
    }
}

/// The lock of data that a panic cannot leave half changed, or of a closure, which is called again after a panic.
pub(crate) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A closure that the library has. `FnMut` closures come in a `Mutex`.
pub(crate) struct Callback<F> {
    pub function: F,
    pub reports: Arc<CallbackReports>,
    what: String,
}

impl<F: Send + Sync + 'static> Callback<F> {
    /// `what` begins the line about a panic, such as "The callback of channel words".
    pub fn new(reports: &Arc<CallbackReports>, what: String, function: F) -> Self {
        Self {
            function,
            reports: Arc::clone(reports),
            what,
        }
    }

    /// The library's `user` pointer. The library calls `release` on it once, whatever happens.
    pub fn into_user(self) -> *mut c_void {
        Box::into_raw(Box::new(self)).cast()
    }

    /// # Safety
    /// `user` is from `into_user()` of this type, and not yet released.
    pub unsafe fn from<'a>(user: *mut c_void) -> &'a Self {
        &*user.cast::<Self>()
    }

    /// `hgros_release` for this type.
    pub unsafe extern "C" fn release(user: *mut c_void) {
        // SAFETY: the library calls it once, with what into_user() returned.
        let owned = Box::from_raw(user.cast::<Self>());
        let reports = Arc::clone(&owned.reports);
        if let Err(panicked) = catch_unwind(AssertUnwindSafe(|| drop(owned))) {
            let what = "Destroying a callback";
            reports.report(what, &format!("{what} panicked: {}", panic_text(panicked)));
        }
    }

    /// Runs a call of the closure. The result of a panic is its text, which is also reported.
    pub fn run<R>(&self, call: impl FnOnce(&F) -> R) -> Result<R, String> {
        // A closure that has panicked is called again: what it shares with the program is the program's concern.
        self.catch(call).map_err(|text| {
            let line = format!("{} panicked: {text}", self.what);
            self.reports.report(&self.what, &line);
            line
        })
    }

    /// The same without a line in the log, for the log itself.
    pub fn run_silently(&self, call: impl FnOnce(&F)) {
        if self.catch(call).is_err() {
            self.reports.failures.fetch_add(1, Ordering::Relaxed);
        }
    }

    fn catch<R>(&self, call: impl FnOnce(&F) -> R) -> Result<R, String> {
        catch_unwind(AssertUnwindSafe(|| call(&self.function))).map_err(panic_text)
    }
}

fn panic_text(panicked: Box<dyn Any + Send>) -> String {
    let text = if let Some(text) = panicked.downcast_ref::<&str>() {
        (*text).to_owned()
    } else if let Some(text) = panicked.downcast_ref::<String>() {
        text.clone()
    } else {
        "a value that is no text".to_owned()
    };
    // Destroying what was thrown may panic, too.
    if let Err(again) = catch_unwind(AssertUnwindSafe(|| drop(panicked))) {
        std::mem::forget(again);
    }
    text
}
