//! Services, in both roles.

use crate::*;
use hgros::ServeOptions;
use hgros_messages::foxglove::Pose;
use std::sync::mpsc::channel;
use std::sync::Mutex;

/// Serves "shout": capital letters.
fn shout(request: Log) -> Result<Log, String> {
    match request.get_message() {
        "fail" => Err("I have no voice".to_owned()),
        "panic" => panic!("a mouse"),
        text => Ok(log_of(text.to_uppercase())),
    }
}

fn call(client: &Session, text: &str) -> Result<Log, Error> {
    client.call("shout", &log_of(text), PATIENCE)
}

fn wait_for_service(client: &Session) {
    wait_until(
        "the service is known",
        || !matches!(call(client, "hello"), Err(error) if error.status() == Status::NoServer),
    );
}

#[test]
fn services_reply_and_fail() {
    let (server, client) = (session("service"), session("service"));
    let service = server.serve("shout", ServeOptions::default(), shout).unwrap();
    wait_for_service(&client);
    assert_eq!(call(&client, "hello").unwrap().message, "HELLO");
    let error = call(&client, "fail").unwrap_err();
    assert_eq!((error.status(), error.sentence()), (Status::HandlerFailed, "I have no voice"));
    assert_eq!(call(&server, "hello").unwrap().message, "HELLO");
    let refused = client.call::<_, Pose>("shout", &log_of("x"), PATIENCE);
    assert_eq!(status_of(refused), Status::TypeMismatch);
    drop(service);
    assert_eq!(status_of(call(&server, "hello")), Status::NoServer);
}

#[test]
fn a_panic_of_a_handler_reaches_the_caller() {
    let (server, client) = (session("service-panic"), session("service-panic"));
    let _service = server.serve("shout", ServeOptions::default(), shout).unwrap();
    wait_for_service(&client);
    let error = call(&client, "panic").unwrap_err();
    assert_eq!(error.status(), Status::HandlerFailed);
    assert!(error.sentence().contains("a mouse"), "{error}");
    assert_eq!(server.callback_failures(), 1);
    assert_eq!(call(&client, "again").unwrap().message, "AGAIN");
}

#[test]
fn a_call_ends_with_its_time_or_its_session() {
    let (server, client) = (session("service-wait"), session("service-wait"));
    let (entered, enters) = channel();
    let (go_on, waits) = channel::<()>();
    let (entered, waits) = (Mutex::new(entered), Mutex::new(waits));
    let _service = server.serve("wait", ServeOptions::default(), move |request: Log| {
        entered.lock().unwrap().send(()).unwrap();
        waits.lock().unwrap().recv().map(|()| request)
    });
    wait_until("the call times out", || {
        let reply = client.call::<_, Log>("wait", &log_of("x"), Duration::from_millis(200));
        status_of(reply) == Status::TimedOut
    });
    enters.recv_timeout(PATIENCE).unwrap();
    std::thread::scope(|scope| {
        go_on.send(()).unwrap(); // For the call that timed out.
        let waiting = scope.spawn(|| client.call::<_, Log>("wait", &log_of("y"), Duration::MAX));
        enters.recv_timeout(PATIENCE).unwrap();
        client.end();
        assert_eq!(status_of(waiting.join().unwrap()), Status::Closed);
        go_on.send(()).unwrap();
    });
}

#[test]
fn a_handler_may_call_services_of_its_own_session() {
    let session = std::sync::Arc::new(session("service-nested"));
    let _inner = session.serve("shout", ServeOptions::default(), shout).unwrap();
    let same = std::sync::Arc::downgrade(&session);
    let options = ServeOptions { concurrent: true, most_waiting: 4 };
    let _outer = session.serve("twice", options, move |request: Log| -> Result<Log, Error> {
        let session = same.upgrade().expect("it is called by its session");
        let once = call(&session, request.get_message())?;
        call(&session, &format!("{0} {0}", once.message))
    });
    let reply: Log = session.call("twice", &log_of("hey"), PATIENCE).unwrap();
    assert_eq!(reply.message, "HEY HEY");
}
