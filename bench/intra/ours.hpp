#pragma once

#include <cstddef>

#include "hgros/graph/executor.hpp"
#include "support/samples.hpp"

namespace hgros::bench {

/// The data graph, measured as its users call it.

/// ns per message from the call of publish to its return; the callback runs in between.
double InlineHandle(std::size_t size_bytes, int count);
double InlineNamed(int count);
/// Messages per second of named publishes by `threads` threads, each on its own channel.
double NamedThroughput(int threads, int count);
Samples Latency(const Executor& executor, int count);
double TbbThroughput(int count);
/// ns per delivery to 20 nodes on one channel.
double Fanout20Inline(int count);
/// Likewise on tbb: 20 nodes flooded at once, while the publisher sleeps until the last delivery.
double Fanout20Tbb(int count);
/// From publish to the tenth of ten nodes in a row, ns.
Samples Pipeline10(const Executor& executor, int count);

}  // namespace hgros::bench
