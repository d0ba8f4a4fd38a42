//! Parameters and transforms.

use crate::*;
use hgros::{ParamInfo, Transform};
use std::sync::mpsc::sync_channel;
use std::time::SystemTime;

#[test]
fn parameters_are_declared_set_and_watched() {
    let session = session("params");
    let file = std::env::temp_dir().join(format!("{}.yaml", domain("params")));
    std::fs::write(&file, "wheel: {radius: 0.25}\n").unwrap();
    let params = session.params(&[file.to_str().unwrap()]).unwrap();
    std::fs::remove_file(file).unwrap();
    let none = ParamInfo::default();
    let bounded = ParamInfo { unit: "m".to_owned(), most: Some(1.0), ..ParamInfo::default() };
    params.declare("wheel.radius", 0.1, &bounded).unwrap();
    params.declare("wheel.count", 4, &none).unwrap();
    params.declare("name", "it's:\t\"mine\" \\ é", &none).unwrap();
    params.declare("gains", vec![1.0, 2.5], &none).unwrap();
    params.declare("on", true, &none).unwrap();
    let choices = ParamInfo { choices: vec!["fast".to_owned(), "slow".to_owned()], ..ParamInfo::default() };
    params.declare("mode", "fast".to_owned(), &choices).unwrap();
    assert_eq!(params.get::<f64>("wheel.radius").unwrap(), 0.25);
    assert_eq!(params.get::<i64>("wheel.count").unwrap(), 4);
    assert_eq!(params.get::<String>("name").unwrap(), "it's:\t\"mine\" \\ é");
    assert_eq!(params.get::<Vec<f64>>("gains").unwrap(), [1.0, 2.5]);
    assert!(params.get::<bool>("on").unwrap());
    assert_eq!(params.yaml("gains").unwrap(), "[1.0, 2.5]");
    let error = params.declare("x", f64::NAN, &none).unwrap_err();
    assert_eq!(error.status(), Status::InvalidArgument);
    assert_eq!(error.sentence(), "A parameter must be finite, but is NaN.");
    let infinite = vec![1.0, f64::INFINITY];
    assert_eq!(status_of(params.declare("y", infinite, &none)), Status::InvalidArgument);

    let (sender, changes) = sync_channel(10);
    let watch = params
        .on_change("wheel", move |path, yaml| sender.send((path.to_owned(), yaml.map(str::to_owned))).unwrap())
        .unwrap();
    params.set("wheel.radius", 0.5).unwrap();
    assert_eq!(changes.recv_timeout(PATIENCE).unwrap(), ("wheel.radius".to_owned(), Some("0.5".to_owned())));
    let error = params.set("wheel.radius", 2.0).unwrap_err();
    assert_eq!(error.status(), Status::Refused);
    assert!(error.sentence().contains("wheel.radius"), "{error}");
    assert_eq!(status_of(params.set("mode", "sideways")), Status::Refused);
    params.set("mode", String::from("slow")).unwrap();
    params.set("on", false).unwrap();
    params.set("gains", [3.0].as_slice()).unwrap();
    params.set("gains", Vec::new()).unwrap();
    assert_eq!(params.get::<Vec<f64>>("gains").unwrap(), []);
    assert_eq!(status_of(params.get::<Vec<f64>>("mode")), Status::Refused);
    params.remove("wheel.radius").unwrap();
    assert_eq!(params.get::<f64>("wheel.radius").unwrap(), 0.1);
    drop(watch);
    assert_eq!(changes.iter().count(), 1); // The sender is gone.
    drop(session);
    assert_eq!(status_of(params.get::<bool>("on")), Status::Closed);
}

#[test]
fn a_panic_in_a_watch_is_counted() {
    let session = session("params-panic");
    let params = session.params(&[]).unwrap();
    params.declare("speed", 1, &ParamInfo::default()).unwrap();
    let _watch = params.on_change("", |path, _| panic!("{path} frightens me")).unwrap();
    params.set("speed", 2).unwrap();
    assert_eq!(session.callback_failures(), 1);
    assert_eq!(params.get::<i64>("speed").unwrap(), 2);
}

#[test]
fn a_watch_may_make_a_change() {
    let session = session("params-nested");
    let params = std::sync::Arc::new(session.params(&[]).unwrap());
    params.declare("speed", 1, &ParamInfo::default()).unwrap();
    params.declare("twice", 2, &ParamInfo::default()).unwrap();
    let same = std::sync::Arc::clone(&params);
    let watch = params.on_change("speed", move |_, yaml| {
        let speed: i64 = yaml.unwrap().parse().unwrap();
        same.set("twice", 2 * speed).unwrap();
        if speed < 5 {
            same.set("speed", speed + 1).unwrap(); // Runs inside itself.
        }
    });
    params.set("speed", 3).unwrap();
    session.wait_idle(PATIENCE).unwrap();
    wait_until("the last change is made", || params.get::<i64>("twice").unwrap() == 10);
    drop(watch);
    assert_eq!(session.callback_failures(), 0);
}

#[test]
fn parameters_of_another_session_are_set() {
    let (robot, tool) = (named_session("params-of", "robot"), session("params-of"));
    let own = robot.params(&[]).unwrap();
    own.declare("speed", 1, &ParamInfo::default()).unwrap();
    let theirs = tool.params_of("robot", PATIENCE).unwrap();
    wait_until("the parameter can be set", || theirs.set("speed", 7).is_ok());
    assert_eq!(own.get::<i64>("speed").unwrap(), 7);
    assert_eq!(theirs.get::<i64>("speed").unwrap(), 7);
    assert_eq!(status_of(theirs.save()), Status::Failed);
}

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
