package hgros

// #include <stdlib.h>
// #include "bridge.h"
import "C"

import "runtime/cgo"

// Peer is another session.
type Peer struct {
	ID        uint64
	Process   string // Its program's name.
	Host      string // Only shown, never compared.
	PID       int64
	Transport string // Of its messages: "shared memory" or "ZeroMQ".
	Why       string // Why that transport was chosen.
}

func peerFrom(peer *C.hgros_peer) Peer {
	return Peer{uint64(peer.id), C.GoString(peer.process), C.GoString(peer.host), int64(peer.pid),
		C.GoString(peer.transport), C.GoString(peer.why)}
}

// Peers are the sessions that are connected with this one, at one moment.
func (s *Session) Peers() ([]Peer, error) {
	var list *C.hgros_peers
	if err := s.do("session", func() C.hgros_status { return C.hgros_peers_open(s.handle, &list) }); err != nil {
		return nil, err
	}
	defer C.hgros_peers_free(list)
	peers := make([]Peer, 0, int(C.hgros_peers_count(list)))
	for i := 0; i < cap(peers); i++ {
		peer := C.hgros_peer{size: C.sizeof_hgros_peer}
		if err := check(func() C.hgros_status { return C.hgros_peers_get(list, C.size_t(i), &peer) }); err != nil {
			return nil, err
		}
		peers = append(peers, peerFrom(&peer))
	}
	return peers, nil
}

// Channel is a channel that some session uses.
type Channel struct {
	Name         string // Channels of the library itself begin with "hgros/".
	TypeName     string // Empty: unknown.
	Fingerprint  uint64 // 0: unknown.
	Encoding     Encoding
	Publishers   int
	Subscribers  int
	PublishedBy  []ChannelUser
	SubscribedBy []ChannelUser
}

// ChannelUser is a session that publishes a channel or subscribes to it.
type ChannelUser struct {
	Session  uint64 // Its id.
	Process  string
	Host     string
	PID      int64
	TypeName string // The type it uses the channel with; empty: any type.
	Lossless bool   // For a subscriber: nothing may be dropped.
}

// Channels are those of all sessions that are known, including the own, sorted by name, at one moment.
func (s *Session) Channels() ([]Channel, error) {
	var list *C.hgros_channels
	if err := s.do("session", func() C.hgros_status { return C.hgros_channels_open(s.handle, &list) }); err != nil {
		return nil, err
	}
	defer C.hgros_channels_free(list)
	channels := make([]Channel, 0, int(C.hgros_channels_count(list)))
	for i := 0; i < cap(channels); i++ {
		entry := C.hgros_channel{size: C.sizeof_hgros_channel}
		if err := check(func() C.hgros_status {
			return C.hgros_channels_get(list, C.size_t(i), &entry)
		}); err != nil {
			return nil, err
		}
		publishers, err := usersOf(list, i, C.HGROS_ROLE_PUBLISHER, int(entry.publishers))
		if err != nil {
			return nil, err
		}
		subscribers, err := usersOf(list, i, C.HGROS_ROLE_SUBSCRIBER, int(entry.subscribers))
		if err != nil {
			return nil, err
		}
		channels = append(channels, Channel{C.GoString(entry.name), C.GoString(entry.type_name),
			uint64(entry.fingerprint), Encoding(entry.encoding), len(publishers), len(subscribers), publishers,
			subscribers})
	}
	return channels, nil
}

func usersOf(list *C.hgros_channels, channel int, role C.int32_t, count int) ([]ChannelUser, error) {
	users := make([]ChannelUser, 0, count)
	for i := 0; i < count; i++ {
		user := C.hgros_channel_user{size: C.sizeof_hgros_channel_user}
		if err := check(func() C.hgros_status {
			return C.hgros_channels_get_user(list, C.size_t(channel), role, C.size_t(i), &user)
		}); err != nil {
			return nil, err
		}
		users = append(users, ChannelUser{uint64(user.session), C.GoString(user.process), C.GoString(user.host),
			int64(user.pid), C.GoString(user.type_name), user.lossless != 0})
	}
	return users, nil
}

// Snapshot is all counters of the session at one moment: a message hgros.Snapshot, which Decode reads. Close it.
func (s *Session) Snapshot() (*Message, error) {
	var handle *C.hgros_message
	if err := s.do("session", func() C.hgros_status { return C.hgros_session_snapshot(s.handle, &handle) }); err != nil {
		return nil, err
	}
	return newMessage(handle), nil
}

// PeerEvent is what has happened to a session.
type PeerEvent int32

// The events of peers.
const (
	PeerCame         PeerEvent = C.HGROS_PEER_CAME
	PeerGone         PeerEvent = C.HGROS_PEER_GONE
	PeerTypeMismatch PeerEvent = C.HGROS_PEER_TYPE_MISMATCH
	PeerServedTwice  PeerEvent = C.HGROS_PEER_SERVED_TWICE
)

// OnPeer calls a function when a session comes or goes, uses a channel with another type, or serves a name that is
// served; one call at a time. The channel is empty for the first two; the reason is a sentence.
func (s *Session) OnPeer(happened func(event PeerEvent, peer Peer, channel, reason string)) (*Watch, error) {
	if happened == nil {
		return nil, &Error{InvalidArgument, "The function for events of peers is nil."}
	}
	var watch *C.hgros_watch
	err := s.do("session", func() C.hgros_status {
		return C.GoWatchPeers(s.handle, C.uintptr_t(cgo.NewHandle(happened)), &watch)
	})
	if err != nil {
		return nil, err
	}
	return s.watch(watch), nil
}

//export hgrosGoPeer
func hgrosGoPeer(user C.uintptr_t, event C.int32_t, peer *C.hgros_peer, channel, reason *C.char) {
	happened := cgo.Handle(user).Value().(func(PeerEvent, Peer, string, string))
	happened(PeerEvent(event), peerFrom(peer), C.GoString(channel), C.GoString(reason))
}
