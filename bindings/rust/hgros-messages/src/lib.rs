//! The messages that come with HyperGraph ROS: the packages `foxglove` and `hgros`.

include!(concat!(env!("OUT_DIR"), "/types.rs"));
