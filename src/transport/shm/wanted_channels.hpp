#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>

#include "transport/shm/pair/pair_table.hpp"
#include "transport/shm/pair/socket_thread.hpp"
#include "transport/shm/shm_session.hpp"

namespace hgros::shm {

/// The channels that this session has subscribed to: asks every peer for them, and handles the answers.
///
/// Thread safety: all functions; those that start with On, and EndLink(), run on the socket thread. Order of locks:
/// this one, then a pair's inbox or socket. It guards Pair::asks. Invariants: every pair with `asks` has a link for
/// each channel here that may be asked for there.
class WantedChannels {
 public:
  WantedChannels(ShmSession& session, PairTable& pairs) : session_(session), pairs_(pairs) {}

  /// Throws Error if the channel is subscribed to already.
  void Want(const std::shared_ptr<InboundCore>& core);
  void Unwant(const std::shared_ptr<InboundCore>& core);
  void ChangeDemand(const std::shared_ptr<InboundCore>& core);

  /// Asks the pair for all channels that it is not asked for yet.
  void AskPair(Pair& pair);
  /// Asks all pairs that are alive.
  void AskPairs();
  /// Whether that session is asked for the channel.
  [[nodiscard]] bool Asks(const InboundCore& core, SessionId publisher) const;
  /// The pair is no longer alive.
  void StopAsking(Pair& pair);

  void OnGranted(Pair& pair, const wire::Granted& granted);
  void OnMisfit(Pair& pair, const wire::Misfit& misfit);
  void OnEnded(Pair& pair, const wire::Ended& ended);
  /// False if the report cannot be true.
  [[nodiscard]] bool OnTooLarge(Pair& pair, const wire::TooLarge& said);
  /// The publisher has withdrawn the channel, and everything was read: asks again.
  void EndLink(Pair& pair, std::uint64_t number);

 private:
  [[nodiscard]] bool MayAsk(const Pair& pair, const std::string& channel) const;
  void AskForAll(Pair& pair);
  void Ask(Pair& pair, const std::shared_ptr<InboundCore>& core);
  static void SendWish(Pair& pair, InLink& link);
  static void RemoveLink(Pair& pair, const std::string& channel, std::string_view mismatch, Actions& actions,
                         OfferEnd why = OfferEnd::kLost);

  ShmSession& session_;
  PairTable& pairs_;
  mutable std::mutex mutex_;
  std::map<std::string, std::shared_ptr<InboundCore>, std::less<>> channels_;
};

}  // namespace hgros::shm
