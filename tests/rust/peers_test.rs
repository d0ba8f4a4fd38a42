//! Other processes: the command `hgros`, which is C++, and the peer of Rust in tests/interop. Their paths are in the
//! environment.

use crate::*;
use hgros::ServeOptions;
use std::io::{BufRead, BufReader, Read};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

/// A process of the test, which is killed if the test fails.
struct Process {
    child: Child,
    input: Option<ChildStdin>,
    output: BufReader<ChildStdout>,
    name: String,
}

impl Process {
    fn start(program: &str, domain: &str, arguments: &[&str]) -> Self {
        let path = std::env::var_os(program).unwrap_or_else(|| panic!("{program} is not set"));
        let mut child = Command::new(path)
            .args(arguments)
            .env("HGROS_DOMAIN", domain)
            .env("HGROS_INTEROP_YAML", "")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let (input, output) = (child.stdin.take(), BufReader::new(child.stdout.take().unwrap()));
        Self { child, input, output, name: arguments.join(" ") }
    }

    #[track_caller]
    fn expect(&mut self, wanted: &str) {
        let mut line = String::new();
        self.output.read_line(&mut line).unwrap();
        assert_eq!(line.trim_end(), wanted, "of {}", self.name);
    }

    /// Closes its input, and returns what it still says.
    #[track_caller]
    fn finish(mut self) -> String {
        drop(self.input.take());
        let mut rest = String::new();
        self.output.read_to_string(&mut rest).unwrap();
        let status = self.child.wait().unwrap();
        assert!(status.success(), "{} ended with {status}", self.name);
        rest.trim_end().to_owned()
    }

    fn kill(mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        // Most have ended before.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn peer(test: &str, arguments: &[&str]) -> Process {
    Process::start("HGROS_TEST_PEER", &domain(test), arguments)
}

fn command(test: &str, arguments: &[&str]) -> Process {
    Process::start("HGROS_TEST_COMMAND", &domain(test), arguments)
}

#[test]
fn a_peer_publishes_to_another_one() {
    for (sends, size) in [("publish", "1000"), ("bulk-publish", "4194304")] {
        let receives = sends.replace("publish", "subscribe");
        let mut subscriber = peer("publish", &[&receives, sends, size]);
        subscriber.expect("subscribed");
        let mut publisher = peer("publish", &[sends, sends, size]);
        publisher.expect(&format!("published {size}"));
        subscriber.expect(&format!("received {size}"));
        assert_eq!(subscriber.finish() + &publisher.finish(), "");
    }
}

#[test]
fn a_late_peer_gets_what_is_latched() {
    let mut publisher = peer("latch", &["latch", "words", "good morning"]);
    publisher.expect("latched");
    assert_eq!(peer("latch", &["late", "words"]).finish(), "late good morning");
    publisher.finish();
}

#[test]
fn a_peer_calls_another_one() {
    let mut server = peer("serve", &["serve", "reply"]);
    server.expect("serving");
    assert_eq!(peer("serve", &["call", "reply", "hello"]).finish(), "answer re: hello");
    assert_eq!(peer("serve", &["call", "reply", "fail"]).finish(), "failed asked to fail");
    server.finish();
}

#[test]
fn a_peer_with_another_type_hears_nothing() {
    let mut misfit = peer("misfit", &["misfit", "words"]);
    misfit.expect("subscribed");
    let mut publisher = peer("misfit", &["latch", "words", "hello"]);
    publisher.expect("latched");
    assert_eq!(misfit.finish() + &publisher.finish(), "");
}

#[test]
fn a_peer_survives_the_death_of_the_other_one() {
    let mut stream = peer("survive", &["stream", "words"]);
    let mut first = peer("survive", &["follow", "words"]);
    first.expect("following");
    stream.expect("streaming");
    first.kill();
    let mut second = peer("survive", &["follow", "words"]);
    second.expect("following");
    stream.kill();
    let mut other = peer("survive", &["stream", "words"]);
    other.expect("streaming");
    let followed = second.finish();
    assert!(followed.starts_with("followed "), "{followed}");
    assert!(other.finish().starts_with("streamed "));
}

#[test]
fn the_command_shows_what_is_published() {
    let from = Session::open(&configuration("echo")).unwrap();
    let publisher = from.advertise("words", PublishOptions { latched: 1 }).unwrap();
    publisher.publish(&log_of("from Rust")).unwrap();
    let said = command("echo", &["echo", "words", "--once", "--json", "--timeout", "40"]).finish();
    assert!(said.contains("\"from Rust\""), "{said}");
}

#[test]
fn the_command_publishes() {
    let to = Session::open(&configuration("pub")).unwrap();
    let queue = to.subscribe::<Log>("words", Queue::default()).unwrap();
    let message = "{message: from C++}";
    command("pub", &["pub", "words", message, "--type", "foxglove.Log", "--timeout", "40"]).finish();
    assert_eq!(queue.recv_timeout(PATIENCE).unwrap().message, "from C++");
}

#[test]
fn the_command_calls() {
    let server = Session::open(&configuration("call")).unwrap();
    let greet = |request: Log| Ok::<_, String>(log_of(format!("hello {}", request.message)));
    let _service = server.serve("greet", ServeOptions::default(), greet).unwrap();
    let said = command("call", &["call", "greet", "{message: C++}", "--timeout", "40"]).finish();
    assert!(said.contains("hello C++"), "{said}");
}
