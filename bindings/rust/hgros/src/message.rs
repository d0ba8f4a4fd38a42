//! Received messages.

use crate::error::{check, Error, Result, Status};
use crate::schema::{Schema, Type};
use hgros_sys as sys;
use protobuf::error::WireError;
use protobuf::wire_format::WireType;
use protobuf::{CodedInputStream, ProtobufError, ProtobufResult};
use std::mem::ManuallyDrop;
use std::ops::Deref;
use std::os::raw::c_void;
use std::ptr::{null_mut, NonNull};
use std::time::{Duration, SystemTime};

/// Where a message comes from.
#[derive(Clone, Debug, Eq, PartialEq)]
pub struct Info {
    /// From another session.
    pub remote: bool,
    /// The sender's session id.
    pub publisher: u64,
    /// Counts the sender's messages on the channel.
    pub sequence: u64,
    /// Names the message in all processes.
    pub key: u64,
    /// The sender's wall clock; None for messages of the same session.
    pub publish_time: Option<SystemTime>,
}

/// A received message. It derefs to its bytes, which are not copied: it is a lease on the sender's memory, which ends
/// when it is dropped. Many large messages that are kept make the sender use ordinary memory, which costs a copy.
pub struct Message {
    handle: NonNull<sys::hgros_message>,
    schema: ManuallyDrop<Schema>, // Belongs to the message.
}

// SAFETY: nobody writes a message's bytes, all functions on it may be called by any thread, and any thread may free it.
unsafe impl Send for Message {}
// SAFETY: as above.
unsafe impl Sync for Message {}

impl Message {
    /// # Safety
    /// `handle` is a valid message, of which the result is the only owner.
    pub(crate) unsafe fn from(handle: *mut sys::hgros_message) -> Self {
        let schema = Schema::borrowed(sys::hgros_message_schema(handle));
        Self {
            handle: NonNull::new(handle).expect("a message was made"),
            schema,
        }
    }

    /// The message of a callback.
    ///
    /// # Safety
    /// `handle` is valid as long as the result is used, and nobody gets the result by value.
    pub(crate) unsafe fn borrowed(handle: *const sys::hgros_message) -> ManuallyDrop<Self> {
        ManuallyDrop::new(Self::from(handle as *mut _))
    }

    /// The type that came with the channel.
    pub fn schema(&self) -> &Schema {
        &self.schema
    }

    /// Where the message comes from.
    pub fn info(&self) -> Info {
        let mut info = sys::hgros_message_info::default();
        // SAFETY: both pointers are valid.
        check(unsafe { sys::hgros_message_get_info(self.handle.as_ptr(), &mut info) })
            .expect("the library knows a struct of this size");
        let since_1970 = u64::try_from(info.publish_time_ns)
            .ok()
            .filter(|&time| time > 0);
        Info {
            remote: info.remote != 0,
            publisher: info.publisher,
            sequence: info.sequence,
            key: info.key,
            publish_time: since_1970
                .map(|time| SystemTime::UNIX_EPOCH + Duration::from_nanos(time)),
        }
    }

    /// Decodes the message.
    pub fn decode<T: Type>(&self) -> Result<T> {
        let came = self.schema().type_name();
        if came != T::NAME {
            let sentence = format!(
                "The message is a \"{came}\", but is read as \"{}\".",
                T::NAME
            );
            return Err(Error::new(Status::TypeMismatch, sentence));
        }
        T::parse_from_bytes(self).map_err(|fault| self.unreadable(fault))
    }

    /// The bytes of a `bytes` or `string` field of the message itself, without a copy and without decoding the rest;
    /// empty if it is not set. `number` is the field's number in the `.proto` file.
    pub fn field_bytes(&self, number: u32) -> Result<&[u8]> {
        let mut found: &[u8] = &[];
        let mut rest: &[u8] = self;
        while !rest.is_empty() {
            let (field, value, size) = next_field(rest).map_err(|fault| self.unreadable(fault))?;
            if field == number {
                found = value;
            }
            rest = &rest[size..];
        }
        Ok(found)
    }

    fn unreadable(&self, fault: ProtobufError) -> Error {
        let sentence = format!("A {} cannot be read: {fault}.", self.schema().type_name());
        Error::new(Status::NotWritable, sentence)
    }
}

/// A lease of its own on the same bytes, without a copy.
impl Clone for Message {
    fn clone(&self) -> Self {
        let mut kept = null_mut();
        // SAFETY: both pointers are valid, and the new message belongs to the caller.
        unsafe {
            check(sys::hgros_message_keep(self.handle.as_ptr(), &mut kept))
                .expect("a lease fails only without memory");
            Self::from(kept)
        }
    }
}

impl Deref for Message {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        let mut size = 0;
        // SAFETY: the bytes are valid as long as the message, and nobody writes them.
        unsafe {
            let data = sys::hgros_message_data(self.handle.as_ptr(), &mut size);
            bytes(data, size)
        }
    }
}

impl Drop for Message {
    fn drop(&mut self) {
        // SAFETY: the handle is this object's own.
        unsafe { sys::hgros_message_free(self.handle.as_ptr()) };
    }
}

impl std::fmt::Debug for Message {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            formatter,
            "Message({}, {} bytes)",
            self.schema().type_name(),
            self.len()
        )
    }
}

/// The first field of a message: its number, the bytes of a `bytes` or `string` field, and the size of all.
fn next_field(rest: &[u8]) -> ProtobufResult<(u32, &[u8], usize)> {
    let mut input = CodedInputStream::from_bytes(rest);
    let (field, wire_type) = input.read_tag_unpack()?;
    if wire_type != WireType::WireTypeLengthDelimited {
        match wire_type {
            WireType::WireTypeStartGroup => skip_group(&mut input, field)?,
            _ => input.skip_field(wire_type)?,
        }
        return Ok((field, &[], input.pos() as usize));
    }
    let size = input.read_raw_varint32()? as usize;
    let start = input.pos() as usize;
    let value = rest
        .get(start..start + size)
        .ok_or(ProtobufError::WireError(WireError::UnexpectedEof))?;
    Ok((field, value, start + size))
}

/// Skips a group, whose start was read: fields of old protobuf types, and other groups, until its end.
fn skip_group(input: &mut CodedInputStream<'_>, number: u32) -> ProtobufResult<()> {
    const MOST_OPEN: usize = 100; // As protobuf for C++ has it.
    let mut open = vec![number];
    while let Some(&group) = open.last() {
        let (field, wire_type) = input.read_tag_unpack()?;
        match wire_type {
            WireType::WireTypeStartGroup if open.len() == MOST_OPEN => {
                return Err(ProtobufError::WireError(WireError::OverRecursionLimit));
            }
            WireType::WireTypeStartGroup => open.push(field),
            WireType::WireTypeEndGroup if field == group => {
                open.pop();
            }
            _ => input.skip_field(wire_type)?, // Refuses the end of another group.
        }
    }
    Ok(())
}

/// The number of messages of this process that were returned and not yet dropped.
pub fn leases() -> u64 {
    // SAFETY: it takes no arguments.
    unsafe { sys::hgros_message_leases() }
}

/// Bytes of the library; it may return NULL for none.
///
/// # Safety
/// `data` is NULL, or `size` bytes that are valid and not written during `'a`.
pub(crate) unsafe fn bytes<'a>(data: *const c_void, size: usize) -> &'a [u8] {
    if data.is_null() {
        return &[];
    }
    std::slice::from_raw_parts(data.cast(), size)
}
