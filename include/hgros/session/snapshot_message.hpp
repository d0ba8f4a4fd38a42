#pragma once

#include <string_view>

#include <hgros/Snapshot.pb.h>

#include "hgros/base/export.hpp"
#include "hgros/session/snapshot.hpp"

namespace hgros {

/// On this channel each session that others reach tells its statistics, once a second while one of them subscribes:
/// session.FromAny<Snapshot>(kSnapshotsChannel, ...). MessageInfo::id.publisher is the session that tells them; what
/// the message says about its sender is not checked. A session does not get its own: ask Session::Snapshot(). While
/// nobody subscribes, nothing is counted, written or sent for it. Subscribe with keep-last: while a lossless subscriber
/// has no room, nobody is told. An endpoint with a list of channels lets it pass if the list has it.
inline constexpr std::string_view kSnapshotsChannel = "hgros/snapshots";

/// The same as a message, with the name and number of this process, counted now.
///
/// Threading: any thread. Errors: none.
[[nodiscard]] HGROS_EXPORT Snapshot ToMessage(const SessionSnapshot& snapshot);

}  // namespace hgros
