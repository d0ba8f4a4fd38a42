#pragma once

#include <cstdint>
#include <string>

namespace hgros {

/// A service that the session offers. Its node in the graph, which has the same name, counts handled requests.
struct ServiceSnapshot {
  std::string name;
  std::uint64_t unhandled_requests = 0;  ///< Not handled: the caller had timed out, cancelled or gone.
  std::uint64_t dropped_replies = 0;     ///< Their callers were gone, or took none in time.
};

}  // namespace hgros
