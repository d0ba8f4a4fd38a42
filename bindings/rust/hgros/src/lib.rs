//! The binding of HyperGraph ROS for Rust, a layer over the C interface (`hgros/hgros.h`).
//!
//! A [`Session`] is one participant. [`Session::advertise`] and [`Session::subscribe`] give publishers and queues of
//! protobuf messages, [`Session::serve`] and [`Session::call`] are services. What can fail returns a [`Result`] whose
//! [`Error`] has a [`Status`] and a sentence. A timeout of [`Duration::MAX`](std::time::Duration::MAX) waits forever,
//! one of zero does not wait.
//!
//! Everything may be used by any thread. Handles end what they stand for when they are dropped, in any order, also
//! inside callbacks. [`Session::end`] wakes all threads that wait. Inside a callback of its session, [`Transforms`] and
//! [`Params`] end later, with the session, and a [`Session`] says goodbye but stays until the process ends. The same
//! holds for what a callback has captured if it is dropped on the thread that has run the callback.
//!
//! A panic in a callback does not leave it: [`Session::callback_failures`] counts it, and the
//! log has lines about ten of a callback, then fewer.
//! The caller of a service gets it as an error.

mod callback;
mod convert;
mod error;
mod listener;
mod loan;
mod message;
mod observe;
mod param_value;
mod params;
mod publisher;
mod schema;
mod services;
mod session;
mod subscription;
mod transforms;

pub use error::{Error, Result, Status};
pub use listener::Listener;
pub use loan::{Loan, NotPublished};
pub use message::{leases, Info, Message};
pub use observe::{Channel, Peer, PeerChange, PeerEvent, Watch};
pub use param_value::{FromParam, ParamValue};
pub use params::{ParamInfo, Params};
pub use publisher::{Publish, PublishOptions, Publisher};
pub use schema::{Encoding, Schema, Type};
pub use services::{ServeOptions, Service};
pub use session::{version, Level, Session, SessionBuilder};
pub use subscription::{Executor, Iter, Queue, Receive, Stats, SubscribeOptions, Subscription};
pub use transforms::{Transform, Transforms};
