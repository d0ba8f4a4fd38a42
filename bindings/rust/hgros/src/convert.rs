//! Texts and times as the C interface has them.

use crate::error::{Error, Result, Status};
use std::ffi::{CStr, CString};
use std::os::raw::c_char;
use std::time::Duration;

/// A text for the library. `what` names it in the error.
pub(crate) fn text(what: &str, value: &str) -> Result<CString> {
    CString::new(value).map_err(|_| {
        let sentence = format!("The {what} {value:?} has a zero byte, which no text may have.");
        Error::new(Status::InvalidArgument, sentence)
    })
}

/// The same for a sentence that must get through: zero bytes are left out.
pub(crate) fn sentence(value: &str) -> CString {
    CString::new(value.replace('\0', "")).expect("zero bytes were removed")
}

/// Texts for the library, and an array of their addresses.
pub(crate) struct Texts {
    _owned: Vec<CString>,
    addresses: Vec<*const c_char>,
}

impl Texts {
    pub fn new(what: &str, values: &[impl AsRef<str>]) -> Result<Self> {
        let owned = values
            .iter()
            .map(|one| text(what, one.as_ref()))
            .collect::<Result<Vec<_>>>()?;
        let addresses = owned.iter().map(|one| one.as_ptr()).collect();
        Ok(Self {
            _owned: owned,
            addresses,
        })
    }

    pub fn as_ptr(&self) -> *const *const c_char {
        self.addresses.as_ptr()
    }

    pub fn len(&self) -> usize {
        self.addresses.len()
    }
}

/// A copy of a text of the library; empty for NULL.
///
/// # Safety
/// `text` is NULL, or valid and ends with a zero byte.
pub(crate) unsafe fn string_from(text: *const c_char) -> String {
    if text.is_null() {
        return String::new();
    }
    CStr::from_ptr(text).to_string_lossy().into_owned()
}

/// A timeout in ns. One that is too long to count, such as `Duration::MAX`, is forever.
pub(crate) fn nanoseconds(timeout: Duration) -> i64 {
    i64::try_from(timeout.as_nanos()).unwrap_or(-1)
}
