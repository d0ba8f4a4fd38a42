#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "hgros/base/histogram.hpp"
#include "hgros/graph/executor.hpp"
#include "hgros/graph/invoke.hpp"
#include "hgros/graph/queue.hpp"

namespace hgros {

/// How old chains were when a node began to handle their messages: since the message that began the chain was
/// published.
struct ChainAges {
  std::uint32_t origin = 0;  ///< Cause::OriginOf() the channel where they began; 0: all origins beyond the first 16.
  LogHistogram age;          ///< ns; its mean and its largest value are those of the buckets.
};

/// Counters of one node since its creation. All only grow, except `queued` and `running`.
struct NodeSnapshot {
  std::string name;
  std::string channel;
  Invoke invoke = Invoke::kSerial;
  Queue queue;
  Executor executor;
  std::uint64_t received = 0;   ///< Messages that reached the node, including those dropped later.
  std::uint64_t dropped = 0;    ///< Removed from a full keep-last queue.
  std::uint64_t run = 0;        ///< Callbacks that returned or threw.
  std::uint64_t failed = 0;     ///< Callbacks that threw.
  std::uint64_t refused = 0;    ///< Messages of another type than the program named, which it did not take.
  std::uint64_t queued = 0;     ///< Waiting now.
  LogHistogram queue_wait;      ///< From publish to start of the callback, ns.
  LogHistogram run_time;        ///< Time in the callback, ns.
  std::vector<ChainAges> ages;  ///< By origin, in the order of their first messages.
  bool handed_over = false;     ///< A thread of another language runs the callbacks: see HandedOver.
};

struct ChannelSnapshot {
  std::string name;
  std::string type;
  std::uint64_t published = 0;  ///< By this process.
  double rate_hz = 0;           ///< Published by this process: over the last one to two seconds, or 8 to 16 messages.
  std::uint64_t refused = 0;    ///< Publishes with a status other than kOk.
  std::uint64_t received = 0;   ///< From outside.
  bool closed = false;          ///< Messages are not delivered to this process' own nodes.
  std::size_t latched = 0;
  std::uint64_t not_latched = 0;  ///< Latched messages of other sessions that were not kept, because of the limits.
  /// For a channel with two C++ types, such as T and Bulk<T>: messages converted to the other type because a node here
  /// needs it, each at most once, and failed conversions.
  std::uint64_t converted = 0;
  std::uint64_t not_converted = 0;
  std::vector<NodeSnapshot> nodes;
};

/// A picture of a data graph. Each number is exact, but they are read one after the other.
struct GraphSnapshot {
  std::vector<ChannelSnapshot> channels;  ///< Sorted by name.
};

}  // namespace hgros
