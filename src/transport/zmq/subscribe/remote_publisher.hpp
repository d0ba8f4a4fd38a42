#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <unordered_set>
#include <vector>

#include "hgros/control.pb.h"
#include "transport/agreement.hpp"
#include "transport/zmq/clock_question.hpp"
#include "transport/zmq/shared_state.hpp"

namespace hgros::zmq {

/// The session at the other end of a subscribe endpoint, as its Welcome and its Offers describe it.
/// Thread safety: none; the endpoint's mutex guards it.
struct RemotePublisher {
  [[nodiscard]] SessionId id() const noexcept { return facts.info.id; }
  /// Whether a Welcome has ever come.
  [[nodiscard]] bool known() const noexcept { return facts.info.id.value != 0; }
  /// Ignores channels with invalid names, and those beyond a limit.
  void AddOffer(const wire::ChannelType& offered);
  void UpdateOffers(const wire::Offers& changed);
  /// Adds what is published there.
  void AddOffers(std::vector<SessionChannels>& known) const;

  SessionFacts facts;
  std::uint64_t handshake = 0;  ///< The number in its latest Welcome.
  SteadyTime last_heard{};
  bool alive = false;
  ClockQuestion clock;
  std::unordered_set<std::string> reported_mismatches;  ///< Channels.
  std::map<std::string, ChannelUse> offers;             ///< By channel.
};

}  // namespace hgros::zmq
