//! Queues: what they drop or hold back, and what ends a wait.

use crate::*;
use hgros::SubscribeOptions;
use std::os::unix::io::{AsRawFd, RawFd};
use std::os::unix::net::UnixStream;
use std::sync::mpsc::{channel, Sender};

#[test]
fn a_keep_last_queue_drops_the_oldest() {
    let session = session("newest");
    let (publisher, queue) = pair(&session, &session, "words", Queue::KeepLast(2));
    for number in 0..5 {
        publisher.publish(&log_of(number)).unwrap();
    }
    let stats = queue.stats().unwrap();
    assert_eq!((stats.received, stats.dropped, stats.queued), (5, 3, 2));
    assert_eq!(queue.try_recv().unwrap().unwrap().message, "3");
    assert_eq!(queue.try_recv().unwrap().unwrap().message, "4");
    assert_eq!(queue.try_recv().unwrap(), None);
}

#[test]
fn a_lossless_queue_holds_its_publishers_back() {
    let session = session("full");
    let (publisher, queue) = pair(&session, &session, "words", Queue::KeepAllBytes { messages: 2, bytes: 1000 });
    publisher.publish(&log_of(1)).unwrap();
    publisher.publish(&log_of(2)).unwrap();
    let error = publisher.publish(&log_of(3)).unwrap_err();
    assert_eq!(error.status(), Status::Full);
    assert!(error.sentence().contains("words"), "{error}");
    assert_eq!(status_of(publisher.publish_wait(&log_of(3), BRIEFLY)), Status::TimedOut);
    queue.recv().unwrap();
    publisher.publish_wait(&log_of(3), PATIENCE).unwrap();
}

#[test]
fn iterators_end_with_the_queue_or_with_a_time_out() {
    let session = session("iterators");
    let (publisher, queue) = pair(&session, &session, "words", Queue::default());
    publisher.publish(&log_of(1)).unwrap();
    let mut items = queue.iter_timeout(BRIEFLY);
    assert_eq!(items.next().unwrap().unwrap().message, "1");
    assert_eq!(status_of(items.next().unwrap()), Status::TimedOut);
    assert!(items.next().is_none());
    publisher.publish(&log_of(2)).unwrap();
    assert_eq!((&queue).into_iter().next().unwrap().unwrap().message, "2");
    queue.end();
    assert!(queue.iter().next().is_none());
}

fn take(started: Sender<()>, queue: &Subscription<Log>) -> Result<Log, Error> {
    started.send(()).unwrap();
    queue.recv()
}

#[test]
fn what_waits_is_woken() {
    let session = session("woken");
    let ended = session.subscribe::<Log>("a", Queue::default()).unwrap();
    let with_session = session.subscribe::<Log>("b", Queue::default()).unwrap();
    let (full, _queue) = pair(&session, &session, "c", Queue::KeepAll(1));
    full.publish(&log_of(1)).unwrap();
    let (waiting, waits) = channel();
    std::thread::scope(|scope| {
        let started = waiting.clone();
        let one = scope.spawn(|| take(started, &ended));
        waits.recv().unwrap();
        ended.end();
        assert_eq!(status_of(one.join().unwrap()), Status::Closed);
        let (first, second) = (waiting.clone(), waiting);
        let queue = scope.spawn(|| take(first, &with_session));
        let room = scope.spawn(|| {
            let second = second; // Moved here.
            second.send(()).unwrap();
            full.publish_wait(&log_of(2), Duration::MAX)
        });
        waits.recv().unwrap();
        waits.recv().unwrap();
        session.end();
        assert_eq!(status_of(queue.join().unwrap()), Status::Closed);
        assert_eq!(status_of(room.join().unwrap()), Status::Closed);
    });
}

#[test]
fn a_session_is_dropped_while_others_use_what_it_made() {
    let session = session("dropped");
    let (publisher, queue) = pair(&session, &session, "words", Queue::default());
    let waits = std::thread::spawn(move || queue.iter().map(Result::unwrap).count());
    let sends = std::thread::spawn(move || loop {
        if let Err(error) = publisher.publish(&log_of("x")) {
            return error.status();
        }
    });
    wait_until("a message is published", || {
        let channels = session.channels().unwrap();
        channels.iter().any(|channel| channel.name == "words" && channel.publishers == 1)
    });
    drop(session);
    assert_eq!(sends.join().unwrap(), Status::Closed);
    waits.join().unwrap();
}

extern "C" {
    fn poll(descriptors: *mut PollEntry, count: u64, timeout_ms: i32) -> i32;
}

#[repr(C)]
struct PollEntry {
    descriptor: RawFd,
    wanted: i16,
    came: i16,
}

/// Which descriptor is readable first, as an event loop sees it.
fn first_readable(descriptors: &[RawFd]) -> Option<usize> {
    const POLLIN: i16 = 1;
    let entry = |&descriptor: &RawFd| PollEntry { descriptor, wanted: POLLIN, came: 0 };
    let mut entries: Vec<PollEntry> = descriptors.iter().map(entry).collect();
    // SAFETY: the entries live during the call.
    unsafe { poll(entries.as_mut_ptr(), entries.len() as u64, PATIENCE.as_millis() as i32) };
    entries.iter().position(|entry| entry.came != 0)
}

#[test]
fn one_thread_waits_for_several_queues() {
    let session = session("poll");
    let (publisher, first) = pair(&session, &session, "a", Queue::default());
    let options = SubscribeOptions { name: "second".to_owned(), ..SubscribeOptions::default() };
    let second = session.subscribe::<Log>("b", options).unwrap();
    let (_other, other_end) = UnixStream::pair().unwrap();
    let descriptors = [second.as_raw_fd(), other_end.as_raw_fd(), first.as_raw_fd()];
    publisher.publish(&log_of(1)).unwrap();
    assert_eq!(first_readable(&descriptors), Some(2));
    assert_eq!(first.try_recv().unwrap().unwrap().message, "1");
    assert!(first.try_recv().unwrap().is_none());
    second.end();
    assert_eq!(first_readable(&descriptors), Some(0));
    assert_eq!(status_of(second.try_recv()), Status::Closed);
}
