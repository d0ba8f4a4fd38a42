#pragma once

#include <functional>

#include "message.hpp"
#include "support/handoff.hpp"
#include "support/samples.hpp"

namespace hgros::bench {

/// The raw floors: what the parts below us cost by themselves, with the same message.

/// One-way latency of a bare oneTBB function_node (serial), ns.
Samples FloorTbbLatency(int count);
/// Messages per second through a bare oneTBB function_node (serial), flooded by one thread.
double FloorTbbThroughput(int count);
/// One-way latency of a hand-off to a bare thread by mutex and condition variable, ns.
Samples FloorThreadLatency(int count);
/// How much more two threads get done than one when they share nothing: what this machine's two CPUs are worth.
double FloorTwoThreads();

}  // namespace hgros::bench
