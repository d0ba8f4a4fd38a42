//! Who is there: peers and channels.

use crate::callback::{lock, Callback};
use crate::convert::string_from;
use crate::error::{check, Result};
use crate::schema::Encoding;
use crate::session::Session;
use hgros_sys as sys;
use std::os::raw::{c_char, c_void};
use std::ptr::{null_mut, NonNull};
use std::sync::Mutex;

/// Another session.
#[derive(Clone, Debug, Eq, PartialEq)]
pub struct Peer {
    /// Its session id.
    pub id: u64,
    /// Its program's name.
    pub process: String,
    /// Its host's name. Only shown, never compared.
    pub host: String,
    pub pid: i64,
    /// Of its messages: "shared memory" or "ZeroMQ".
    pub transport: String,
    /// Why that transport was chosen.
    pub why: String,
}

/// A channel that some session uses.
#[derive(Clone, Debug, Eq, PartialEq)]
pub struct Channel {
    /// Channels of the library itself begin with "hgros/".
    pub name: String,
    /// Empty: unknown.
    pub type_name: String,
    /// 0: unknown.
    pub fingerprint: u64,
    pub encoding: Encoding,
    pub publishers: usize,
    pub subscribers: usize,
}

/// What has happened to a session.
#[derive(Clone, Copy, Debug, Eq, Hash, PartialEq)]
#[non_exhaustive]
pub enum PeerEvent {
    Came,
    Gone,
    /// It uses a channel with another type.
    TypeMismatch,
    /// It serves a name that is served.
    ServedTwice,
    /// An event of a later version of the library.
    Other(i32),
}

/// An event of a session.
#[derive(Clone, Debug)]
pub struct PeerChange {
    pub event: PeerEvent,
    pub peer: Peer,
    /// Empty if it came or has gone.
    pub channel: String,
    /// A sentence; empty if it came.
    pub reason: String,
}

/// Something that is watched until this is dropped. Outside callbacks that waits for the running call.
#[must_use = "the watch ends when this is dropped"]
pub struct Watch(NonNull<sys::hgros_watch>);

// SAFETY: any thread may close a watch; its only owner does.
unsafe impl Send for Watch {}
// SAFETY: a shared borrow can do nothing.
unsafe impl Sync for Watch {}

impl Watch {
    /// Takes the watch that the library has just made.
    pub(crate) fn from(handle: *mut sys::hgros_watch) -> Self {
        Self(NonNull::new(handle).expect("a watch was made"))
    }
}

impl Drop for Watch {
    fn drop(&mut self) {
        // SAFETY: the handle is this object's own.
        unsafe { sys::hgros_watch_close(self.0.as_ptr()) };
    }
}

impl Session {
    /// The sessions that are connected with this one, at one moment.
    pub fn peers(&self) -> Result<Vec<Peer>> {
        let mut list = null_mut();
        // SAFETY: the list is freed below, and its texts are copied before.
        unsafe {
            check(sys::hgros_peers_open(self.as_ptr(), &mut list))?;
            let peers = (0..sys::hgros_peers_count(list)).map(|index| {
                let mut peer = sys::hgros_peer::default();
                check(sys::hgros_peers_get(list, index, &mut peer)).map(|()| peer_from(&peer))
            });
            let peers = peers.collect();
            sys::hgros_peers_free(list);
            peers
        }
    }

    /// The channels of all sessions that are known, including the own, sorted by name, at one moment.
    pub fn channels(&self) -> Result<Vec<Channel>> {
        let mut list = null_mut();
        // SAFETY: the list is freed below, and its texts are copied before.
        unsafe {
            check(sys::hgros_channels_open(self.as_ptr(), &mut list))?;
            let channels = (0..sys::hgros_channels_count(list)).map(|index| {
                let mut channel = sys::hgros_channel::default();
                check(sys::hgros_channels_get(list, index, &mut channel)).map(|()| Channel {
                    name: string_from(channel.name),
                    type_name: string_from(channel.type_name),
                    fingerprint: channel.fingerprint,
                    encoding: Encoding::from(channel.encoding),
                    publishers: channel.publishers,
                    subscribers: channel.subscribers,
                })
            });
            let channels = channels.collect();
            sys::hgros_channels_free(list);
            channels
        }
    }

    /// Calls a function when a session comes or goes, uses a channel with another type, or serves a name that is
    /// served; one call at a time. Watch first, then call [`Session::peers`] for those that came earlier.
    pub fn on_peer(&self, happened: impl FnMut(PeerChange) + Send + 'static) -> Result<Watch> {
        self.watch_peers(happened)
    }

    fn watch_peers<F: FnMut(PeerChange) + Send + 'static>(&self, happened: F) -> Result<Watch> {
        let what = "The callback of peers".to_owned();
        let user = Callback::new(&self.reports, what, Mutex::new(happened)).into_user();
        let mut watch = null_mut();
        // SAFETY: the arguments are valid during the call, and the library keeps `user` until it calls `release`.
        check(unsafe {
            let release = Some(Callback::<Mutex<F>>::release as _);
            sys::hgros_watch_peers(self.as_ptr(), Some(tell::<F>), user, release, &mut watch)
        })?;
        Ok(Watch::from(watch))
    }
}

unsafe extern "C" fn tell<F: FnMut(PeerChange) + Send + 'static>(
    user: *mut c_void,
    event: i32,
    peer: *const sys::hgros_peer,
    channel: *const c_char,
    reason: *const c_char,
) {
    // SAFETY: what the library got in watch_peers(), and a peer and texts that are valid until this returns.
    let callback = Callback::<Mutex<F>>::from(user);
    let change = PeerChange {
        event: match event {
            sys::HGROS_PEER_CAME => PeerEvent::Came,
            sys::HGROS_PEER_GONE => PeerEvent::Gone,
            sys::HGROS_PEER_TYPE_MISMATCH => PeerEvent::TypeMismatch,
            sys::HGROS_PEER_SERVED_TWICE => PeerEvent::ServedTwice,
            other => PeerEvent::Other(other),
        },
        peer: peer_from(&*peer),
        channel: string_from(channel),
        reason: string_from(reason),
    };
    // A panic is reported.
    let _ = callback.run(|happened| lock(happened)(change));
}

/// # Safety
/// The texts of `peer` are valid.
unsafe fn peer_from(peer: &sys::hgros_peer) -> Peer {
    Peer {
        id: peer.id,
        process: string_from(peer.process),
        host: string_from(peer.host),
        pid: peer.pid,
        transport: string_from(peer.transport),
        why: string_from(peer.why),
    }
}
