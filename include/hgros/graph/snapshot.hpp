#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "hgros/base/histogram.hpp"
#include "hgros/graph/executor.hpp"
#include "hgros/graph/invoke.hpp"
#include "hgros/graph/queue.hpp"

namespace hgros {

/// What one node has seen since it was made. All counts only grow, except `queued` and `running`.
struct NodeSnapshot {
  std::string name;
  std::string channel;
  Invoke invoke = Invoke::kSerial;
  Queue queue;
  Executor executor;
  std::uint64_t received = 0;  ///< Messages that reached the node, also those dropped later.
  std::uint64_t dropped = 0;   ///< Pushed out of a full keep-last queue.
  std::uint64_t run = 0;       ///< Callbacks that returned or threw.
  std::uint64_t failed = 0;    ///< Callbacks that threw.
  std::uint64_t queued = 0;    ///< Waiting now.
  LogHistogram queue_wait;     ///< From publish to start of the callback, ns.
  LogHistogram run_time;       ///< Of the callback, ns.
};

struct ChannelSnapshot {
  std::string name;
  std::string type;
  std::uint64_t published = 0;  ///< By this process.
  std::uint64_t refused = 0;    ///< Publishes that ended with any status but kOk.
  std::uint64_t received = 0;   ///< From outside.
  bool closed = false;          ///< Not delivered to this process' own nodes.
  std::size_t latched = 0;
  /// On a channel that is used with two C++ types, such as T and Bulk<T>: messages that were made into the other one,
  /// each at most once, because a node here wants that. And those with which that could not be done.
  std::uint64_t converted = 0;
  std::uint64_t not_converted = 0;
  std::vector<NodeSnapshot> nodes;
};

/// One consistent-enough picture of a data graph: each number is exact, taken one after the other.
struct GraphSnapshot {
  std::vector<ChannelSnapshot> channels;  ///< Sorted by name.
};

}  // namespace hgros
