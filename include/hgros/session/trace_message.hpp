#pragma once

#include <string_view>

#include <hgros/Trace.pb.h>

namespace hgros {

/// On this channel each session that others can reach publishes what its nodes do while another session subscribes, ten
/// times a second: each message that it publishes and each callback that has ended, with the keys of the messages.
/// MessageInfo::id.publisher is the sending session; the message's own fields about its sender are not checked. Without
/// subscribers nothing is recorded. Subscribe with a deep keep-last queue.
inline constexpr std::string_view kTraceChannel = "hgros/trace";

}  // namespace hgros
