#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "hgros/discovery/registry.hpp"
#include "hgros/transport/shm_transport.hpp"
#include "hgros/transport/zmq_transport.hpp"

namespace hgros::test {

/// A session made of transports that a test opens and closes.
class HandMadeSession {
 public:
  HandMadeSession(const HandMadeSession&) = delete;
  HandMadeSession& operator=(const HandMadeSession&) = delete;
  ~HandMadeSession() {
    Leave();
    if (shm_) shm_->Close(0);
    if (zmq_) zmq_->Close(0);
  }

  /// Leaves the registry of the host.
  void Leave() { registry_.reset(); }

 protected:
  explicit HandMadeSession(std::string name) : name_(std::move(name)) {}

  /// Announces itself in the domain, as a user of the channel, with a place for shared memory that may not be open yet.
  void Enlist(const std::string& domain, ChannelAnnouncement use) {
    RegistryOptions options;
    options.domain = domain;
    registry_ = OpenRegistry(options, ears_, log_);
    Announcement own = AnnouncementOfThisProcess(id_, 1);
    own.places["shared_memory"] = place_;
    own.channels.push_back(std::move(use));
    registry_->Announce(own);
  }
  /// `options` has the endpoints.
  void OpenZmq(ZmqOptions options) {
    options.session = id_;
    options.process = name_;
    options.heartbeat = kHeartbeat;
    zmq_ = MakeZmqTransport(std::move(options), ears_, log_);
  }
  void OpenShm(SessionId peer) {
    ShmOptions options;
    options.session = id_;
    options.process = name_;
    options.heartbeat = kHeartbeat;
    options.place = place_;
    if (id_.value < peer.value) options.peers = {"hgros-" + peer.ToString()};
    shm_ = MakeShmTransport(options, ears_, log_);
  }

  [[nodiscard]] SessionId id() const { return id_; }

 private:
  /// Short enough for a peer with a short timeout.
  static constexpr std::chrono::milliseconds kHeartbeat{50};

  // A separate object, because the threads that call it end in the destructor of the session.
  class Ears final : public TransportListener, public DiscoveryListener {
    void OnCame(const Announcement& /*peer*/) override {}
    void OnChanged(const Announcement& /*peer*/) override {}
    void OnGone(const Announcement& /*last*/, std::string_view /*reason*/) override {}
    void OnPeerCame(const PeerInfo& /*peer*/) noexcept override {}
    void OnPeerGone(const PeerInfo& /*peer*/, std::string_view /*reason*/) noexcept override {}
    void OnTypeMismatch(std::string_view /*channel*/, const PeerInfo& /*peer*/,
                        std::string_view /*what*/) noexcept override {}
  };

  const std::string name_;
  const SessionId id_ = SessionId::Random();
  const std::string place_ = "hgros-" + name_ + "-" + id_.ToString();
  Log log_{[](LogLevel, std::string_view) {}};
  Ears ears_;

 protected:
  std::unique_ptr<ZmqTransport> zmq_;
  std::unique_ptr<ShmTransport> shm_;

 private:
  std::unique_ptr<Discovery> registry_;
};

}  // namespace hgros::test
