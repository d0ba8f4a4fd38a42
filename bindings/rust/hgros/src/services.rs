//! Services, in both roles.

use crate::callback::Callback;
use crate::convert::{nanoseconds, sentence, text};
use crate::error::{check, Result};
use crate::message::Message;
use crate::publisher::encoded;
use crate::schema::{Schema, Type};
use crate::session::Session;
use hgros_sys as sys;
use std::fmt::Display;
use std::os::raw::c_void;
use std::ptr::{null_mut, NonNull};
use std::time::Duration;

/// Options of a service.
#[derive(Clone, Debug, Default)]
pub struct ServeOptions {
    /// Requests that may wait; further ones fail with [`Status::Full`](crate::Status::Full). 0: 16384.
    pub most_waiting: u64,
    /// Any number of requests may be handled at once.
    pub concurrent: bool,
}

/// Offers a service until it is dropped: requests that wait then fail. Outside callbacks that waits for running
/// handlers.
#[must_use = "the service ends when this is dropped"]
pub struct Service(NonNull<sys::hgros_service>);

// SAFETY: any thread may close a service; its only owner does.
unsafe impl Send for Service {}
// SAFETY: a shared borrow can do nothing.
unsafe impl Sync for Service {}

impl Session {
    /// Offers a service, for callers in this session and in others. The handler runs on a thread of the session; the
    /// text of its error becomes the caller's [`Status::HandlerFailed`](crate::Status::HandlerFailed), and so does a
    /// panic. A handler that calls a service handles requests of its own session meanwhile, perhaps with itself.
    pub fn serve<Q: Type, R: Type, E: Display>(
        &self,
        name: &str,
        options: ServeOptions,
        handler: impl Fn(Q) -> std::result::Result<R, E> + Send + Sync + 'static,
    ) -> Result<Service> {
        let answer = move |message: &Message| {
            let request = message.decode().map_err(|error| error.to_string())?;
            let reply = handler(request).map_err(|error| error.to_string())?;
            encoded(&reply).map_err(|error| error.to_string())
        };
        self.serve_bytes(
            name,
            &Schema::of::<Q>()?,
            &Schema::of::<R>()?,
            &options,
            answer,
        )
    }

    fn serve_bytes<F: Answer>(
        &self,
        name: &str,
        request: &Schema,
        reply: &Schema,
        options: &ServeOptions,
        answer: F,
    ) -> Result<Service> {
        let what = format!("The handler of service \"{name}\"");
        let name = text("name of the service", name)?;
        let options = sys::hgros_serve_options {
            most_waiting: options.most_waiting,
            concurrent: options.concurrent.into(),
            ..Default::default()
        };
        let user = Callback::new(&self.reports, what, answer).into_user();
        let mut handle = null_mut();
        // SAFETY: the arguments are valid during the call, and the library keeps `user` until it calls `release`.
        check(unsafe {
            sys::hgros_serve(
                self.as_ptr(),
                name.as_ptr(),
                request.as_ptr(),
                reply.as_ptr(),
                &options,
                Some(handle_request::<F>),
                user,
                Some(Callback::<F>::release),
                &mut handle,
            )
        })?;
        Ok(Service(NonNull::new(handle).expect("a service was made")))
    }

    /// Calls a service and waits for its reply. Inside a callback the thread meanwhile handles requests of its own
    /// session, so that it does not wait for itself.
    pub fn call<Q: Type, R: Type>(&self, name: &str, request: &Q, timeout: Duration) -> Result<R> {
        let name = text("name of the service", name)?;
        let (request_schema, reply_schema) = (Schema::of::<Q>()?, Schema::of::<R>()?);
        let data = encoded(request)?;
        let mut reply = null_mut();
        // SAFETY: the arguments are valid during the call, and the reply belongs to the caller.
        let reply = unsafe {
            check(sys::hgros_call(
                self.as_ptr(),
                name.as_ptr(),
                request_schema.as_ptr(),
                data.as_ptr().cast(),
                data.len(),
                reply_schema.as_ptr(),
                nanoseconds(timeout),
                &mut reply,
            ))?;
            Message::from(reply)
        };
        reply.decode()
    }
}

/// The encoded reply to a request, or why there is none.
trait Answer: Fn(&Message) -> std::result::Result<Vec<u8>, String> + Send + Sync + 'static {}
impl<F: Fn(&Message) -> std::result::Result<Vec<u8>, String> + Send + Sync + 'static> Answer for F {}

unsafe extern "C" fn handle_request<F: Answer>(
    user: *mut c_void,
    request: *const sys::hgros_message,
    reply: *mut sys::hgros_reply,
) {
    // SAFETY: what the library got in serve_bytes(), and a request and a reply that are valid until this returns.
    let (callback, request) = (Callback::<F>::from(user), Message::borrowed(request));
    let answer = callback
        .run(|handler| handler(&request))
        .and_then(|answer| answer);
    // If the reply cannot be taken, the library tells the caller that there is none.
    let _ = match answer {
        Ok(data) => sys::hgros_reply_set(reply, data.as_ptr().cast(), data.len()),
        Err(failure) => sys::hgros_reply_fail(reply, sentence(&failure).as_ptr()),
    };
}

impl Drop for Service {
    fn drop(&mut self) {
        // SAFETY: the handle is this object's own.
        unsafe { sys::hgros_service_close(self.0.as_ptr()) };
    }
}
