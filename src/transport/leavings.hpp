#pragma once

#include <utility>

#include "hgros/transport/ends_later.hpp"
#include "transport/peer_channel.hpp"

namespace hgros {

/// Objects that an operation of a transport no longer needs. They are destroyed when the transport holds no mutex; if
/// the caller has an EndsLater, after the caller's lock. This matters because the destructors of messages are the
/// user's code.
struct Leavings {
  Leavings() = default;
  ~Leavings() {
    for (PendingMessage& message : messages) owners.push_back(std::move(message.packed));
    EndsLater::Keep(std::move(owners));
  }
  Leavings(const Leavings&) = delete;
  Leavings& operator=(const Leavings&) = delete;

  PeerChannel::Dropped messages;
  EndsLater::Owners owners;
};

}  // namespace hgros
