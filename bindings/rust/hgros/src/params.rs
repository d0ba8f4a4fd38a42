//! Parameters: of this program, and of other sessions.

use crate::callback::{Callback, CallbackReports};
use crate::convert::{string_from, text, Texts};
use crate::error::{check, Result};
use crate::observe::Watch;
use crate::param_value::{FromParam, ParamValue};
use crate::session::Session;
use hgros_sys as sys;
use std::ffi::CStr;
use std::os::raw::{c_char, c_void};
use std::ptr::{null_mut, NonNull};
use std::sync::Arc;
use std::time::Duration;

/// A tree of parameters. A path is written like `slam.matcher.gains[2]`.
///
/// Do not drop it inside a callback of its session: the library keeps it then, until the session ends.
pub struct Params {
    handle: NonNull<sys::hgros_params>,
    reports: Arc<CallbackReports>,
}

// SAFETY: any thread may use the handle; it is closed by its only owner, when nobody borrows it.
unsafe impl Send for Params {}
// SAFETY: as above.
unsafe impl Sync for Params {}

/// What a parameter is that this program declares.
#[derive(Clone, Debug, Default)]
pub struct ParamInfo {
    pub description: String,
    pub unit: String,
    /// Keeps the value from the start of the program.
    pub read_only: bool,
    /// The least value of a number, or of each number of a list.
    pub least: Option<f64>,
    /// The greatest one.
    pub most: Option<f64>,
    /// For a text.
    pub choices: Vec<String>,
}

impl Session {
    /// The parameters of this program, from YAML files, later ones over earlier ones. Other sessions may read and set
    /// them under this session's name.
    pub fn params(&self, files: &[&str]) -> Result<Params> {
        let files = Texts::new("path", files)?;
        let mut handle = null_mut();
        // SAFETY: the arguments are valid during the call.
        check(unsafe {
            sys::hgros_params_open(self.as_ptr(), files.as_ptr(), files.len(), &mut handle)
        })?;
        Ok(self.params_with(handle))
    }

    /// The parameters that another session offers under `name`. Each function on them asks that session, and waits at
    /// most `timeout`. Do not call them in inline callbacks, or in callbacks of that session's parameters.
    pub fn params_of(&self, name: &str, timeout: Duration) -> Result<Params> {
        let name = text("name of the session", name)?;
        // Forever is no timeout here.
        let timeout = i64::try_from(timeout.as_nanos()).unwrap_or(i64::MAX);
        let mut handle = null_mut();
        // SAFETY: the arguments are valid during the call.
        check(unsafe { sys::hgros_params_of(self.as_ptr(), name.as_ptr(), timeout, &mut handle) })?;
        Ok(self.params_with(handle))
    }

    fn params_with(&self, handle: *mut sys::hgros_params) -> Params {
        let handle = NonNull::new(handle).expect("parameters were made");
        Params {
            handle,
            reports: Arc::clone(&self.reports),
        }
    }
}

impl Params {
    /// Gives a parameter of this program its kind, and the value that it has if it was never set.
    pub fn declare(&self, path: &str, fallback: impl ParamValue, info: &ParamInfo) -> Result<()> {
        let kind = fallback.kind();
        let (path, fallback) = (text("path", path)?, text("value", &fallback.to_yaml()?)?);
        let (description, unit) = (
            text("description", &info.description)?,
            text("unit", &info.unit)?,
        );
        let choices = Texts::new("choice", &info.choices)?;
        let info = sys::hgros_param_info {
            read_only: info.read_only.into(),
            description: description.as_ptr(),
            unit: unit.as_ptr(),
            has_least: info.least.is_some().into(),
            has_most: info.most.is_some().into(),
            least: info.least.unwrap_or_default(),
            most: info.most.unwrap_or_default(),
            choices: choices.as_ptr(),
            choice_count: choices.len(),
            ..Default::default()
        };
        // SAFETY: the arguments are valid during the call.
        check(unsafe {
            sys::hgros_params_declare(self.as_ptr(), path.as_ptr(), kind, fallback.as_ptr(), &info)
        })
    }

    /// Reads a value: a bool, i64, f64, String or Vec<f64>.
    pub fn get<V: FromParam>(&self, path: &str) -> Result<V> {
        V::get(self, path)
    }

    /// Sets a value: a bool, i64, f64, text or numbers.
    pub fn set(&self, path: &str, value: impl ParamValue) -> Result<()> {
        value.set(self, path)
    }

    /// Reads any value as YAML. An empty path is the whole tree.
    pub fn yaml(&self, path: &str) -> Result<String> {
        self.read_text(path, sys::hgros_params_get)
    }

    /// Sets a value as YAML, such as "{x: 1}".
    pub fn set_yaml(&self, path: &str, yaml: &str) -> Result<()> {
        let yaml = text("value", yaml)?;
        // SAFETY: the arguments are valid during the call.
        self.at(path, |path| unsafe {
            sys::hgros_params_set(self.as_ptr(), path, yaml.as_ptr())
        })
    }

    /// Removes a value; a declared parameter returns to its fallback.
    pub fn remove(&self, path: &str) -> Result<()> {
        // SAFETY: the arguments are valid during the call.
        self.at(path, |path| unsafe {
            sys::hgros_params_remove(self.as_ptr(), path)
        })
    }

    /// Writes what was set at run time into the files of this program.
    pub fn save(&self) -> Result<()> {
        // SAFETY: the handle is valid.
        check(unsafe { sys::hgros_params_save(self.as_ptr()) })
    }

    /// Calls a function for each changed value at, below or above a path, with its YAML, or None if it was removed. It
    /// runs on the thread that makes the change, perhaps inside itself if it makes one; for another session on a
    /// worker, first with all current values.
    pub fn on_change(
        &self,
        path: &str,
        changed: impl Fn(&str, Option<&str>) + Send + Sync + 'static,
    ) -> Result<Watch> {
        self.watch(path, changed)
    }

    fn watch<F: Changed>(&self, path: &str, changed: F) -> Result<Watch> {
        let what = format!("The callback of parameter \"{path}\"");
        let path = text("path", path)?;
        let user = Callback::new(&self.reports, what, changed).into_user();
        let mut watch = null_mut();
        // SAFETY: the arguments are valid during the call, and the library keeps `user` until it calls `release`.
        check(unsafe {
            let release = Some(Callback::<F>::release as _);
            sys::hgros_params_watch(
                self.as_ptr(),
                path.as_ptr(),
                Some(tell::<F>),
                user,
                release,
                &mut watch,
            )
        })?;
        Ok(Watch::from(watch))
    }

    pub(crate) fn as_ptr(&self) -> *mut sys::hgros_params {
        self.handle.as_ptr()
    }

    pub(crate) fn at(
        &self,
        path: &str,
        call: impl FnOnce(*const c_char) -> sys::hgros_status,
    ) -> Result<()> {
        let path = text("path", path)?;
        check(call(path.as_ptr()))
    }

    pub(crate) fn read_text(
        &self,
        path: &str,
        read: unsafe extern "C" fn(
            *mut sys::hgros_params,
            *const c_char,
            *mut *mut c_char,
        ) -> sys::hgros_status,
    ) -> Result<String> {
        let mut value = null_mut();
        // SAFETY: the arguments are valid during the call, and the text belongs to the caller.
        unsafe {
            self.at(path, |path| read(self.as_ptr(), path, &mut value))?;
            let copy = string_from(value);
            sys::hgros_text_free(value);
            Ok(copy)
        }
    }
}

impl Drop for Params {
    fn drop(&mut self) {
        // SAFETY: the handle is this object's own. Inside a callback the library refuses, and ends it with the session.
        unsafe { sys::hgros_params_close(self.as_ptr()) };
    }
}

trait Changed: Fn(&str, Option<&str>) + Send + Sync + 'static {}
impl<F: Fn(&str, Option<&str>) + Send + Sync + 'static> Changed for F {}

unsafe extern "C" fn tell<F: Changed>(user: *mut c_void, path: *const c_char, yaml: *const c_char) {
    // SAFETY: what the library got in watch(), and texts that are valid until this returns.
    let callback = Callback::<F>::from(user);
    let path = CStr::from_ptr(path).to_string_lossy();
    let yaml = (!yaml.is_null()).then(|| CStr::from_ptr(yaml).to_string_lossy());
    // A panic is reported.
    let _ = callback.run(|changed| changed(&path, yaml.as_deref()));
}
