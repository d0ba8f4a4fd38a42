#include "transport/zmq/shared_state.hpp"

#include <string>
#include <utility>

#include "transport/zmq/curve.hpp"

namespace hgros::zmq {
namespace {

ZmqOptions WithSession(ZmqOptions options) {
  if (options.session.value == 0) options.session = SessionId::Random();
  return options;
}

}  // namespace

SharedState::SharedState(ZmqOptions given, TransportListener& told, Log& voice)
    : options(WithSession(std::move(given))),
      self(OwnFacts(options.session, options.process)),
      listener(told),
      log(voice),
      peers(told),
      session_keys_(peers, options.session,
                    options.security ? KeyText(options.security->own.public_key, "own public") : "") {}

void SharedState::SayUnconfirmed() const {
  if (unconfirmed.messages == 0) return;
  log.Write(LogLevel::kWarning, "The session has ended before its subscribers had received everything: up to " +
                                    std::to_string(unconfirmed.messages) +
                                    " messages of lossless channels, such as \"" + unconfirmed.channel +
                                    "\", may be lost. Keep the session until its subscribers have taken them.");
}

bool SharedState::MayClaim(SessionId session, std::string_view key, std::string_view where) {
  if (!options.security || session_keys_.Claim(session, key)) return true;
  std::string name = session == self.info.id ? self.info.name() : session.ToString();
  for (const PeerInfo& peer : peers.List()) {
    if (peer.id == session) name = peer.name();
  }
  CountFault(PacketFault::kHead, where, "it is in the name of " + name + ", which has another key");
  return false;
}

void SharedState::CountFault(PacketFault fault, std::string_view where, std::string_view what) {
  CountFaultLike(where, fault, where, what);
}

void SharedState::CountPeerFault(PacketFault fault, std::string_view peer, std::string_view what) {
  CountFaultLike("of a peer", fault, peer, what);
}

// `alike`: how the log recognizes lines that are limited together.
void SharedState::CountFaultLike(std::string_view alike, PacketFault fault, std::string_view where,
                                 std::string_view what) {
  faults[static_cast<std::size_t>(fault)].fetch_add(1, std::memory_order_relaxed);
  std::string key = "zmq fault ";
  key.append(alike).append(" ").append(ToString(fault));
  std::string text = "Dropped a packet from ";
  text.append(where).append(" (").append(ToString(fault)).append("): ").append(what);
  log.WriteLimited(LogLevel::kWarning, key, text);
}

void SharedState::PostActions(Actions&& actions) {
  if (actions.empty()) return;
  {
    const std::scoped_lock lock(posted_mutex_);
    for (auto& action : actions) posted_.push_back(std::move(action));
  }
  actions.clear();
  waker->Wake();
}

Actions SharedState::CollectPosted() {
  const std::scoped_lock lock(posted_mutex_);
  return std::exchange(posted_, {});
}

}  // namespace hgros::zmq
