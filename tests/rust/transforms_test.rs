//! Transforms.

use crate::*;
use hgros::Transform;
use std::time::SystemTime;

#[test]
fn transforms_are_found_by_name_and_waited_for() {
    let (robot, tool) = (session("transforms"), session("transforms"));
    let (sent, seen) = (robot.transforms().unwrap(), tool.transforms().unwrap());
    assert_eq!(status_of(robot.transforms().map(drop)), Status::Failed);
    let at = |translation| Transform { translation, ..Transform::default() };
    sent.set_static("map", "base", &at([1.0, 2.0, 3.0])).unwrap();
    assert_eq!(seen.wait("map", "base", 0, PATIENCE).unwrap(), at([1.0, 2.0, 3.0]));
    let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap().as_nanos() as i64;
    sent.set("base", "arm", &Transform { stamp_ns: now, ..at([0.0, 0.0, 1.0]) }).unwrap();
    let found = sent.lookup_at("map", "arm", now).unwrap();
    assert_eq!((found.translation, found.stamp_ns), ([1.0, 2.0, 4.0], now));
    assert_eq!(sent.lookup("map", "arm").unwrap(), found);
    let error = sent.lookup("map", "moon").unwrap_err();
    assert_eq!(error.status(), Status::UnknownFrame);
    assert!(error.sentence().contains("moon"), "{error}");
    assert_eq!(status_of(sent.lookup_at("map", "arm", now - 1_000_000_000)), Status::TooOld);
    assert_eq!(status_of(sent.set("moon", "arm", &at([0.0; 3]))), Status::Refused);
    let late = seen.wait("map", "moon", 0, BRIEFLY).unwrap_err();
    assert_eq!(late.status(), Status::TimedOut);
    assert!(late.sentence().contains("moon"), "{late}");
    std::thread::scope(|scope| {
        let waits = scope.spawn(|| seen.wait("map", "moon", 0, Duration::MAX));
        tool.end();
        assert_eq!(status_of(waits.join().unwrap()), Status::Closed);
    });
}
