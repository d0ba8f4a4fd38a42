//! Serves the length of a vector, and calls it twice: once with a vector that has none.

use hgros::{ServeOptions, Session, Status};
use hgros_messages::foxglove::{Vector2, Vector3};
use std::time::Duration;

fn length(vector: Vector3) -> Result<Vector2, String> {
    let length = (vector.x.powi(2) + vector.y.powi(2) + vector.z.powi(2)).sqrt();
    if !length.is_finite() {
        return Err("a vector without an end has no length".to_owned());
    }
    let mut reply = Vector2::new();
    reply.set_x(length);
    Ok(reply)
}

fn main() -> Result<(), hgros::Error> {
    let session = Session::open("")?;
    let _service = session.serve("length", ServeOptions::default(), length)?;
    for z in [12.0, f64::INFINITY] {
        let mut vector = Vector3::new();
        vector.set_x(3.0);
        vector.set_y(4.0);
        vector.set_z(z);
        let reply: Result<Vector2, _> = session.call("length", &vector, Duration::from_secs(60));
        match reply {
            Ok(reply) => println!("The length is {}", reply.x),
            Err(error) if error.status() == Status::HandlerFailed => println!("{error}"),
            Err(error) => return Err(error),
        }
    }
    Ok(())
}
