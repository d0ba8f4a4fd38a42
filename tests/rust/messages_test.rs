//! Typed and raw messages, their types, and their memory.

use crate::*;
use hgros::{Encoding, Message, PeerEvent, Schema, Type};
use hgros_messages::foxglove::{PointCloud, Pose, PoseInFrame};
use protobuf::well_known_types::Timestamp;
use std::sync::mpsc::channel;

include!(concat!(env!("OUT_DIR"), "/types.rs"));
use tests::r#type::{Robot, Robot_Arm, Wheel};

#[test]
fn messages_go_from_session_to_session_with_their_type() {
    let (from, to) = (session("typed"), session("typed"));
    let publisher = from.advertise("words", PublishOptions { latched: 1 }).unwrap();
    publisher.publish(&log_of("last")).unwrap();
    let queue = to.subscribe_raw("words", None, Queue::default()).unwrap();
    let message = queue.recv_timeout(PATIENCE).unwrap();
    let info = message.info();
    assert!(info.remote && info.publisher == from.id(), "{info:?}");
    assert!(info.publish_time.unwrap().elapsed().unwrap() < PATIENCE);
    assert_eq!(message.schema().type_name(), "foxglove.Log");
    assert_eq!(message.schema().fingerprint(), Schema::of::<Log>().unwrap().fingerprint());
    assert_eq!(message.decode::<Log>().unwrap().message, "last");
    assert_eq!(status_of(message.decode::<Pose>()), Status::TypeMismatch);
}

#[test]
fn generated_types_have_the_schemas_of_the_library() {
    for (made, known) in [
        (Schema::of::<Log>().unwrap(), Schema::known("foxglove.Log").unwrap()),
        (Schema::of::<PointCloud>().unwrap(), Schema::known("foxglove.PointCloud").unwrap()),
        (Schema::of::<PoseInFrame>().unwrap(), Schema::known("foxglove.PoseInFrame").unwrap()),
    ] {
        assert_eq!(made.type_name(), known.type_name());
        assert_eq!(made.fingerprint(), known.fingerprint());
        assert_eq!(made.encoding(), Encoding::Protobuf);
        assert!(made.fingerprint() != 0 && !made.descriptor_set().is_empty());
    }
    assert_eq!(status_of(Schema::known("no.Such")), Status::NotFound);
}

#[test]
fn types_of_my_own_are_generated_with_their_imports() {
    assert_eq!(Robot_Arm::NAME, "tests.type.Robot.Arm");
    assert!(Schema::of::<Robot_Arm>().unwrap().fingerprint() != 0);
    assert!(Wheel::DESCRIPTOR_SET.len() < Robot::DESCRIPTOR_SET.len());
    let session = session("own-types");
    let queue = session.subscribe::<Robot>("robots", Queue::default()).unwrap();
    let publisher = session.advertise("robots", PublishOptions::default()).unwrap();
    let mut robot = Robot::new();
    robot.set_built(Timestamp { seconds: 7, ..Timestamp::default() });
    robot.wheels.push(Wheel { radius: 0.25, ..Wheel::default() });
    robot.arms.insert("left".to_owned(), Robot_Arm { name: "l".to_owned(), ..Robot_Arm::default() });
    publisher.publish(&robot).unwrap();
    assert_eq!(queue.recv_timeout(PATIENCE).unwrap(), robot);
}

#[test]
fn raw_bytes_go_from_session_to_session() {
    let (from, to) = (session("raw"), session("raw"));
    let schema = Schema::raw("my.bytes", Encoding::Custom, 0).unwrap();
    let queue = to.subscribe_raw("bytes", Some(&schema), Queue::KeepAll(10)).unwrap();
    let publisher = from.advertise_raw("bytes", &schema, PublishOptions::default()).unwrap();
    from.wait_for_subscribers("bytes", 1, PATIENCE).unwrap();
    publisher.publish(b"abc").unwrap();
    publisher.publish_wait(&[], PATIENCE).unwrap();
    let first = queue.recv_timeout(PATIENCE).unwrap();
    assert_eq!((&first[..], first.schema().encoding()), (&b"abc"[..], Encoding::Custom));
    assert!(queue.recv_timeout(PATIENCE).unwrap().is_empty());
    assert_eq!(status_of(Schema::raw("zero\0byte", Encoding::Custom, 0)), Status::InvalidArgument);
}

#[test]
fn another_type_is_refused_here_and_counted_and_reported_of_another_session() {
    let (from, to) = (session("misfit"), session("misfit"));
    let (sender, reasons) = channel();
    let _watch = to
        .on_peer(move |change| {
            if change.event == PeerEvent::TypeMismatch {
                sender.send((change.channel, change.reason)).unwrap();
            }
        })
        .unwrap();
    let poses = to.subscribe::<Pose>("words", Queue::default()).unwrap();
    let error = to.advertise::<Log>("words", PublishOptions::default()).map(drop).unwrap_err();
    assert_eq!(error.status(), Status::TypeMismatch);
    assert!(error.sentence().contains("foxglove.Log") && error.sentence().contains("foxglove.Pose"), "{error}");
    let publisher = from.advertise("words", PublishOptions::default()).unwrap();
    wait_until("a message is counted", || {
        publisher.publish(&log_of("hello")).unwrap();
        // Those of another type leave the queue when it is read.
        poses.try_recv().unwrap().is_none() && poses.stats().unwrap().mismatched > 0
    });
    let (channel, reason) = reasons.recv_timeout(PATIENCE).unwrap();
    assert_eq!(channel, "words");
    assert!(reason.contains("foxglove.Log") && reason.contains("foxglove.Pose"), "{reason}");
}

#[test]
fn a_large_message_is_written_and_read_in_place() {
    const SIZE: usize = 4 << 20;
    let (from, to) = (session("large"), session("large"));
    let queue = to.subscribe::<PointCloud>("clouds", Queue::KeepAll(2)).unwrap();
    let publisher = from.advertise::<PointCloud>("clouds", PublishOptions::default()).unwrap();
    from.wait_for_subscribers("clouds", 1, PATIENCE).unwrap();
    let mut cloud = PointCloud::new();
    cloud.set_frame_id("lidar".to_owned());
    cloud.set_data((0..SIZE).map(|index| index as u8).collect());
    publisher.publish(&cloud).unwrap();
    let message = queue.take(PATIENCE).unwrap();
    assert_eq!(message.field_bytes(6).unwrap(), cloud.get_data());
    assert_eq!(message.field_bytes(2).unwrap(), b"lidar");
    assert_eq!(message.field_bytes(3).unwrap(), b"");
    assert_eq!(message.decode::<PointCloud>().unwrap(), cloud);
    publisher.publish(&cloud).unwrap();
    assert_eq!(queue.recv_timeout(PATIENCE).unwrap(), cloud);
}

#[test]
fn loans_are_filled_and_published_in_place() {
    let (from, to) = (session("loan"), session("loan"));
    let schema = Schema::raw("my.bytes", Encoding::Custom, 0).unwrap();
    let queue = to.subscribe_raw("bytes", None, Queue::KeepAll(1)).unwrap();
    let publisher = from.advertise_raw("bytes", &schema, PublishOptions::default()).unwrap();
    from.wait_for_subscribers("bytes", 1, PATIENCE).unwrap();
    let mut loan = publisher.loan(1 << 20).unwrap();
    loan.fill(7);
    loan.publish(PATIENCE).unwrap();
    let mut second = publisher.loan(3).unwrap();
    second.copy_from_slice(b"abc");
    let not_published = second.publish(BRIEFLY).unwrap_err();
    assert_eq!(not_published.error.status(), Status::TimedOut);
    assert_eq!(queue.recv_timeout(PATIENCE).unwrap().iter().filter(|&&byte| byte == 7).count(), 1 << 20);
    not_published.loan.publish(PATIENCE).unwrap();
    assert_eq!(&queue.recv_timeout(PATIENCE).unwrap()[..], b"abc");
    assert_eq!(publisher.loan(0).unwrap().len(), 0);
}

#[test]
fn a_message_that_cannot_be_read_is_an_error() {
    let session = session("unreadable");
    let queue = session.subscribe_raw("words", None, Queue::default()).unwrap();
    let schema = Schema::of::<Log>().unwrap();
    let publisher = session.advertise_raw("words", &schema, PublishOptions::default()).unwrap();
    publisher.publish(&[3 << 3 | 2, 100, b'x']).unwrap(); // 100 bytes, of which one is there.
    let message: Message = queue.recv_timeout(PATIENCE).unwrap();
    let error = message.decode::<Log>().unwrap_err();
    assert_eq!(error.status(), Status::NotWritable);
    assert!(error.sentence().contains("foxglove.Log"), "{error}");
    assert_eq!(status_of(message.field_bytes(3)), Status::NotWritable);
}

#[test]
fn fields_are_found_between_groups() {
    let session = session("groups");
    let queue = session.subscribe_raw("words", None, Queue::KeepAll(10)).unwrap();
    let schema = Schema::of::<Log>().unwrap();
    let publisher = session.advertise_raw("words", &schema, PublishOptions::default()).unwrap();
    let text = |text: &str| [&[3 << 3 | 2, text.len() as u8], text.as_bytes()].concat();
    let group = |inner: &[u8]| [&[7 << 3 | 3], inner, &[7 << 3 | 4]].concat();
    let received = |bytes: &[u8]| -> Message {
        publisher.publish(bytes).unwrap();
        queue.recv_timeout(PATIENCE).unwrap()
    };
    let numbers = [&[1 << 3, 5][..], &[2 << 3 | 5, 0, 0, 0, 0]].concat();
    let nested = group(&[text("inside"), group(&text("deep")), numbers].concat());
    let message = received(&[group(&[]), text("hello"), nested].concat());
    assert_eq!(message.field_bytes(3).unwrap(), b"hello");
    assert_eq!(message.field_bytes(7).unwrap(), b"");
    let flat = received(&[group(&text("inside")), text("hello")].concat());
    assert_eq!(flat.field_bytes(3).unwrap(), b"hello");
    assert_eq!(flat.decode::<Log>().unwrap().message, "hello");
    for broken in [
        &[7 << 3 | 3][..],               // Without an end.
        &[7 << 3 | 4],                   // Without a start.
        &[7 << 3 | 3, 6 << 3 | 4],       // The end of another one.
        &[7 << 3 | 3, 3 << 3 | 2, 9, 0], // Nine bytes, of which one is there.
        &[7 << 3 | 3; 1000],
    ] {
        assert_eq!(status_of(received(broken).field_bytes(3)), Status::NotWritable);
    }
}

#[test]
fn every_message_gives_its_lease_back_also_after_its_queue_and_its_session() {
    let session = session("lease-count");
    let (publisher, queue) = pair(&session, &session, "words", Queue::KeepAll(10));
    let before = hgros::leases();
    publisher.publish(&log_of("x")).unwrap();
    publisher.publish(&log_of("y")).unwrap();
    let first = queue.take(PATIENCE).unwrap();
    let copy = first.clone();
    assert_eq!(first.as_ptr(), copy.as_ptr());
    drop(queue.recv().unwrap());
    assert_eq!(hgros::leases(), before + 2);
    drop((first, queue, publisher, session));
    assert_eq!(hgros::leases(), before + 1);
    let text = std::thread::spawn(move || copy.decode::<Log>().unwrap().message).join().unwrap();
    assert_eq!((text.as_str(), hgros::leases()), ("x", before));
}
