#pragma once

#include <string_view>

#include <hgros/Snapshot.pb.h>

#include "hgros/base/export.hpp"
#include "hgros/session/snapshot.hpp"

namespace hgros {

/// On this channel every session that others reach tells what it counts, once a second while one of them subscribes:
/// session.FromAny<Snapshot>(kSnapshotsChannel, ...). Who tells it is MessageInfo::id.publisher; what the message says
/// of itself is not checked. One's own session is not among them: ask Session::Snapshot(). Nothing is counted, written
/// or sent for it while nobody subscribes. Subscribe with keep-last: while a lossless subscriber has no room, nobody is
/// told. An endpoint with a list of channels lets it pass if the list has it.
inline constexpr std::string_view kSnapshotsChannel = "hgros/snapshots";

/// The same as a message, with the name and number of this process, counted now.
///
/// Threading: any thread. Errors: none.
[[nodiscard]] HGROS_EXPORT Snapshot ToMessage(const SessionSnapshot& snapshot);

}  // namespace hgros
