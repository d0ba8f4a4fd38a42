#pragma once

#include <cstdint>
#include <string>

namespace hgros {

/// A service that the session offers. Its node in the graph, under the same name, counts what was handled.
struct ServiceSnapshot {
  std::string name;
  std::uint64_t unhandled_requests =
      0;  ///< Callers that waited no more when their turn came: out of time, cancelled, gone.
  std::uint64_t dropped_replies = 0;  ///< Callers that were gone, or took none while 65536 waited for them.
};

}  // namespace hgros
