#pragma once

#include <utility>

#include "hgros/transport/ends_later.hpp"
#include "transport/peer_channel.hpp"

namespace hgros {

/// What ends with an operation of a carrier, to be destroyed when the carrier holds no mutex; after the caller's lock,
/// if that has said so (EndsLater). The destructors of messages are the user's code.
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
