//! Types of messages.

use crate::convert::text;
use crate::error::{check, Result};
use hgros_sys as sys;
use std::ffi::CStr;
use std::ptr::{null, null_mut, NonNull};

/// A protobuf type. The crate `hgros-build` generates it from a `.proto` file, together with the message.
pub trait Type: protobuf::Message {
    /// The full protobuf name.
    const NAME: &'static str;
    /// A `google.protobuf.FileDescriptorSet` with the type's file and all its imports, dependencies first.
    const DESCRIPTOR_SET: &'static [u8];
}

/// How the bytes of a type are written.
#[derive(Clone, Copy, Debug, Eq, Hash, PartialEq)]
#[non_exhaustive]
pub enum Encoding {
    /// Only of received messages.
    Unknown,
    Protobuf,
    /// A format that both sides agreed on by the type's name.
    Custom,
    /// The bytes of a struct of numbers; only between equal layouts and byte orders.
    Plain,
}

impl Encoding {
    fn code(self) -> i32 {
        match self {
            Self::Unknown => sys::HGROS_ENCODING_NONE,
            Self::Protobuf => sys::HGROS_ENCODING_PROTOBUF,
            Self::Custom => sys::HGROS_ENCODING_CUSTOM,
            Self::Plain => sys::HGROS_ENCODING_PLAIN,
        }
    }

    pub(crate) fn from(code: i32) -> Self {
        match code {
            sys::HGROS_ENCODING_PROTOBUF => Self::Protobuf,
            sys::HGROS_ENCODING_CUSTOM => Self::Custom,
            sys::HGROS_ENCODING_PLAIN => Self::Plain,
            _ => Self::Unknown,
        }
    }
}

/// The type of messages: a name, an encoding and, for protobuf, a description. Never changes.
pub struct Schema(NonNull<sys::hgros_schema>);

// SAFETY: a schema never changes, and any thread may free it.
unsafe impl Send for Schema {}
// SAFETY: as above.
unsafe impl Sync for Schema {}

impl Schema {
    /// The schema of a protobuf type.
    pub fn of<T: Type>() -> Result<Self> {
        Self::create(T::NAME, Encoding::Protobuf, 0, T::DESCRIPTOR_SET)
    }

    /// A type of your own whose bytes this crate does not know. The fingerprint may be 0: then types are compared by
    /// name and encoding alone.
    pub fn raw(type_name: &str, encoding: Encoding, fingerprint: u64) -> Result<Self> {
        Self::create(type_name, encoding, fingerprint, &[])
    }

    /// A type that comes with the library, such as "foxglove.Log".
    pub fn known(type_name: &str) -> Result<Self> {
        let type_name = text("name of a type", type_name)?;
        // SAFETY: the arguments are valid during the call.
        Self::made_by(|schema| unsafe { sys::hgros_schema_known(type_name.as_ptr(), schema) })
    }

    fn create(type_name: &str, encoding: Encoding, fingerprint: u64, set: &[u8]) -> Result<Self> {
        let type_name = text("name of a type", type_name)?;
        let data = if set.is_empty() {
            null()
        } else {
            set.as_ptr().cast()
        };
        // SAFETY: the arguments are valid during the call, and the library copies what it keeps.
        Self::made_by(|schema| unsafe {
            sys::hgros_schema_create(
                type_name.as_ptr(),
                encoding.code(),
                fingerprint,
                data,
                set.len(),
                schema,
            )
        })
    }

    fn made_by(
        make: impl FnOnce(*mut *mut sys::hgros_schema) -> sys::hgros_status,
    ) -> Result<Self> {
        let mut handle = null_mut();
        check(make(&mut handle))?;
        Ok(Self(NonNull::new(handle).expect("a schema was made")))
    }

    /// The schema of a message, which the caller must not drop.
    ///
    /// # Safety
    /// `handle` is valid as long as the result is used.
    pub(crate) unsafe fn borrowed(
        handle: *const sys::hgros_schema,
    ) -> std::mem::ManuallyDrop<Self> {
        let handle = NonNull::new(handle as *mut _).expect("every message has a schema");
        std::mem::ManuallyDrop::new(Self(handle))
    }

    pub(crate) fn as_ptr(&self) -> *const sys::hgros_schema {
        self.0.as_ptr()
    }

    /// The full name of the type.
    pub fn type_name(&self) -> &str {
        // SAFETY: the text is valid as long as the schema.
        let name = unsafe { CStr::from_ptr(sys::hgros_schema_type_name(self.as_ptr())) };
        name.to_str().unwrap_or_default()
    }

    pub fn encoding(&self) -> Encoding {
        // SAFETY: the handle is valid.
        Encoding::from(unsafe { sys::hgros_schema_encoding(self.as_ptr()) })
    }

    /// Equal for equal types; 0: unknown.
    pub fn fingerprint(&self) -> u64 {
        // SAFETY: the handle is valid.
        unsafe { sys::hgros_schema_fingerprint(self.as_ptr()) }
    }

    /// The serialized `google.protobuf.FileDescriptorSet` of a protobuf type; empty if there is none.
    pub fn descriptor_set(&self) -> &[u8] {
        let mut size = 0;
        // SAFETY: the bytes are valid as long as the schema.
        unsafe {
            let data = sys::hgros_schema_descriptor_set(self.as_ptr(), &mut size);
            crate::message::bytes(data, size)
        }
    }
}

impl Drop for Schema {
    fn drop(&mut self) {
        // SAFETY: the handle is this object's own.
        unsafe { sys::hgros_schema_free(self.0.as_ptr()) };
    }
}

impl std::fmt::Debug for Schema {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            formatter,
            "Schema({}, {:?}, {:x})",
            self.type_name(),
            self.encoding(),
            self.fingerprint()
        )
    }
}
