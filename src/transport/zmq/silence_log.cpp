#include "transport/zmq/silence_log.hpp"

#include <string>
#include <utility>

namespace hgros::zmq {
namespace {

constexpr std::size_t kMostSilentPeers = 1024;  // A limit against strangers.
constexpr auto kEachOutage = std::chrono::seconds(1);

}  // namespace

void SilenceLog::Note(const PeerInfo& peer, Time heard) {
  Heard& known = peers_[peer.id];
  known.at = known.connected ? std::max(known.at, heard) : heard;
  if (known.peer.id != peer.id) known.peer = peer;
  known.connected = true;
}

SilenceLog::Time SilenceLog::Report(Time now) {
  // A silent peer that has been disconnected meanwhile may come back.
  std::erase_if(peers_, [&](const auto& one) {
    return !one.second.connected && (!one.second.silent || peers_.size() > kMostSilentPeers);
  });
  Time next = Time::max();
  for (auto& [id, known] : peers_) {
    if (!std::exchange(known.connected, false)) continue;
    const bool silent = now - known.at >= patience_;
    if (silent && !known.silent) {
      log_.WriteLimited(LogLevel::kWarning, "silent " + id.ToString(),
                        "Nothing has arrived from " + known.peer.name() + " for " + std::to_string(patience_.count()) +
                            " ms: the network between is cut, or the process is stopped.",
                        kEachOutage);
    } else if (!silent && known.silent) {
      log_.WriteLimited(LogLevel::kWarning, "heard " + id.ToString(),
                        "Messages from " + known.peer.name() + " arrive again.", kEachOutage);
    }
    known.silent = silent;
    if (!silent) next = std::min(next, known.at + patience_);
  }
  return next;
}

}  // namespace hgros::zmq
