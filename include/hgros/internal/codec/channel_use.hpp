#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "hgros/codec/type_info.hpp"

namespace hgros {

/// The longest type name that can be announced and asked for.
inline constexpr std::size_t kMaxTypeNameBytes = 1024;

/// A session's use of one channel.
struct ChannelUse {
  std::string channel;
  std::string type_name = {};  ///< Empty: any type, or unknown.
  Encoding encoding = Encoding::kNone;
  std::uint64_t fingerprint = 0;  ///< 0: unknown.
  bool publishes = false;
  bool subscribes = false;
  bool lossless = false;  ///< As a subscriber: nothing may be dropped.

  bool operator==(const ChannelUse&) const = default;
};

}  // namespace hgros
