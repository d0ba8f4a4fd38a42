//! Shows the type and size of messages of any type, and the text of a foxglove.Log: subscriber CHANNEL [COUNT].

use hgros::{Queue, Session};
use hgros_messages::foxglove::Log;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let channel = arguments
        .next()
        .ok_or("usage: subscriber CHANNEL [COUNT]")?;
    let count = arguments
        .next()
        .map_or(Ok(usize::MAX), |count| count.parse())?;
    let session = Session::open("")?;
    let queue = session.subscribe_raw(&channel, None, Queue::KeepAll(100))?;
    for message in queue.iter().take(count) {
        let message = message?;
        match message.decode::<Log>() {
            Ok(log) => println!("foxglove.Log: {}", log.message),
            Err(_) => println!("{}: {} bytes", message.schema().type_name(), message.len()),
        }
    }
    Ok(())
}
