#pragma once

#include <cstddef>
#include <memory>

#include "control.hpp"
#include "task.hpp"

namespace hgros::bench {

/// Receives on one lane and passes every message to the sink, until it is destroyed.
class Inlet {
 public:
  virtual ~Inlet() = default;
};

/// Sends on one lane.
class Outlet {
 public:
  virtual ~Outlet() = default;
  /// Where the next message is written: memory that the peer lends, or a filled buffer of ours. Waits for it for a
  /// while, then returns null.
  virtual std::byte* Take() = 0;
  /// Sends the message written since Take. False if the peer refused it.
  virtual bool Publish() = 0;
  /// Whether Take returns memory with arbitrary contents.
  [[nodiscard]] virtual bool lends() const { return false; }
};

/// One middleware in one of its modes, as one process sees it.
class Peer {
 public:
  virtual ~Peer() = default;
  /// The lane and the sink outlive the returned object.
  virtual std::unique_ptr<Inlet> Subscribe(const Lane& lane, Sink& sink) = 0;
  virtual std::unique_ptr<Outlet> Publish(const Lane& lane) = 0;
};

/// Every program of this folder defines it for its peer. The task outlives the peer. Exits with an error message if the
/// peer cannot run here.
std::unique_ptr<Peer> MakePeer(const Task& task);

}  // namespace hgros::bench
