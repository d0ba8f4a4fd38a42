//! Sessions: errors, the log, peers, and use after the end.

use crate::*;
use hgros::{Level, PeerEvent, ServeOptions};
use std::sync::mpsc::channel;

fn is_send_and_sync<T: Send + Sync>() {}

#[test]
fn handles_may_be_sent_and_shared() {
    is_send_and_sync::<Session>();
    is_send_and_sync::<Publisher<Log>>();
    is_send_and_sync::<Subscription<Log>>();
    is_send_and_sync::<hgros::Message>();
    is_send_and_sync::<hgros::Loan>();
    is_send_and_sync::<hgros::Schema>();
    is_send_and_sync::<hgros::Listener>();
    is_send_and_sync::<hgros::Service>();
    is_send_and_sync::<hgros::Params>();
    is_send_and_sync::<hgros::Transforms>();
    is_send_and_sync::<hgros::Watch>();
    is_send_and_sync::<Error>();
}

#[test]
fn errors_have_a_status_and_a_sentence() {
    let error = Session::open("sesion: {}").map(drop).unwrap_err();
    assert_eq!(error.status(), Status::ConfigError);
    assert!(error.to_string().contains("sesion"), "{error}");
    let error = Session::builder().open_files(&["/no/such.yaml"]).map(drop).unwrap_err();
    assert_eq!(error.status(), Status::ConfigError);
    assert!(error.sentence().contains("/no/such.yaml"), "{error}");
    let error = Session::open("a\0b").map(drop).unwrap_err();
    assert_eq!(error.status(), Status::InvalidArgument);
    let session = session("errors");
    let error = session.subscribe::<Log>("", Queue::default()).map(drop).unwrap_err();
    assert_eq!(error.status(), Status::Failed);
    assert!(!error.sentence().is_empty());
    assert!(!hgros::version().is_empty());
}

#[test]
fn a_session_is_opened_with_files() {
    let file = std::env::temp_dir().join(format!("{}.yaml", domain("files")));
    std::fs::write(&file, configuration("files")).unwrap();
    let session = Session::builder().name("reader").open_files(&[file.to_str().unwrap()]);
    std::fs::remove_file(file).unwrap();
    assert_eq!(session.unwrap().name(), "reader");
}

#[test]
fn the_log_comes_to_the_program() {
    let (sender, lines) = channel();
    let session = Session::builder()
        .log(move |level, line| sender.send((level, line.to_owned())).unwrap())
        .open(&configuration("log"))
        .unwrap();
    session.log(Level::Warning, "It rains.").unwrap();
    session.set_log_level(Level::Error).unwrap();
    session.log(Level::Warning, "It still rains.").unwrap();
    session.log(Level::Error, "It floods.").unwrap();
    assert_eq!(lines.recv_timeout(PATIENCE).unwrap(), (Level::Warning, "It rains.".to_owned()));
    assert_eq!(lines.recv_timeout(PATIENCE).unwrap(), (Level::Error, "It floods.".to_owned()));
    drop(session);
    assert!(lines.recv_timeout(PATIENCE).is_err()); // The closure is destroyed with the session.
}

#[test]
fn peers_and_channels_are_seen() {
    let here = session("peers");
    let (sender, changes) = channel();
    let _watch = here.on_peer(move |change| sender.send(change).unwrap()).unwrap();
    let there = session("peers");
    let (_publisher, _queue) = pair(&there, &here, "words", Queue::default());
    let came = changes.recv_timeout(PATIENCE).unwrap();
    assert_eq!((came.event, came.peer.id), (PeerEvent::Came, there.id()));
    assert_eq!(came.peer.pid, i64::from(std::process::id()));
    let peers = here.peers().unwrap();
    assert_eq!(peers.iter().map(|peer| peer.id).collect::<Vec<_>>(), [there.id()]);
    wait_until("the channel is known", || {
        let channels = here.channels().unwrap();
        let words = channels.iter().find(|channel| channel.name == "words");
        words.map_or(false, |words| words.publishers == 1 && words.type_name == "foxglove.Log")
    });
    here.wait_for_publishers("words", 1, PATIENCE).unwrap();
    assert_eq!(status_of(here.wait_for_publishers("words", 2, BRIEFLY)), Status::TimedOut);
    drop(there);
    assert_eq!(changes.recv_timeout(PATIENCE).unwrap().event, PeerEvent::Gone);
}

#[test]
fn what_outlives_its_session_says_that_it_is_closed() {
    let session = session("closed");
    let (publisher, queue) = pair(&session, &session, "words", Queue::default());
    let listener = session.on("words", Queue::default(), |_: Log| {}).unwrap();
    let service = session.serve("same", ServeOptions::default(), Ok::<Log, String>).unwrap();
    let (params, transforms) = (session.params(&[]).unwrap(), session.transforms().unwrap());
    let loan = publisher.loan(10).unwrap();
    session.end();
    assert_eq!(status_of(session.subscribe::<Log>("more", Queue::default()).map(drop)), Status::Closed);
    assert_eq!(status_of(session.call::<Log, Log>("same", &log_of(1), PATIENCE)), Status::Closed);
    drop(session);
    assert_eq!(status_of(publisher.publish(&log_of(1))), Status::Closed);
    assert_eq!(status_of(publisher.loan(10).map(drop)), Status::Closed);
    assert_eq!(loan.publish(PATIENCE).unwrap_err().error.status(), Status::Closed);
    assert_eq!(status_of(queue.recv()), Status::Closed);
    assert_eq!(status_of(params.yaml("")), Status::Closed);
    assert_eq!(status_of(transforms.lookup("a", "b")), Status::Closed);
    drop((listener, service));
}
