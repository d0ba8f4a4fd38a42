// Each transport is one entry here; see docs/transports.md.
#include "bridge/transports.hpp"

#include <utility>

namespace hgros {
namespace {

// Costs with room between them for further transports.
constexpr int kSharedMemoryCost = 100;
constexpr int kZmqCost = 1000;

TransportEntry SharedMemory(const std::optional<ShmOptions>& options) {
  TransportEntry entry{
      std::string(kSharedMemoryKey), "shared memory", kSharedMemoryCost, TransportReach::kHost, {}, true};
  if (!options) return entry;
  entry.make = [options = *options](TransportEntry::Takes takes, TransportListener& listener, Log& log) {
    ShmOptions own = options;
    own.takes = std::move(takes);
    return MakeShmTransport(std::move(own), listener, log);
  };
  return entry;
}

TransportEntry Zmq(const ZmqOptions& options) {
  const bool has_endpoints = !options.publish.empty() || !options.subscribe.empty();
  TransportEntry entry{std::string(kZmqKey), "ZeroMQ", kZmqCost, TransportReach::kNetwork, {}, has_endpoints};
  entry.make = [options](TransportEntry::Takes takes, TransportListener& listener, Log& log) {
    ZmqOptions own = options;
    own.takes = std::move(takes);
    return MakeZmqTransport(std::move(own), listener, log);
  };
  return entry;
}

}  // namespace

TransportList TransportsOf(const BridgeOptions& options) {
  std::vector<TransportEntry> entries = options.more_transports;
  entries.push_back(SharedMemory(options.shm));
  entries.push_back(Zmq(options.zmq));
  return TransportList(std::move(entries));
}

}  // namespace hgros
