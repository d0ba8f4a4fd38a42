//! Publishing.

use crate::convert::{nanoseconds, text};
use crate::error::{check, Error, Result, Status};
use crate::loan::Loan;
use crate::schema::{Schema, Type};
use crate::session::Session;
use hgros_sys as sys;
use protobuf::{CodedOutputStream, ProtobufResult};
use std::marker::PhantomData;
use std::ptr::{null_mut, NonNull};
use std::time::Duration;

/// From this size on a message is encoded where its receivers read it.
const IN_PLACE_BYTES: usize = 64 * 1024;

/// Options of a publisher.
#[derive(Clone, Debug, Default)]
pub struct PublishOptions {
    /// Number of recent messages kept for late subscribers.
    pub latched: u64,
}

/// Publishes messages of one type on one channel: protobuf messages, or bytes as `Publisher<[u8]>`.
pub struct Publisher<T: ?Sized> {
    handle: NonNull<sys::hgros_publisher>,
    messages: PhantomData<fn(&T)>,
}

// SAFETY: any thread may publish and close; it is closed by its only owner, when nobody borrows it.
unsafe impl<T: ?Sized> Send for Publisher<T> {}
// SAFETY: as above.
unsafe impl<T: ?Sized> Sync for Publisher<T> {}

impl Session {
    /// Announces a channel of a protobuf type, whose description goes with it.
    pub fn advertise<T: Type>(
        &self,
        channel: &str,
        options: PublishOptions,
    ) -> Result<Publisher<T>> {
        self.open_publisher(channel, &Schema::of::<T>()?, &options)
    }

    /// Announces a channel of a type that is known at run time only.
    pub fn advertise_raw(
        &self,
        channel: &str,
        schema: &Schema,
        options: PublishOptions,
    ) -> Result<Publisher<[u8]>> {
        self.open_publisher(channel, schema, &options)
    }

    fn open_publisher<T: ?Sized>(
        &self,
        channel: &str,
        schema: &Schema,
        options: &PublishOptions,
    ) -> Result<Publisher<T>> {
        let channel = text("channel", channel)?;
        let options = sys::hgros_publish_options {
            latched: options.latched,
            ..Default::default()
        };
        let mut handle = null_mut();
        // SAFETY: the arguments are valid during the call.
        check(unsafe {
            sys::hgros_publisher_open(
                self.as_ptr(),
                channel.as_ptr(),
                schema.as_ptr(),
                &options,
                &mut handle,
            )
        })?;
        Ok(Publisher {
            handle: NonNull::new(handle).expect("a publisher was made"),
            messages: PhantomData,
        })
    }
}

impl<T: ?Sized> Publisher<T> {
    /// Memory for one message of `size` bytes, which receivers on this host read without a copy.
    pub fn loan(&self, size: usize) -> Result<Loan> {
        Loan::open(self.handle.as_ptr(), size)
    }

    fn send_bytes(&self, data: &[u8], timeout: Duration) -> Result<()> {
        // SAFETY: the arguments are valid during the call. The address of an empty slice is not NULL.
        check(unsafe {
            let timeout = nanoseconds(timeout);
            sys::hgros_publish_wait(
                self.handle.as_ptr(),
                data.as_ptr().cast(),
                data.len(),
                timeout,
            )
        })
    }
}

impl<T: Publish + ?Sized> Publisher<T> {
    /// Publishes a message. Never waits: [`Status::Full`] says that a lossless subscriber has no room.
    pub fn publish(&self, message: &T) -> Result<()> {
        message.send(self, Duration::ZERO)
    }

    /// The same, but waits while a lossless subscriber has no room.
    pub fn publish_wait(&self, message: &T, timeout: Duration) -> Result<()> {
        message.send(self, timeout)
    }
}

/// What a [`Publisher`] publishes: a protobuf message, or bytes.
pub trait Publish {
    #[doc(hidden)]
    fn send(&self, publisher: &Publisher<Self>, timeout: Duration) -> Result<()>;
}

impl Publish for [u8] {
    fn send(&self, publisher: &Publisher<Self>, timeout: Duration) -> Result<()> {
        publisher.send_bytes(self, timeout)
    }
}

impl<T: Type> Publish for T {
    fn send(&self, publisher: &Publisher<Self>, timeout: Duration) -> Result<()> {
        let size = self.compute_size() as usize;
        if size < IN_PLACE_BYTES {
            return publisher.send_bytes(&encoded(self)?, timeout);
        }
        let mut loan = publisher.loan(size)?;
        write_into(self, &mut loan).map_err(not_writable::<T>)?;
        Ok(loan.publish(timeout)?)
    }
}

impl<T: ?Sized> Drop for Publisher<T> {
    fn drop(&mut self) {
        // SAFETY: the handle is this object's own.
        unsafe { sys::hgros_publisher_close(self.handle.as_ptr()) };
    }
}

/// The bytes of a message.
pub(crate) fn encoded<T: Type>(message: &T) -> Result<Vec<u8>> {
    message.write_to_bytes().map_err(not_writable::<T>)
}

fn write_into<T: Type>(message: &T, place: &mut [u8]) -> ProtobufResult<()> {
    let mut output = CodedOutputStream::bytes(place);
    message.write_to(&mut output)?;
    output.check_eof();
    Ok(())
}

fn not_writable<T: Type>(fault: protobuf::ProtobufError) -> Error {
    Error::new(
        Status::NotWritable,
        format!("A {} cannot be written: {fault}.", T::NAME),
    )
}
