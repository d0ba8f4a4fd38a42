#pragma once

#include <cstddef>
#include <memory>

#include "control.hpp"
#include "task.hpp"

namespace hgros::bench {

/// Receives on one lane and hands every message to the sink, until it is destroyed.
class Inlet {
 public:
  virtual ~Inlet() = default;
};

/// Sends on one lane.
class Outlet {
 public:
  virtual ~Outlet() = default;
  /// Where the next message is written: memory that the peer lends, or a buffer of ours that is filled already. Waits
  /// for it for a while; null if there is none.
  virtual std::byte* Take() = 0;
  /// Sends what was written since Take. False if the peer refused it.
  virtual bool Publish() = 0;
  /// Whether Take gives memory with whatever was in it.
  [[nodiscard]] virtual bool lends() const { return false; }
};

/// One middleware in one of its modes, as one process sees it.
class Peer {
 public:
  virtual ~Peer() = default;
  /// The lane and the sink outlive what is returned.
  virtual std::unique_ptr<Inlet> Subscribe(const Lane& lane, Sink& sink) = 0;
  virtual std::unique_ptr<Outlet> Publish(const Lane& lane) = 0;
};

/// Every program of this folder defines it for its peer; the task outlives the peer. Exits with a sentence if the peer
/// cannot do it here.
std::unique_ptr<Peer> MakePeer(const Task& task);

}  // namespace hgros::bench
