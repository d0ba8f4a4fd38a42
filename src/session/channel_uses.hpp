#pragma once

#include <string>

#include "hgros/bridge/channel_directory.hpp"
#include "hgros/codec/raw_message.hpp"

namespace hgros {

// A channel with the type that it is used with, if that is known.
[[nodiscard]] inline ChannelUse UseOf(const std::string& channel, const TypeInfo& type) {
  ChannelUse use{.channel = channel};
  if (IsAnyType(type)) return use;
  use.type_name = type.name;
  use.encoding = type.encoding;
  use.fingerprint = type.fingerprint;
  return use;
}

}  // namespace hgros
