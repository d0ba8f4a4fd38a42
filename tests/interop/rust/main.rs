//! The peer of Rust: one role in a conversation between languages. Each line on standard output says how far it is.

use hgros::{Error, PublishOptions, Publisher, Queue, ServeOptions, Session, Status, Subscription};
use hgros_messages::foxglove::{Log, PointCloud, PoseInFrame};
use std::cell::RefCell;
use std::io::{Read, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

const PATIENCE: Duration = Duration::from_secs(30);
const ROOM: Queue = Queue::KeepAll(100);
const DATA_FIELD: u32 = 6; // foxglove.PointCloud.data

type Failure = Box<dyn std::error::Error>;

fn main() {
    if let Err(failure) = run() {
        eprintln!("{failure}");
        std::process::exit(1);
    }
}

fn run() -> Result<(), Failure> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let session = Session::open(&std::env::var("HGROS_INTEROP_YAML").unwrap_or_default())?;
    match arguments[..] {
        ["publish", channel, count] => publish(&session, channel, count.parse()?),
        ["subscribe", channel, count] => subscribe(&session, channel, count.parse()?),
        ["latch", channel, text] => latch(&session, channel, text),
        ["bulk-publish", channel, bytes] => bulk_publish(&session, channel, bytes.parse()?),
        ["bulk-subscribe", channel, bytes] => bulk_subscribe(&session, channel, bytes.parse()?),
        ["serve", name] => serve(&session, name),
        ["call", name, text] => call(&session, name, text),
        ["misfit", channel] => misfit(&session, channel),
        _ => Err("usage: peer ROLE [ARGUMENT...]".into()),
    }
}

fn say(line: &str) {
    let mut output = std::io::stdout();
    // Perhaps nobody reads any more.
    let _ = writeln!(output, "{line}").and_then(|()| output.flush());
}

fn wait_for_end_of_input() {
    // An error is an end, too.
    let _ = std::io::stdin().read_to_end(&mut Vec::new());
}

fn log_of(text: &str) -> Log {
    let mut log = Log::new();
    log.set_message(text.to_owned());
    log
}

/// Takes steps, `most` or until standard input is closed: then the session ends, which wakes what waits. Says how many.
fn repeat(
    session: &Session,
    most: u64,
    mut step: impl FnMut(u64) -> hgros::Result<()>,
    last: impl FnOnce(u64) -> String,
) {
    let over = AtomicBool::new(false);
    std::thread::scope(|scope| {
        scope.spawn(|| {
            wait_for_end_of_input();
            over.store(true, Ordering::Release);
            session.end();
        });
        let mut count = 0;
        while count < most {
            match step(count + 1) {
                Ok(()) => count += 1,
                Err(error) if error.status() == Status::Closed && over.load(Ordering::Acquire) => break,
                Err(error) => fail(&error.to_string()),
            }
        }
        say(&last(count));
    });
}

/// Also while another thread waits for the input.
fn fail(sentence: &str) -> ! {
    eprintln!("{sentence}");
    std::process::exit(1);
}

fn publish(session: &Session, channel: &str, count: u64) -> Result<(), Failure> {
    let publisher: Publisher<Log> = session.advertise(channel, PublishOptions::default())?;
    session.wait_for_subscribers(channel, 1, PATIENCE)?;
    let step = |number: u64| {
        publisher.publish_wait(&log_of(&number.to_string()), Duration::MAX)?;
        if number == 1 {
            say("publishing");
        }
        Ok(())
    };
    repeat(session, count, step, |sent| format!("published {sent}"));
    Ok(())
}

fn subscribe(session: &Session, channel: &str, count: u64) -> Result<(), Failure> {
    let queue: Subscription<Log> = session.subscribe(channel, ROOM)?;
    let (mut from_one, last) = (false, RefCell::new(String::new()));
    let step = |number: u64| {
        let text = queue.recv()?.message;
        from_one = if number == 1 { text == "1" } else { from_one };
        if from_one && text != number.to_string() {
            fail(&format!("The message is {text:?} instead of {number}."));
        }
        if number == 1 {
            say(&format!("receiving {text}"));
        }
        last.replace(text);
        Ok(())
    };
    repeat(session, count, step, |received| format!("received {received} {}", last.borrow()));
    Ok(())
}

fn latch(session: &Session, channel: &str, text: &str) -> Result<(), Failure> {
    let publisher = session.advertise(channel, PublishOptions { latched: 2 })?;
    for one in ["old", text, "new"] {
        publisher.publish(&log_of(one))?;
    }
    say("latched");
    wait_for_end_of_input();
    Ok(())
}

fn bulk_bytes(size: usize) -> impl Iterator<Item = u8> {
    (0..size).map(|index| (index.wrapping_mul(7).wrapping_add(3) & 255) as u8)
}

fn bulk_publish(session: &Session, channel: &str, size: usize) -> Result<(), Failure> {
    let publisher = session.advertise(channel, PublishOptions::default())?;
    session.wait_for_subscribers(channel, 1, PATIENCE)?;
    let mut cloud = PointCloud::new();
    cloud.set_point_stride(1);
    cloud.set_data(bulk_bytes(size).collect());
    publisher.publish_wait(&cloud, PATIENCE)?; // Encoded where the subscriber reads it.
    say(&format!("published {size}"));
    wait_for_end_of_input();
    Ok(())
}

fn bulk_subscribe(session: &Session, channel: &str, size: usize) -> Result<(), Failure> {
    let queue: Subscription<PointCloud> = session.subscribe(channel, ROOM)?;
    say("subscribed");
    let message = queue.take(PATIENCE)?;
    let data = message.field_bytes(DATA_FIELD)?; // Where the publisher wrote them.
    if !data.iter().copied().eq(bulk_bytes(size)) {
        return Err(format!("{} bytes came instead of {size}, or other ones.", data.len()).into());
    }
    say(&format!("received {size}"));
    Ok(())
}

fn serve(session: &Session, name: &str) -> Result<(), Failure> {
    let _service = session.serve(name, ServeOptions::default(), |request: Log| match request.get_message() {
        "fail" => Err("asked to fail"),
        text => Ok(log_of(&format!("re: {text}"))),
    })?;
    say("serving");
    wait_for_end_of_input();
    Ok(())
}

fn call(session: &Session, name: &str, text: &str) -> Result<(), Failure> {
    let deadline = Instant::now() + PATIENCE;
    loop {
        let reply: Result<Log, Error> = session.call(name, &log_of(text), PATIENCE);
        match reply {
            Ok(log) => say(&format!("answer {}", log.message)),
            // Nothing else tells when a service comes.
            Err(error) if error.status() == Status::NoServer && Instant::now() < deadline => {
                std::thread::sleep(Duration::from_millis(10));
                continue;
            }
            Err(error) => say(&format!("failed {error}")),
        }
        return Ok(());
    }
}

fn misfit(session: &Session, channel: &str) -> Result<(), Failure> {
    let _queue: Subscription<PoseInFrame> = session.subscribe(channel, ROOM)?;
    say("subscribed");
    wait_for_end_of_input();
    Ok(())
}
