//! The tests of the binding for Rust. CTest runs each module in a process of its own.

mod abi_test;
mod callbacks_test;
mod memory_test;
mod messages_test;
mod parts_test;
mod queues_test;
mod services_test;
mod session_test;

use hgros::{Error, PublishOptions, Publisher, Queue, Session, Status, Subscription};
use hgros_messages::foxglove::Log;
use std::fmt::Debug;
use std::time::{Duration, Instant};

const PATIENCE: Duration = Duration::from_secs(45);
const BRIEFLY: Duration = Duration::from_millis(20);

/// A session that meets only those of the same test.
fn session(test: &str) -> Session {
    named_session(test, "")
}

fn named_session(test: &str, name: &str) -> Session {
    Session::builder().name(name).open(&configuration(test)).unwrap()
}

fn configuration(test: &str) -> String {
    format!("discovery: {{domain: {}}}", domain(test))
}

fn domain(test: &str) -> String {
    format!("rust-{}-{test}", std::process::id())
}

fn log_of(text: impl ToString) -> Log {
    let mut log = Log::new();
    log.set_message(text.to_string());
    log
}

/// A publisher and a queue in two sessions, which know each other.
fn pair(from: &Session, to: &Session, channel: &str, queue: Queue) -> (Publisher<Log>, Subscription<Log>) {
    let subscription = to.subscribe(channel, queue).unwrap();
    let publisher = from.advertise(channel, PublishOptions::default()).unwrap();
    from.wait_for_subscribers(channel, 1, PATIENCE).unwrap();
    (publisher, subscription)
}

#[track_caller]
fn status_of<T: Debug>(result: Result<T, Error>) -> Status {
    result.expect_err("should have failed").status()
}

#[track_caller]
fn wait_until(what: &str, mut holds: impl FnMut() -> bool) {
    let end = Instant::now() + PATIENCE;
    while !holds() {
        assert!(Instant::now() < end, "{what}: not in time");
        std::thread::sleep(Duration::from_millis(2));
    }
}
