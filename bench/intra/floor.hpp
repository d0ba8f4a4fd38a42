#pragma once

#include <functional>

#include "message.hpp"
#include "support/handoff.hpp"
#include "support/samples.hpp"

namespace hgros::bench {

/// The raw floors: the cost of the parts below us by themselves, with the same message.

/// One-way latency of a bare oneTBB function_node (serial), ns.
Samples FloorTbbLatency(int count);
/// Messages per second through a bare oneTBB function_node (serial), flooded by one thread.
double FloorTbbThroughput(int count);
/// One-way latency of a hand-off to a bare thread by mutex and condition variable, ns.
Samples FloorThreadLatency(int count);
/// Speedup of two threads over one when they share nothing: shows how far this machine's two CPUs are independent.
double FloorTwoThreads();

}  // namespace hgros::bench
