//! What went wrong: a status to decide by, and a sentence to read.

use crate::convert::string_from;
use hgros_sys as sys;
use std::fmt;

/// The kind of an error.
#[derive(Clone, Copy, Debug, Eq, Hash, PartialEq)]
#[non_exhaustive]
pub enum Status {
    /// A value that cannot be used, such as a text with a zero byte.
    InvalidArgument,
    /// Wiring failed for another reason: a name, an endpoint, a limit of the system.
    Failed,
    /// Both sides use different types. The sentence names both.
    TypeMismatch,
    /// A configuration is wrong. The sentence has file, line and column.
    ConfigError,
    /// The session, or what the handle stands for, has ended.
    Closed,
    /// A lossless subscriber has no room, or too many calls wait. Nobody got the message.
    Full,
    /// The timeout came first; for a queue: no message waits.
    TimedOut,
    /// Waiting was refused: this thread runs a callback that the wait could depend on.
    WouldDeadlock,
    /// Larger than 1 GiB, and another session subscribes.
    TooLarge,
    NoMemory,
    /// There is nothing of this name or number.
    NotFound,
    /// A parameter or a transform was refused. The sentence says why.
    Refused,
    /// No session serves that name.
    NoServer,
    /// The handler failed. The sentence is its own.
    HandlerFailed,
    /// The server died or left during the call.
    ServerGone,
    Cancelled,
    /// A message, a request or a reply could not be written or read as its type.
    NotWritable,
    /// No transform has a frame of this name.
    UnknownFrame,
    /// Both frames are known, but in separate trees.
    NotConnected,
    /// Before the oldest transform that is remembered.
    TooOld,
    /// After the newest transform.
    TooNew,
    /// A status of a later version of the library.
    Other(i32),
}

impl Status {
    fn from(code: sys::hgros_status) -> Self {
        match code {
            sys::HGROS_INVALID_ARGUMENT => Self::InvalidArgument,
            sys::HGROS_ERROR => Self::Failed,
            sys::HGROS_TYPE_MISMATCH => Self::TypeMismatch,
            sys::HGROS_CONFIG_ERROR => Self::ConfigError,
            sys::HGROS_CLOSED => Self::Closed,
            sys::HGROS_FULL => Self::Full,
            sys::HGROS_TIMED_OUT => Self::TimedOut,
            sys::HGROS_WOULD_DEADLOCK => Self::WouldDeadlock,
            sys::HGROS_TOO_LARGE => Self::TooLarge,
            sys::HGROS_NO_MEMORY => Self::NoMemory,
            sys::HGROS_NOT_FOUND => Self::NotFound,
            sys::HGROS_REFUSED => Self::Refused,
            sys::HGROS_NO_SERVER => Self::NoServer,
            sys::HGROS_HANDLER_FAILED => Self::HandlerFailed,
            sys::HGROS_SERVER_GONE => Self::ServerGone,
            sys::HGROS_CANCELLED => Self::Cancelled,
            sys::HGROS_NOT_WRITABLE => Self::NotWritable,
            sys::HGROS_UNKNOWN_FRAME => Self::UnknownFrame,
            sys::HGROS_NOT_CONNECTED => Self::NotConnected,
            sys::HGROS_TOO_OLD => Self::TooOld,
            sys::HGROS_TOO_NEW => Self::TooNew,
            other => Self::Other(other),
        }
    }
}

/// What went wrong, where, and how to mend it.
#[derive(Clone, Debug, Eq, PartialEq)]
pub struct Error {
    status: Status,
    sentence: String,
}

/// The result of what can fail.
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    pub(crate) fn new(status: Status, sentence: impl Into<String>) -> Self {
        let sentence = sentence.into();
        Self { status, sentence }
    }

    pub fn status(&self) -> Status {
        self.status
    }

    pub fn sentence(&self) -> &str {
        &self.sentence
    }
}

impl fmt::Display for Error {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.sentence)
    }
}

impl std::error::Error for Error {}

/// The error of a call that this thread has just made.
pub(crate) fn check(status: sys::hgros_status) -> Result<()> {
    if status == sys::HGROS_OK {
        return Ok(());
    }
    // SAFETY: the text is valid until this thread calls a function that fails.
    let sentence = unsafe { string_from(sys::hgros_last_error()) };
    Err(Error::new(Status::from(status), sentence))
}
