#pragma once

#include <sys/socket.h>
#include <sys/un.h>

#include <atomic>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "hgros/bridge/transport_list.hpp"
#include "hgros/transport/shm_transport.hpp"

namespace hgros::test {

/// The transports behind the gate reach each other only while it is open. One thread opens and closes it, and no
/// transport ends meanwhile.
class Gate {
 public:
  explicit Gate(bool open = false) : open_(open) {}

  void Open() {
    open_ = true;
    for (const auto& [transport, place] : connections()) transport->AddPeer(place);
  }
  /// Cuts all connections of this process, as the death of a peer does.
  void Close() {
    open_ = false;
    for (const auto& [transport, place] : connections()) {
      transport->RemovePeer(place);
      Cut(place);
    }
  }
  /// Connects while the gate is open.
  void Connect(Transport& transport, const std::string& place) {
    {
      const std::scoped_lock lock(mutex_);
      connections_.emplace_back(&transport, place);
    }
    if (open_) transport.AddPeer(place);
  }
  void Disconnect(Transport& transport, const std::string& place) {
    {
      const std::scoped_lock lock(mutex_);
      std::erase(connections_, Connection(&transport, place));
    }
    transport.RemovePeer(place);
  }
  void Leave(Transport& transport) {
    const std::scoped_lock lock(mutex_);
    std::erase_if(connections_, [&](const auto& one) { return one.first == &transport; });
  }

 private:
  using Connection = std::pair<Transport*, std::string>;
  [[nodiscard]] std::vector<Connection> connections() {
    const std::scoped_lock lock(mutex_);
    return connections_;
  }
  static void Cut(const std::string& place) {
    for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
      const int descriptor = std::stoi(entry.path().filename().string());
      sockaddr_un address{};
      socklen_t size = sizeof address;
      if (getpeername(descriptor, reinterpret_cast<sockaddr*>(&address), &size) != 0) continue;
      if (address.sun_family != AF_UNIX || size <= offsetof(sockaddr_un, sun_path)) continue;
      const std::string_view name(address.sun_path, size - offsetof(sockaddr_un, sun_path));
      if (name.find(place) != std::string_view::npos) shutdown(descriptor, SHUT_RDWR);
    }
  }

  std::mutex mutex_;
  std::atomic<bool> open_;
  std::vector<Connection> connections_;
};

/// A transport that exists only in tests. The bridge sees only the interface of Transport. Its sessions connect in
/// memory at its own places, while the gate is open.
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
  void Close(int linger_ms, int at_most_ms) noexcept override { inner_->Close(linger_ms, at_most_ms); }
  void AskAgain() override { inner_->AskAgain(); }
  const std::string& place() const noexcept override { return inner_->place(); }
  void AddPeer(const std::string& place) override { gate_.Connect(*inner_, place); }
  void RemovePeer(const std::string& place) override { gate_.Disconnect(*inner_, place); }

 private:
  Gate& gate_;
  const std::unique_ptr<Transport> inner_;
};

inline ShmOptions GatedOptions(SessionId session, std::string place) {
  ShmOptions options;
  options.session = session;
  options.process = "gated";
  options.place = std::move(place);
  options.limit_bytes = 1 << 20;
  options.heartbeat = std::chrono::milliseconds(100);
  return options;
}

/// The entry of such a transport. The gate must outlive the session.
inline TransportEntry GatedEntry(const std::string& key, const std::string& name, int cost, SessionId session,
                                 Gate& gate) {
  TransportEntry entry{key, name, cost, TransportReach::kHost, {}, true};
  entry.make = [key, session, &gate](TransportEntry::Takes takes, TransportListener& listener, Log& log) {
    ShmOptions options = GatedOptions(session, "hgros-" + key + "-" + session.ToString());
    options.takes = std::move(takes);
    return std::make_unique<GatedTransport>(std::move(options), listener, log, gate);
  };
  return entry;
}

}  // namespace hgros::test
