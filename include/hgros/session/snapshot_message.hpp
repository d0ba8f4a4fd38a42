#pragma once

#include <string_view>

#include <hgros/Snapshot.pb.h>

#include "hgros/base/export.hpp"
#include "hgros/session/snapshot.hpp"

namespace hgros {

/// On this channel each session that others can reach publishes its statistics while another session subscribes:
/// session.FromAny<Snapshot>(kSnapshotsChannel, ...). It does so once a second, and at once when a new session
/// subscribes. MessageInfo::id.publisher is the sending session; the message's own fields about its sender are not
/// checked. A session does not get its own statistics; use Session::Snapshot(). Without subscribers nothing is counted,
/// encoded or sent for it. Subscribe with keep-last: while a lossless subscriber has no room, no subscriber gets
/// statistics. An endpoint with a list of channels needs this channel in its list.
inline constexpr std::string_view kSnapshotsChannel = "hgros/snapshots";

/// The snapshot as a message, with the name and id of this process and the current time.
///
/// Threading: any thread. Errors: none.
[[nodiscard]] HGROS_EXPORT Snapshot ToMessage(const SessionSnapshot& snapshot);

}  // namespace hgros
