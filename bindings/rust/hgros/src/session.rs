//! Sessions.

use crate::callback::{lock, Callback, CallbackReports};
use crate::convert::{nanoseconds, string_from, text, Texts};
use crate::error::{check, Result};
use hgros_sys as sys;
use std::os::raw::{c_char, c_void};
use std::ptr::{null_mut, NonNull};
use std::sync::{Arc, Mutex};
use std::time::Duration;

/// The weight of a line of the log.
#[derive(Clone, Copy, Debug, Eq, Hash, Ord, PartialEq, PartialOrd)]
pub enum Level {
    Debug,
    Info,
    Warning,
    Error,
}

impl Level {
    fn from(code: i32) -> Self {
        match code {
            sys::HGROS_LOG_DEBUG => Self::Debug,
            sys::HGROS_LOG_INFO => Self::Info,
            sys::HGROS_LOG_WARNING => Self::Warning,
            _ => Self::Error,
        }
    }

    fn code(self) -> i32 {
        match self {
            Self::Debug => sys::HGROS_LOG_DEBUG,
            Self::Info => sys::HGROS_LOG_INFO,
            Self::Warning => sys::HGROS_LOG_WARNING,
            Self::Error => sys::HGROS_LOG_ERROR,
        }
    }
}

type LogFunction = Box<dyn FnMut(Level, &str) + Send>;

/// Options of a session. Without any, [`Session::open`] is shorter.
#[derive(Default)]
pub struct SessionBuilder {
    name: String,
    log: Option<LogFunction>,
}

impl SessionBuilder {
    /// For logs and other sessions' tables; by default the program's name.
    pub fn name(mut self, name: impl Into<String>) -> Self {
        self.name = name.into();
        self
    }

    /// Gets the log instead of standard error. It must not call this crate.
    pub fn log(mut self, line: impl FnMut(Level, &str) + Send + 'static) -> Self {
        self.log = Some(Box::new(line));
        self
    }

    /// As [`Session::open`].
    pub fn open(self, yaml: &str) -> Result<Session> {
        let yaml = text("configuration", yaml)?;
        // SAFETY: the arguments are valid during the call.
        self.open_with(|options, session| unsafe {
            sys::hgros_session_open(yaml.as_ptr(), options, session)
        })
    }

    /// Opens a session with configuration files, which are merged.
    pub fn open_files(self, files: &[&str]) -> Result<Session> {
        let files = Texts::new("path", files)?;
        // SAFETY: the arguments are valid during the call.
        self.open_with(|options, session| unsafe {
            sys::hgros_session_open_files(files.as_ptr(), files.len(), options, session)
        })
    }

    fn open_with(
        self,
        open: impl FnOnce(
            *const sys::hgros_session_options,
            *mut *mut sys::hgros_session,
        ) -> sys::hgros_status,
    ) -> Result<Session> {
        let reports = Arc::new(CallbackReports::new());
        let name = text("name of the session", &self.name)?;
        let mut options = sys::hgros_session_options {
            name: name.as_ptr(),
            ..Default::default()
        };
        if let Some(log) = self.log {
            options.log = Some(write_line);
            options.log_user =
                LogCallback::new(&reports, "The log".to_owned(), Mutex::new(log)).into_user();
            options.log_release = Some(LogCallback::release);
        }
        let mut handle = null_mut();
        check(open(&options, &mut handle))?;
        reports.open(handle);
        Ok(Session {
            handle: NonNull::new(handle).expect("a session was made"),
            reports,
        })
    }
}

type LogCallback = Callback<Mutex<LogFunction>>;

unsafe extern "C" fn write_line(user: *mut c_void, level: i32, line: *const c_char) {
    // SAFETY: what the library got in open_with().
    let (callback, line) = (LogCallback::from(user), string_from(line));
    callback.run_silently(|log| lock(log)(Level::from(level), &line));
}

/// One participant of the hypergraph.
///
/// Dropping it waits for running callbacks, and says goodbye to the other sessions; what was made from it then returns
/// [`Status::Closed`](crate::Status::Closed). Do not drop it inside one of its callbacks: the rest of it would stay
/// until the process ends. [`Session::end`] may be called there.
pub struct Session {
    handle: NonNull<sys::hgros_session>,
    pub(crate) reports: Arc<CallbackReports>,
}

// SAFETY: every function on a session may be called by any thread. It is closed by its only owner, when nobody borrows
// it.
unsafe impl Send for Session {}
// SAFETY: as above.
unsafe impl Sync for Session {}

impl Session {
    /// Opens a session with a configuration as YAML text. Empty: the default, which finds the sessions of this user on
    /// this host.
    pub fn open(yaml: &str) -> Result<Self> {
        Self::builder().open(yaml)
    }

    /// A session with options.
    pub fn builder() -> SessionBuilder {
        SessionBuilder::default()
    }

    pub(crate) fn as_ptr(&self) -> *mut sys::hgros_session {
        self.handle.as_ptr()
    }

    /// Wakes all threads that wait for the session. Every later call, also of what was made from it, returns
    /// [`Status::Closed`](crate::Status::Closed). Does not wait. May be called inside callbacks.
    pub fn end(&self) {
        // SAFETY: the handle is valid.
        unsafe { sys::hgros_session_end(self.as_ptr()) };
    }

    pub fn name(&self) -> String {
        // SAFETY: the handle is valid, and the text as long as it.
        unsafe { string_from(sys::hgros_session_name(self.as_ptr())) }
    }

    /// As [`Info::publisher`](crate::Info::publisher) of its messages has it.
    pub fn id(&self) -> u64 {
        // SAFETY: the handle is valid.
        unsafe { sys::hgros_session_id(self.as_ptr()) }
    }

    /// Callbacks that panicked, and messages that a typed callback did not get because they could not be decoded. The
    /// log has a line about each.
    pub fn callback_failures(&self) -> u64 {
        self.reports.failures()
    }

    /// Writes a line into the session's log.
    pub fn log(&self, level: Level, line: &str) -> Result<()> {
        let line = text("line", line)?;
        // SAFETY: the arguments are valid during the call.
        check(unsafe { sys::hgros_session_log(self.as_ptr(), level.code(), line.as_ptr()) })
    }

    /// Lines below `level` are not written from now on.
    pub fn set_log_level(&self, level: Level) -> Result<()> {
        // SAFETY: the handle is valid.
        check(unsafe { sys::hgros_session_set_log_level(self.as_ptr(), level.code()) })
    }

    /// Waits until no message is queued for a callback and no callback runs.
    pub fn wait_idle(&self, timeout: Duration) -> Result<()> {
        // SAFETY: the handle is valid.
        check(unsafe { sys::hgros_session_wait_idle(self.as_ptr(), nanoseconds(timeout)) })
    }

    /// Waits until a channel that this session publishes has at least `count` subscribers, in this session and others.
    pub fn wait_for_subscribers(
        &self,
        channel: &str,
        count: usize,
        timeout: Duration,
    ) -> Result<()> {
        let channel = text("channel", channel)?;
        // SAFETY: the arguments are valid during the call.
        check(unsafe {
            let timeout = nanoseconds(timeout);
            sys::hgros_session_wait_for_subscribers(self.as_ptr(), channel.as_ptr(), count, timeout)
        })
    }

    /// Waits until at least `count` other sessions that publish on a channel are connected.
    pub fn wait_for_publishers(
        &self,
        channel: &str,
        count: usize,
        timeout: Duration,
    ) -> Result<()> {
        let channel = text("channel", channel)?;
        // SAFETY: the arguments are valid during the call.
        check(unsafe {
            let timeout = nanoseconds(timeout);
            sys::hgros_session_wait_for_publishers(self.as_ptr(), channel.as_ptr(), count, timeout)
        })
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        self.reports.close();
        // SAFETY: the handle is this object's own, and no callback logs on it any more.
        unsafe { sys::hgros_session_close(self.as_ptr()) };
    }
}

/// The version of the library, such as "0.1.0".
pub fn version() -> String {
    // SAFETY: the text is constant.
    unsafe { string_from(sys::hgros_version()) }
}
