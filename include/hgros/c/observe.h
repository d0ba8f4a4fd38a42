#pragma once

#include "hgros/c/message.h"
#include "hgros/c/session.h"

// Who is there: peers, channels, counters. hgros/hgros.h has the rules of all functions.

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

/// The sessions that are connected with one, at one moment.
typedef struct hgros_peers hgros_peers;

/// The texts belong to the list, or are valid until the callback returns.
typedef struct hgros_peer {
  size_t size;
  uint64_t id;          ///< Its session id.
  const char* process;  ///< Its program's name.
  const char* host;     ///< Its host's name. Only shown, never compared.
  int64_t pid;
  const char* transport;  ///< Of its messages: "shared memory" or "ZeroMQ".
  const char* why;        ///< Why that transport was chosen, such as "same host".
} hgros_peer;

hgros_status hgros_peers_open(const hgros_session* session, hgros_peers** peers);
size_t hgros_peers_count(const hgros_peers* peers);
/// Errors: HGROS_NOT_FOUND if `index` is not below the count.
hgros_status hgros_peers_get(const hgros_peers* peers, size_t index, hgros_peer* peer);
void hgros_peers_free(hgros_peers* peers);

/// The channels of all sessions that are known, including the own, sorted by name, at one moment.
typedef struct hgros_channels hgros_channels;

/// The texts belong to the list.
typedef struct hgros_channel {
  size_t size;
  const char* name;       ///< Channels of the library itself begin with "hgros/".
  const char* type_name;  ///< Empty: unknown.
  uint64_t fingerprint;   ///< 0: unknown.
  int32_t encoding;       ///< HGROS_ENCODING_...
  size_t publishers;
  size_t subscribers;
} hgros_channel;

/// A session that publishes a channel or subscribes to it.
typedef struct hgros_channel_user {
  size_t size;
  int32_t lossless;  ///< For a subscriber: nothing may be dropped.
  uint64_t session;  ///< Its id.
  const char* process;
  const char* host;
  int64_t pid;
  const char* type_name;  ///< The type it uses the channel with; empty: any type.
} hgros_channel_user;

enum { HGROS_ROLE_PUBLISHER = 0, HGROS_ROLE_SUBSCRIBER = 1 };

hgros_status hgros_channels_open(hgros_session* session, hgros_channels** channels);
size_t hgros_channels_count(const hgros_channels* channels);
/// Errors of both: HGROS_NOT_FOUND if an index is not below its count.
hgros_status hgros_channels_get(const hgros_channels* channels, size_t index, hgros_channel* channel);
/// The user `user_index` of channel `index` in a role, HGROS_ROLE_...
hgros_status hgros_channels_get_user(const hgros_channels* channels, size_t index, int32_t role, size_t user_index,
                                     hgros_channel_user* user);
void hgros_channels_free(hgros_channels* channels);

/// All counters of the session as a protobuf message hgros.Snapshot (share/hgros/proto/hgros/Snapshot.proto), which the
/// caller frees.
hgros_status hgros_session_snapshot(const hgros_session* session, hgros_message** snapshot);

/// Something that is watched until it is closed.
typedef struct hgros_watch hgros_watch;
/// No call comes after it. Outside callbacks it waits for the running one. Inside a callback it does not, and `release`
/// comes once that one has returned.
void hgros_watch_close(hgros_watch* watch);

enum { HGROS_PEER_CAME = 0, HGROS_PEER_GONE = 1, HGROS_PEER_TYPE_MISMATCH = 2, HGROS_PEER_SERVED_TWICE = 3 };

/// What has happened to a session. `channel` is empty for the first two, `reason` for HGROS_PEER_CAME; otherwise it is
/// a sentence, for a mismatch with both types.
typedef void (*hgros_peer_callback)(void* user, int32_t event, const hgros_peer* peer, const char* channel,
                                    const char* reason);
/// Calls `callback` when a session comes or goes, uses a channel with another type, or serves a name that is served.
/// One call at a time. Watch first, then call hgros_peers_open() for those that came earlier.
hgros_status hgros_watch_peers(hgros_session* session, hgros_peer_callback callback, void* user, hgros_release release,
                               hgros_watch** watch);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif
