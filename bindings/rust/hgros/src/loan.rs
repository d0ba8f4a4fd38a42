//! Loans: messages that are written where receivers on this host read them.

use crate::convert::nanoseconds;
use crate::error::{check, Error, Result};
use hgros_sys as sys;
use std::ops::{Deref, DerefMut};
use std::ptr::{null_mut, NonNull};
use std::time::Duration;

/// Memory to fill and publish, from [`Publisher::loan`](crate::Publisher::loan). It derefs to its bytes, which have
/// arbitrary values at first.
pub struct Loan {
    handle: NonNull<sys::hgros_loan>,
    data: NonNull<u8>,
    size: usize,
}

// SAFETY: any thread may use and free a loan, one at a time.
unsafe impl Send for Loan {}
// SAFETY: a shared borrow only reads the bytes.
unsafe impl Sync for Loan {}

impl Loan {
    pub(crate) fn open(publisher: *const sys::hgros_publisher, size: usize) -> Result<Self> {
        let mut handle = null_mut();
        // SAFETY: the caller's publisher is valid.
        check(unsafe { sys::hgros_loan_open(publisher, size, &mut handle) })?;
        let handle = NonNull::new(handle).expect("a loan was made");
        let mut size = 0;
        // SAFETY: the loan is new. Without any byte the library may return NULL.
        let data = unsafe { sys::hgros_loan_data(handle.as_ptr(), &mut size) };
        Ok(Self {
            handle,
            data: NonNull::new(data.cast()).unwrap_or(NonNull::dangling()),
            size,
        })
    }

    /// Publishes the bytes on the channel of its publisher, and waits until lossless subscribers have room. If that
    /// fails, the loan comes back with the error.
    pub fn publish(self, timeout: Duration) -> std::result::Result<(), NotPublished> {
        // SAFETY: the loan is not published yet; afterwards nobody can reach the bytes through it.
        match check(unsafe { sys::hgros_loan_publish(self.handle.as_ptr(), nanoseconds(timeout)) })
        {
            Ok(()) => Ok(()),
            Err(error) => Err(NotPublished { loan: self, error }),
        }
    }
}

impl Deref for Loan {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        // SAFETY: `size` bytes that belong to the loan until it is published, which takes it. The library promises
        // arbitrary values: memory of another library is never uninitialized in the compiler's sense.
        unsafe { std::slice::from_raw_parts(self.data.as_ptr(), self.size) }
    }
}

impl DerefMut for Loan {
    fn deref_mut(&mut self) -> &mut [u8] {
        // SAFETY: as above, and nobody else reads them before they are published.
        unsafe { std::slice::from_raw_parts_mut(self.data.as_ptr(), self.size) }
    }
}

impl Drop for Loan {
    fn drop(&mut self) {
        // SAFETY: the handle is this object's own. A published message is not affected.
        unsafe { sys::hgros_loan_free(self.handle.as_ptr()) };
    }
}

/// A loan that could not be published, and why. It may be published again.
pub struct NotPublished {
    pub loan: Loan,
    pub error: Error,
}

impl From<NotPublished> for Error {
    fn from(not_published: NotPublished) -> Self {
        not_published.error
    }
}

impl std::fmt::Debug for NotPublished {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.error.fmt(formatter)
    }
}

impl std::fmt::Display for NotPublished {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.error.fmt(formatter)
    }
}

impl std::error::Error for NotPublished {}
