#include "transport/shm/shm_core.hpp"

#include <utility>

namespace hgros::shm {
namespace {

ShmOptions WithDefaults(ShmOptions options) {
  if (options.session.value == 0) options.session = SessionId::Random();
  if (options.place.empty()) options.place = "hgros-" + options.session.ToString();
  return options;
}

}  // namespace

ShmCore::ShmCore(ShmOptions options, TransportListener& listener, Log& log)
    : session_(WithDefaults(std::move(options)), listener, log),
      registry_(listener),
      publisher_(session_, pairs_, sockets_),
      offered_(session_, pairs_, sockets_, publisher_),
      wanted_(session_, pairs_),
      receiver_(session_, pairs_, sockets_, publisher_, wanted_),
      connections_(session_, {.pairs = pairs_,
                              .sockets = sockets_,
                              .publisher = publisher_,
                              .offered = offered_,
                              .wanted = wanted_,
                              .bell = receiver_.bell(),
                              .destinations = destinations_,
                              .obstacles = obstacles_,
                              .registry = registry_}) {
  for (const std::string& place : session_.options.peers) (void)destinations_.Add(place);
}

ShmCore::~ShmCore() { Close(0); }

void ShmCore::Start() {
  receiver_.Start();
  sockets_.Start(connections_);
}

void ShmCore::Close(int linger_ms) noexcept {
  if (!publisher_.Close(linger_ms)) return;
  sockets_.Stop();
  receiver_.Stop();
  publisher_.pool().Close();  // Peers may still read blocks that are released below.
  Actions nobody_listens;     // Destroyed without a lock: messages may be destroyed with it.
  connections_.Close(nobody_listens);
}

void ShmCore::AddPeer(const std::string& place) {
  if (place != session_.options.place && destinations_.Add(place)) sockets_.Wake();
}

ShmUsage ShmCore::usage() const {
  const auto usage = publisher_.pool().usage();
  return {.segment_bytes = usage.segment_bytes,
          .segments = usage.segments,
          .blocks_in_use = usage.blocks_in_use,
          .sent_apart = publisher_.sent_apart()};
}

TransportStats ShmCore::stats() const {
  TransportStats stats;
  for (std::size_t i = 0; i < stats.faults.size(); ++i) stats.faults[i] = session_.faults[i].load();
  stats.repeats = session_.repeats.load();
  return stats;
}

}  // namespace hgros::shm
