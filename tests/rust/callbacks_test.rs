//! Callbacks, panics in them, and what may be dropped in them.

use crate::*;
use hgros::{Executor, Listener, Schema, SubscribeOptions};
use std::sync::mpsc::{channel, Receiver, Sender};
use std::sync::{Arc, Mutex};

fn lines() -> (impl FnMut(hgros::Level, &str) + Send, Receiver<String>) {
    let (sender, receiver) = channel();
    let log = move |_: hgros::Level, line: &str| sender.send(line.to_owned()).unwrap();
    (log, receiver)
}

#[test]
fn callbacks_get_messages_in_order() {
    let (from, to) = (session("callbacks"), session("callbacks"));
    for executor in [Executor::Workers, Executor::Inline, Executor::Dedicated] {
        let channel_name = format!("{executor:?}");
        let (sender, received) = channel();
        let options = SubscribeOptions { queue: Queue::KeepAll(10), executor, ..SubscribeOptions::default() };
        let listener = to.on(&channel_name, options, move |log: Log| sender.send(log.message).unwrap()).unwrap();
        let publisher = from.advertise(&channel_name, PublishOptions::default()).unwrap();
        from.wait_for_subscribers(&channel_name, 1, PATIENCE).unwrap();
        for number in 0..100 {
            publisher.publish_wait(&log_of(number), PATIENCE).unwrap();
        }
        for number in 0..100 {
            assert_eq!(received.recv_timeout(PATIENCE).unwrap(), number.to_string());
        }
        to.wait_idle(PATIENCE).unwrap();
        assert_eq!(listener.stats().unwrap().taken, 100);
    }
}

#[test]
fn a_message_of_a_callback_can_be_kept() {
    let session = session("kept");
    let (sender, kept) = channel();
    let _listener =
        session.on_raw("words", None, Queue::default(), move |message| sender.send(message.clone()).unwrap()).unwrap();
    let publisher = session.advertise("words", PublishOptions::default()).unwrap();
    publisher.publish(&log_of("kept")).unwrap();
    assert_eq!(kept.recv_timeout(PATIENCE).unwrap().decode::<Log>().unwrap().message, "kept");
}

#[test]
fn a_panic_in_a_callback_and_a_message_that_it_cannot_get_are_reported_and_counted() {
    let (log, said) = lines();
    let session = Session::builder().log(log).open(&configuration("panic")).unwrap();
    let (sender, received) = channel();
    let _listener = session
        .on("words", Queue::KeepAll(10), move |log: Log| match log.get_message() {
            "panic" => panic!("a mouse"),
            text => sender.send(text.to_owned()).unwrap(),
        })
        .unwrap();
    let publisher = session.advertise("words", PublishOptions::default()).unwrap();
    for text in ["panic", "next", "panic"] {
        publisher.publish(&log_of(text)).unwrap();
    }
    assert_eq!(received.recv_timeout(PATIENCE).unwrap(), "next");
    session.wait_idle(PATIENCE).unwrap();
    assert_eq!(session.callback_failures(), 2);
    assert_eq!(said.recv_timeout(PATIENCE).unwrap(), "The callback of channel \"words\" panicked: a mouse");
    drop(publisher);
    let publisher = session.advertise_raw("words", &Schema::of::<Log>().unwrap(), PublishOptions::default()).unwrap();
    publisher.publish(&[3 << 3 | 2, 100]).unwrap();
    session.wait_idle(PATIENCE).unwrap();
    assert_eq!(session.callback_failures(), 3);
    while !said.recv_timeout(PATIENCE).unwrap().contains("foxglove.Log cannot be read") {}
}

#[test]
fn a_panic_in_the_log_is_counted() {
    let log = |_: hgros::Level, _: &str| panic!("the pen broke");
    let session = Session::builder().log(log).open(&configuration("panic-log")).unwrap();
    session.log(hgros::Level::Error, "Write this.").unwrap();
    wait_until("the panic is counted", || session.callback_failures() == 1);
}

/// Panics when it is destroyed, as the closure that owns it is.
struct Fragile;
impl Drop for Fragile {
    fn drop(&mut self) {
        panic!("it broke");
    }
}

#[test]
fn a_closure_may_panic_when_it_is_destroyed() {
    let session = session("fragile");
    let fragile = Fragile;
    let listener = session.on("words", Queue::default(), move |_: Log| drop(&fragile)).unwrap();
    drop(listener);
    assert_eq!(session.callback_failures(), 1);
}

#[test]
fn a_listener_may_be_dropped_inside_its_callback() {
    let session = session("own-end");
    let slot: Arc<Mutex<Option<Listener>>> = Arc::default();
    let (sender, received): (Sender<&str>, _) = channel();
    let own = Arc::clone(&slot);
    let mut guard = slot.lock().unwrap();
    let listener = session.on("words", Queue::KeepAll(10), move |_: Log| {
        sender.send("called").unwrap();
        drop(own.lock().unwrap().take());
        sender.send("still here").unwrap();
    });
    *guard = Some(listener.unwrap());
    drop(guard);
    let publisher = session.advertise("words", PublishOptions::default()).unwrap();
    publisher.publish(&log_of(1)).unwrap();
    publisher.publish(&log_of(2)).unwrap();
    assert_eq!(received.recv_timeout(PATIENCE).unwrap(), "called");
    assert_eq!(received.recv_timeout(PATIENCE).unwrap(), "still here");
    // The closure is destroyed, and with it the sender.
    assert!(received.recv_timeout(PATIENCE).is_err());
    assert!(slot.lock().unwrap().is_none());
}

#[test]
fn a_callback_may_publish_and_end_its_session() {
    let session = Arc::new(session("in-callback"));
    let (publisher, queue) = pair(&session, &session, "echo", Queue::default());
    let inner = Arc::clone(&session);
    let listener = session.on("words", Queue::default(), move |log: Log| {
        publisher.publish(&log).unwrap();
        inner.end();
    });
    let words = session.advertise("words", PublishOptions::default()).unwrap();
    words.publish(&log_of("x")).unwrap();
    wait_until("the session ends", || match queue.recv_timeout(PATIENCE) {
        Ok(log) => log.message != "x",
        Err(error) => error.status() == Status::Closed,
    });
    assert_eq!(status_of(words.publish(&log_of("y"))), Status::Closed);
    drop(listener);
    assert_eq!(session.callback_failures(), 0);
    Arc::try_unwrap(session).ok().expect("the callback and its session are gone");
}

#[test]
fn a_callback_may_own_its_session() {
    let session = Arc::new(session("owner"));
    let inner = Arc::clone(&session);
    let listener = session.on("words", Queue::default(), move |_: Log| assert!(inner.id() != 0)).unwrap();
    let publisher = session.advertise("words", PublishOptions::default()).unwrap();
    publisher.publish(&log_of(1)).unwrap();
    session.wait_idle(PATIENCE).unwrap();
    drop(session);
    publisher.publish(&log_of(2)).unwrap();
    drop(listener); // And with it the session.
    assert_eq!(status_of(publisher.publish(&log_of(3))), Status::Closed);
}

#[test]
fn a_handler_may_own_its_session() {
    let session = Arc::new(session("owner-service"));
    let inner = Arc::clone(&session);
    let handler = move |request: Log| {
        if inner.id() != 0 {
            Ok(request)
        } else {
            Err("no id")
        }
    };
    let service = session.serve("same", hgros::ServeOptions::default(), handler).unwrap();
    let reply: Log = session.call("same", &log_of("x"), PATIENCE).unwrap();
    assert_eq!(reply.message, "x");
    let inner = Arc::clone(&session);
    let watch = session.on_peer(move |_| assert!(inner.id() != 0)).unwrap();
    let publisher = session.advertise("words", PublishOptions::default()).unwrap();
    drop(session);
    drop(service);
    publisher.publish(&log_of(1)).unwrap();
    drop(watch);
    assert_eq!(status_of(publisher.publish(&log_of(2))), Status::Closed);
}
