#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "hgros/base/ids.hpp"
#include "hgros/codec/type_info.hpp"

namespace hgros {

/// A session that publishes or subscribes to a channel.
struct ChannelUser {
  SessionId session;
  std::string process;  ///< Its program's name.
  std::string host;     ///< Its host's name; for people, never compared.
  std::int64_t pid = 0;
  std::string type_name;  ///< With which it uses the channel; empty: with whatever there is.
  Encoding encoding = Encoding::kNone;
  std::uint64_t fingerprint = 0;  ///< 0: unknown.
  bool lossless = false;          ///< A subscriber: nothing may be dropped.
};

/// A channel and who uses it, as far as this session can know: itself, the sessions of its host, those whose endpoints
/// it has connected to, and those that have connected to its own. Of two others that meet elsewhere it knows nothing.
struct KnownChannel {
  std::string name;       ///< The library's own begin with "hgros/".
  std::string type_name;  ///< The first publisher's, or else the first subscriber's; empty: nobody has said.
  Encoding encoding = Encoding::kNone;
  std::uint64_t fingerprint = 0;
  std::vector<ChannelUser> publishers;   ///< By session id.
  std::vector<ChannelUser> subscribers;  ///< By session id.
};

/// Session::Channels(), which was asked before, may say something else now. Published inside the process on
/// kChannelEventsChannel, at most every 20 ms, and only if somebody listens:
/// session.FromGraph<ChannelsChanged>(kChannelEventsChannel, ...).
struct ChannelsChanged {
  std::uint64_t number = 0;  ///< Counts them.
};

inline constexpr std::string_view kChannelEventsChannel = "hgros/channels";

}  // namespace hgros
