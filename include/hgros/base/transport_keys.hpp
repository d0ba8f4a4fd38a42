#pragma once

#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace hgros {

/// The library's transports, as configurations and announcements name them.
inline constexpr std::string_view kSharedMemoryKey = "shared_memory";
inline constexpr std::string_view kZmqKey = "zmq";
inline constexpr std::initializer_list<std::string_view> kTransportKeys = {kSharedMemoryKey, kZmqKey};

/// Which transports may be used; nullopt means all.
using TransportKeys = std::optional<std::vector<std::string>>;

}  // namespace hgros
