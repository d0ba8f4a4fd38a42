#include "transport/zmq/carrier.hpp"

#include <unistd.h>

#include <string>
#include <utility>

#include "hgros/clock/time.hpp"

namespace hgros::zmq {
namespace {

SessionFacts FactsOf(const ZmqOptions& options) {
  SessionFacts facts;
  facts.info.id = options.session;
  facts.info.process = options.process;
  char host[256] = {};
  if (gethostname(host, sizeof host - 1) == 0) facts.info.host = host;
  facts.info.pid = getpid();
  facts.incarnation = static_cast<std::uint64_t>(WallNow().nanoseconds);
  return facts;
}

ZmqOptions Completed(ZmqOptions options) {
  if (options.session.value == 0) options.session = SessionId::Random();
  return options;
}

}  // namespace

void PeerRegistry::Came(const PeerInfo& peer) {
  {
    const std::scoped_lock lock(mutex_);
    Entry& entry = peers_[peer.id];
    if (++entry.connections > 1) return;
    entry.info = peer;
  }
  listener_.OnPeerCame(peer);
}

void PeerRegistry::Gone(const PeerInfo& peer, std::string_view reason) {
  PeerInfo known;
  {
    const std::scoped_lock lock(mutex_);
    const auto entry = peers_.find(peer.id);
    if (entry == peers_.end() || --entry->second.connections > 0) return;
    known = std::move(entry->second.info);
    peers_.erase(entry);
  }
  listener_.OnPeerGone(known, reason);
}

std::vector<PeerInfo> PeerRegistry::List() const {
  const std::scoped_lock lock(mutex_);
  std::vector<PeerInfo> list;
  list.reserve(peers_.size());
  for (const auto& [id, entry] : peers_) list.push_back(entry.info);
  return list;
}

Carrier::Carrier(ZmqOptions given, TransportListener& told, Log& voice)
    : options(Completed(std::move(given))), self(FactsOf(options)), listener(told), log(voice), peers(told) {}

void Carrier::CountFault(PacketFault fault, std::string_view where, std::string_view what) {
  faults[static_cast<std::size_t>(fault)].fetch_add(1, std::memory_order_relaxed);
  std::string key = "zmq fault ";
  key.append(where).append(" ").append(ToString(fault));
  std::string text = "Dropped a packet from ";
  text.append(where).append(" (").append(ToString(fault)).append("): ").append(what);
  log.WriteLimited(LogLevel::kWarning, key, text);
}

void Carrier::Post(Actions&& actions) {
  if (actions.empty()) return;
  {
    const std::scoped_lock lock(posted_mutex_);
    for (auto& action : actions) posted_.push_back(std::move(action));
  }
  actions.clear();
  waker->Wake();
}

Actions Carrier::TakePosted() {
  const std::scoped_lock lock(posted_mutex_);
  return std::exchange(posted_, {});
}

}  // namespace hgros::zmq
