//! Publishes five greetings, which nobody has to wait for: the channel keeps the newest ones for late subscribers.

use hgros::{PublishOptions, Session};
use hgros_messages::foxglove::Log;
use std::time::Duration;

fn main() -> Result<(), hgros::Error> {
    let minute = Duration::from_secs(60);
    let session = Session::open("")?;
    let publisher = session.advertise("greetings", PublishOptions { latched: 5 })?;
    for number in 1..=5 {
        let mut log = Log::new();
        log.set_message(format!("Hello {number}"));
        publisher.publish_wait(&log, minute)?;
    }
    session.wait_for_subscribers("greetings", 1, minute)?;
    println!("published");
    Ok(())
}
