#pragma once

#include <array>
#include <string_view>

namespace hgros {

/// The keys at the top of a configuration file that belong to the session.
inline constexpr std::array<std::string_view, 7> kConfigSections{"network", "discovery",  "shared_memory", "time",
                                                                 "control", "data_graph", "channels"};

}  // namespace hgros
