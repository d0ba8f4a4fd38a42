//! Publishes five greetings as soon as somebody subscribes.

use hgros::{PublishOptions, Session};
use hgros_messages::foxglove::Log;
use std::time::Duration;

fn main() -> Result<(), hgros::Error> {
    let minute = Duration::from_secs(60);
    let session = Session::open("")?;
    let publisher = session.advertise("greetings", PublishOptions { latched: 5 })?;
    session.wait_for_subscribers("greetings", 1, minute)?; // One that leaves at once could be missed later.
    for number in 1..=5 {
        let mut log = Log::new();
        log.set_message(format!("Hello {number}"));
        publisher.publish_wait(&log, minute)?;
    }
    println!("published");
    Ok(())
}
