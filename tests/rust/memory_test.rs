//! The memory of the process, in one of its own.

use crate::*;
use std::sync::mpsc::sync_channel;

/// The resident memory of this process, in KiB.
fn resident_kib() -> i64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find(|line| line.starts_with("VmRSS:")).unwrap();
    line.split_whitespace().nth(1).unwrap().parse().unwrap()
}

#[test]
fn memory_does_not_grow_over_100000_messages() {
    const MESSAGES: usize = 100_000;
    let (from, to) = (session("memory"), session("memory"));
    let (publisher, queue) = pair(&from, &to, "words", Queue::KeepAll(64));
    let (sender, heard) = sync_channel(1000);
    let listener = to.on("words", Queue::KeepAll(64), move |log: Log| drop(sender.send(log.message.len()))).unwrap();
    let log = log_of("x".repeat(1000));
    let exchange = |count: usize| {
        std::thread::scope(|scope| {
            scope.spawn(|| (0..count).for_each(|_| publisher.publish_wait(&log, PATIENCE).unwrap()));
            for log in queue.iter_timeout(PATIENCE).take(count) {
                assert_eq!(log.unwrap().message.len(), 1000);
                assert_eq!(heard.recv_timeout(PATIENCE).unwrap(), 1000);
            }
        });
    };
    exchange(MESSAGES / 10);
    let before = resident_kib();
    exchange(MESSAGES);
    let grown = resident_kib() - before;
    // 16 bytes per message would be 1600 KiB.
    assert!(grown < 1500, "grew by {grown} KiB");
    drop(listener);
    drop(queue);
    assert_eq!(from.callback_failures() + to.callback_failures(), 0);
}
