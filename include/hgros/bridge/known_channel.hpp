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
  std::string host;     ///< Its host's name. Only shown, never compared.
  std::int64_t pid = 0;
  std::string type_name;  ///< The type it uses the channel with; empty: any type.
  Encoding encoding = Encoding::kNone;
  std::uint64_t fingerprint = 0;  ///< 0: unknown.
  bool lossless = false;          ///< For a subscriber: nothing may be dropped.
};

/// A channel and its users, as far as this session can know them: itself, the sessions of its host, sessions whose
/// endpoints it has connected to, and sessions that have connected to its own endpoints. It does not see what two other
/// sessions exchange elsewhere.
struct KnownChannel {
  std::string name;       ///< Channels of the library itself begin with "hgros/".
  std::string type_name;  ///< The first publisher's, or else the first subscriber's; empty: unknown.
  Encoding encoding = Encoding::kNone;
  std::uint64_t fingerprint = 0;
  std::vector<ChannelUser> publishers;   ///< By session id.
  std::vector<ChannelUser> subscribers;  ///< By session id.
};

/// The result of Session::Channels() may have changed since the last call. Published inside the process on
/// kChannelEventsChannel, at most every 20 ms, and only if there is a subscriber:
/// session.FromGraph<ChannelsChanged>(kChannelEventsChannel, ...).
struct ChannelsChanged {
  std::uint64_t number = 0;  ///< Counts these messages.
};

inline constexpr std::string_view kChannelEventsChannel = "hgros/channels";

}  // namespace hgros
