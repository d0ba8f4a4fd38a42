#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "transport/shm/pair/pair_table.hpp"
#include "transport/shm/pair/socket_thread.hpp"
#include "transport/shm/shm_publisher.hpp"
#include "transport/shm/shm_session.hpp"

namespace hgros::shm {

/// Makes a link for each channel that this session offers and a peer wishes.
///
/// Thread safety: Offer() and Withdraw() are thread-safe, the rest runs on the socket thread. Order of locks: this one,
/// then the publisher's. It guards Pair::wishes and Pair::ended.
/// Invariants: a wish has a link exactly while its channel is offered, its type fits and its pair is alive.
class OfferedChannels {
 public:
  OfferedChannels(ShmSession& session, PairTable& pairs, SocketThread& sockets, ShmPublisher& publisher)
      : session_(session), pairs_(pairs), sockets_(sockets), publisher_(publisher) {}

  /// Throws Error if the channel is offered already.
  void Offer(const std::shared_ptr<OutChannel>& core);
  void Withdraw(const std::shared_ptr<OutChannel>& core);

  void OnWish(Pair& pair, const wire::Wish& asked);
  void OnUnwish(Pair& pair, const wire::Unwish& unwish);
  /// The pair is no longer alive: ends its links and forgets its wishes.
  void EndPair(Pair& pair, ShmPublisher::LinkEnd why, Actions& actions);

 private:
  void Serve(Pair& pair, PeerWish& wish, Actions& actions);
  void EndLink(Pair& pair, PeerWish& wish, ShmPublisher::LinkEnd why, Actions& actions);
  [[nodiscard]] Demand GrantedTo(const OutboundCore& core, const wire::Wish& asked) const;

  ShmSession& session_;
  PairTable& pairs_;
  SocketThread& sockets_;
  ShmPublisher& publisher_;
  std::mutex mutex_;
  std::map<std::string, std::shared_ptr<OutChannel>, std::less<>> channels_;
};

}  // namespace hgros::shm
