//! The kinds of values that a parameter has.

use crate::convert::text;
use crate::error::{Error, Result, Status};
use crate::params::Params;
use hgros_sys as sys;
use std::fmt::Write;

mod sealed {
    pub trait Sealed {}
    impl Sealed for bool {}
    impl Sealed for i64 {}
    impl Sealed for f64 {}
    impl Sealed for &str {}
    impl Sealed for String {}
    impl Sealed for &[f64] {}
    impl Sealed for Vec<f64> {}
}

/// What a parameter can be set to.
pub trait ParamValue: sealed::Sealed {
    #[doc(hidden)]
    fn kind(&self) -> i32;
    #[doc(hidden)]
    fn to_yaml(&self) -> Result<String>;
    #[doc(hidden)]
    fn set(&self, params: &Params, path: &str) -> Result<()>;
}

/// What a parameter can be read as.
pub trait FromParam: sealed::Sealed + Sized {
    #[doc(hidden)]
    fn get(params: &Params, path: &str) -> Result<Self>;
}

impl ParamValue for bool {
    fn kind(&self) -> i32 {
        sys::HGROS_PARAM_BOOL
    }
    fn to_yaml(&self) -> Result<String> {
        Ok(self.to_string())
    }
    fn set(&self, params: &Params, path: &str) -> Result<()> {
        // SAFETY: the arguments are valid during the call.
        params.at(path, |path| unsafe {
            sys::hgros_params_set_bool(params.as_ptr(), path, (*self).into())
        })
    }
}

impl FromParam for bool {
    fn get(params: &Params, path: &str) -> Result<Self> {
        let mut value = 0;
        // SAFETY: the arguments are valid during the call.
        params.at(path, |path| unsafe {
            sys::hgros_params_get_bool(params.as_ptr(), path, &mut value)
        })?;
        Ok(value != 0)
    }
}

impl ParamValue for i64 {
    fn kind(&self) -> i32 {
        sys::HGROS_PARAM_INTEGER
    }
    fn to_yaml(&self) -> Result<String> {
        Ok(self.to_string())
    }
    fn set(&self, params: &Params, path: &str) -> Result<()> {
        // SAFETY: the arguments are valid during the call.
        params.at(path, |path| unsafe {
            sys::hgros_params_set_integer(params.as_ptr(), path, *self)
        })
    }
}

impl FromParam for i64 {
    fn get(params: &Params, path: &str) -> Result<Self> {
        let mut value = 0;
        // SAFETY: the arguments are valid during the call.
        params.at(path, |path| unsafe {
            sys::hgros_params_get_integer(params.as_ptr(), path, &mut value)
        })?;
        Ok(value)
    }
}

impl ParamValue for f64 {
    fn kind(&self) -> i32 {
        sys::HGROS_PARAM_NUMBER
    }
    fn to_yaml(&self) -> Result<String> {
        require_finite(self)?;
        Ok(format!("{self:?}"))
    }
    fn set(&self, params: &Params, path: &str) -> Result<()> {
        // SAFETY: the arguments are valid during the call.
        params.at(path, |path| unsafe {
            sys::hgros_params_set_number(params.as_ptr(), path, *self)
        })
    }
}

impl FromParam for f64 {
    fn get(params: &Params, path: &str) -> Result<Self> {
        let mut value = 0.0;
        // SAFETY: the arguments are valid during the call.
        params.at(path, |path| unsafe {
            sys::hgros_params_get_number(params.as_ptr(), path, &mut value)
        })?;
        Ok(value)
    }
}

impl ParamValue for &str {
    fn kind(&self) -> i32 {
        sys::HGROS_PARAM_TEXT
    }
    fn to_yaml(&self) -> Result<String> {
        Ok(quoted(self))
    }
    fn set(&self, params: &Params, path: &str) -> Result<()> {
        let value = text("value", self)?;
        // SAFETY: the arguments are valid during the call.
        params.at(path, |path| unsafe {
            sys::hgros_params_set_text(params.as_ptr(), path, value.as_ptr())
        })
    }
}

impl ParamValue for String {
    fn kind(&self) -> i32 {
        self.as_str().kind()
    }
    fn to_yaml(&self) -> Result<String> {
        self.as_str().to_yaml()
    }
    fn set(&self, params: &Params, path: &str) -> Result<()> {
        self.as_str().set(params, path)
    }
}

impl FromParam for String {
    fn get(params: &Params, path: &str) -> Result<Self> {
        params.read_text(path, sys::hgros_params_get_text)
    }
}

impl ParamValue for &[f64] {
    fn kind(&self) -> i32 {
        sys::HGROS_PARAM_NUMBERS
    }
    fn to_yaml(&self) -> Result<String> {
        self.iter().try_for_each(require_finite)?;
        Ok(format!("{self:?}")) // [1.0, 2.5]
    }
    fn set(&self, params: &Params, path: &str) -> Result<()> {
        params.set_yaml(path, &self.to_yaml()?)
    }
}

impl ParamValue for Vec<f64> {
    fn kind(&self) -> i32 {
        self.as_slice().kind()
    }
    fn to_yaml(&self) -> Result<String> {
        self.as_slice().to_yaml()
    }
    fn set(&self, params: &Params, path: &str) -> Result<()> {
        self.as_slice().set(params, path)
    }
}

impl FromParam for Vec<f64> {
    fn get(params: &Params, path: &str) -> Result<Self> {
        let yaml = params.yaml(path)?;
        let refused = || {
            Error::new(
                Status::Refused,
                format!("{path} is {yaml}, but is read as a list of numbers."),
            )
        };
        let items = yaml
            .trim()
            .strip_prefix('[')
            .and_then(|rest| rest.strip_suffix(']'))
            .ok_or_else(refused)?;
        if items.trim().is_empty() {
            return Ok(Vec::new());
        }
        items
            .split(',')
            .map(|item| item.trim().parse().map_err(|_| refused()))
            .collect()
    }
}

fn require_finite(number: &f64) -> Result<()> {
    if number.is_finite() {
        return Ok(());
    }
    Err(Error::new(
        Status::InvalidArgument,
        format!("A parameter must be finite, but is {number}."),
    ))
}

/// A text as YAML has it in double quotes.
fn quoted(text: &str) -> String {
    let mut yaml = String::from("\"");
    for character in text.chars() {
        match character {
            '"' | '\\' => yaml.extend(['\\', character]),
            _ if character.is_control() => {
                write!(yaml, "\\u{:04x}", character as u32).expect("a String takes all")
            }
            _ => yaml.push(character),
        }
    }
    yaml.push('"');
    yaml
}
