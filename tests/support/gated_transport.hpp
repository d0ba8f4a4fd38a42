#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "hgros/bridge/transport_list.hpp"
#include "hgros/transport/shm_transport.hpp"

namespace hgros::test {

/// Lets the transports behind it reach each other from the moment on that the test says so.
class Gate {
 public:
  void Open() {
    std::vector<std::pair<Transport*, std::string>> waiting;
    {
      const std::scoped_lock lock(mutex_);
      open_ = true;
      waiting.swap(waiting_);
    }
    for (const auto& [transport, place] : waiting) transport->AddPeer(place);
  }
  /// Connects now, or when the gate opens.
  void Connect(Transport& transport, const std::string& place) {
    {
      const std::scoped_lock lock(mutex_);
      if (!open_) {
        waiting_.emplace_back(&transport, place);
        return;
      }
    }
    transport.AddPeer(place);
  }
  void Leave(Transport& transport) {
    const std::scoped_lock lock(mutex_);
    std::erase_if(waiting_, [&](const auto& one) { return one.first == &transport; });
  }

 private:
  std::mutex mutex_;
  bool open_ = false;
  std::vector<std::pair<Transport*, std::string>> waiting_;
};

/// A transport that exists only in tests: it shows the bridge nothing except the interface of Transport. Its sessions
/// meet in memory at places of its own, once the gate is open.
class GatedTransport final : public Transport {
 public:
  GatedTransport(ShmOptions options, TransportListener& listener, Log& log, Gate& gate)
      : gate_(gate), inner_(MakeShmTransport(std::move(options), listener, log)) {}
  ~GatedTransport() override { gate_.Leave(*inner_); }

  std::unique_ptr<OutboundChannel> Advertise(std::string_view channel, const TypeInfo& type,
                                             OutboundSource& source) override {
    return inner_->Advertise(channel, type, source);
  }
  std::unique_ptr<InboundChannel> Subscribe(std::string_view channel, const TypeInfo& type, const Demand& demand,
                                            InboundSink& sink) override {
    return inner_->Subscribe(channel, type, demand, sink);
  }
  std::vector<PeerInfo> Peers() const override { return inner_->Peers(); }
  TransportStats stats() const override { return inner_->stats(); }
  void Close(int linger_ms) noexcept override { inner_->Close(linger_ms); }
  void AskAgain() override { inner_->AskAgain(); }
  const std::string& place() const noexcept override { return inner_->place(); }
  void AddPeer(const std::string& place) override { gate_.Connect(*inner_, place); }
  void RemovePeer(const std::string& place) override { inner_->RemovePeer(place); }

 private:
  Gate& gate_;
  const std::unique_ptr<Transport> inner_;
};

/// The entry of such a transport. The gate outlives the session.
inline TransportEntry GatedEntry(const std::string& key, const std::string& name, int cost, SessionId session,
                                 Gate& gate) {
  TransportEntry entry{key, name, cost, TransportReach::kHost, {}, true};
  entry.make = [key, session, &gate](TransportEntry::Takes takes, TransportListener& listener, Log& log) {
    ShmOptions options;
    options.session = session;
    options.process = "gated";
    options.place = "hgros-" + key + "-" + session.ToString();
    options.limit_bytes = 1 << 20;
    options.heartbeat = std::chrono::milliseconds(100);
    options.takes = std::move(takes);
    return std::make_unique<GatedTransport>(std::move(options), listener, log, gate);
  };
  return entry;
}

}  // namespace hgros::test
