//! Transforms by the names of frames.

use crate::convert::{nanoseconds, text};
use crate::error::{check, Result};
use crate::session::Session;
use hgros_sys as sys;
use std::os::raw::c_char;
use std::ptr::{null_mut, NonNull};
use std::time::Duration;

/// p_target = rotation * p_source + translation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transform {
    /// x, y, z in meters.
    pub translation: [f64; 3],
    /// A unit quaternion: x, y, z, w.
    pub rotation: [f64; 4],
    /// The time at which it holds; 0 if only static transforms connect the frames.
    pub stamp_ns: i64,
}

/// The identity.
impl Default for Transform {
    fn default() -> Self {
        Self {
            translation: [0.0; 3],
            rotation: [0.0, 0.0, 0.0, 1.0],
            stamp_ns: 0,
        }
    }
}

/// The transforms of a session: those it sets, which other sessions get, and those it receives.
///
/// Do not drop it inside a callback of its session: the library keeps it then, until the session ends.
pub struct Transforms(NonNull<sys::hgros_transforms>);

// SAFETY: any thread may use the handle; it is closed by its only owner, when nobody borrows it.
unsafe impl Send for Transforms {}
// SAFETY: as above.
unsafe impl Sync for Transforms {}

impl Session {
    /// Opens the transforms of the session, which has one at a time.
    pub fn transforms(&self) -> Result<Transforms> {
        let mut handle = null_mut();
        // SAFETY: the handle is valid.
        check(unsafe { sys::hgros_transforms_open(self.as_ptr(), &mut handle) })?;
        Ok(Transforms(
            NonNull::new(handle).expect("transforms were made"),
        ))
    }
}

impl Transforms {
    /// Sets and sends the pose of a child frame in its parent at the pose's stamp.
    pub fn set(&self, parent: &str, child: &str, pose: &Transform) -> Result<()> {
        self.send(parent, child, pose, sys::hgros_transforms_set)
    }

    /// The same for a pose that does not move: the stamp is ignored, and sessions that join later get it, too.
    pub fn set_static(&self, parent: &str, child: &str, pose: &Transform) -> Result<()> {
        self.send(parent, child, pose, sys::hgros_transforms_set_static)
    }

    fn send(
        &self,
        parent: &str,
        child: &str,
        pose: &Transform,
        set: unsafe extern "C" fn(
            *mut sys::hgros_transforms,
            *const c_char,
            *const c_char,
            *const sys::hgros_transform,
        ) -> sys::hgros_status,
    ) -> Result<()> {
        let (parent, child) = (text("frame", parent)?, text("frame", child)?);
        let Transform {
            translation,
            rotation,
            stamp_ns,
        } = *pose;
        let pose = sys::hgros_transform {
            translation,
            rotation,
            stamp_ns,
        };
        // SAFETY: the arguments are valid during the call.
        check(unsafe { set(self.0.as_ptr(), parent.as_ptr(), child.as_ptr(), &pose) })
    }

    /// The transform from a source frame to a target at the latest time that all edges between them have. The first
    /// lookup subscribes to the transforms of other sessions, which takes a moment.
    pub fn lookup(&self, target: &str, source: &str) -> Result<Transform> {
        self.find(target, source, |transforms, target, source, found| {
            // SAFETY: find() passes valid arguments.
            unsafe { sys::hgros_transforms_lookup(transforms, target, source, found) }
        })
    }

    /// The same at a time.
    pub fn lookup_at(&self, target: &str, source: &str, time_ns: i64) -> Result<Transform> {
        self.find(target, source, |transforms, target, source, found| {
            // SAFETY: find() passes valid arguments.
            unsafe { sys::hgros_transforms_lookup_at(transforms, target, source, time_ns, found) }
        })
    }

    /// The same, but waits until it is there. The error after the timeout says why it is not there.
    pub fn wait(
        &self,
        target: &str,
        source: &str,
        time_ns: i64,
        timeout: Duration,
    ) -> Result<Transform> {
        let timeout = nanoseconds(timeout);
        self.find(target, source, |transforms, target, source, found| {
            // SAFETY: find() passes valid arguments.
            unsafe {
                sys::hgros_transforms_wait(transforms, target, source, time_ns, timeout, found)
            }
        })
    }

    fn find(
        &self,
        target: &str,
        source: &str,
        look_up: impl FnOnce(
            *mut sys::hgros_transforms,
            *const c_char,
            *const c_char,
            *mut sys::hgros_transform,
        ) -> sys::hgros_status,
    ) -> Result<Transform> {
        let (target, source) = (text("frame", target)?, text("frame", source)?);
        let mut found = sys::hgros_transform::default();
        check(look_up(
            self.0.as_ptr(),
            target.as_ptr(),
            source.as_ptr(),
            &mut found,
        ))?;
        let sys::hgros_transform {
            translation,
            rotation,
            stamp_ns,
        } = found;
        Ok(Transform {
            translation,
            rotation,
            stamp_ns,
        })
    }
}

impl Drop for Transforms {
    fn drop(&mut self) {
        // SAFETY: the handle is this object's own. Inside a callback the library refuses, and ends it with the session.
        unsafe { sys::hgros_transforms_close(self.0.as_ptr()) };
    }
}
