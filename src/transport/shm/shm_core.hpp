#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hgros/transport/shm_transport.hpp"
#include "transport/peer_registry.hpp"
#include "transport/shm/offered_channels.hpp"
#include "transport/shm/pair/connections.hpp"
#include "transport/shm/pair/destinations.hpp"
#include "transport/shm/pair/pair_table.hpp"
#include "transport/shm/pair/socket_thread.hpp"
#include "transport/shm/shm_publisher.hpp"
#include "transport/shm/shm_receiver.hpp"
#include "transport/shm/shm_session.hpp"
#include "transport/shm/wanted_channels.hpp"

namespace hgros::shm {

/// The parts of one transport, joined. Shared by the transport and its channels, so that these may outlive it.
///
/// Thread safety: all functions, except that Start() comes first. Has no mutex of its own. Order of the parts' locks:
/// OfferedChannels, ShmPublisher, then leaves; WantedChannels, a pair's inbox. Calls into the session are made without
/// a lock, on the socket thread, except for OnRoom, OnCut, Accept and Run.
class ShmCore {
 public:
  ShmCore(ShmOptions options, TransportListener& listener, Log& log);
  ~ShmCore();

  void Start();
  void Close(int linger_ms) noexcept;

  void AddPeer(const std::string& place);
  void RemovePeer(const std::string& place) { destinations_.Remove(place); }
  void AskAgain() { wanted_.AskPairs(); }
  [[nodiscard]] std::string Obstacle(SessionId peer, const std::string& place) const {
    return obstacles_.Find(place, peer);
  }
  [[nodiscard]] bool Asks(const InboundCore& core, SessionId publisher) const { return wanted_.Asks(core, publisher); }

  void Offer(const std::shared_ptr<OutChannel>& core) { offered_.Offer(core); }
  void Withdraw(const std::shared_ptr<OutChannel>& core) { offered_.Withdraw(core); }
  void Want(const std::shared_ptr<InboundCore>& core) { wanted_.Want(core); }
  void Unwant(const std::shared_ptr<InboundCore>& core) { wanted_.Unwant(core); }
  void ChangeDemand(const std::shared_ptr<InboundCore>& core) { wanted_.ChangeDemand(core); }

  [[nodiscard]] PublishStatus Reserve(OutChannel& channel) { return publisher_.Reserve(channel); }
  void Cancel(const std::shared_ptr<OutChannel>& core) { publisher_.Cancel(core); }
  [[nodiscard]] std::size_t Unfinished(const OutChannel& channel) { return publisher_.Unfinished(channel); }
  void Commit(const std::shared_ptr<OutChannel>& core, const PacketHead& head, const Payload& data) {
    publisher_.Commit(core, head, data);
  }
  [[nodiscard]] std::optional<Block> Loan(std::size_t size_bytes) { return publisher_.Loan(size_bytes); }
  [[nodiscard]] bool Holds(Bytes bytes) const { return publisher_.pool().Find(bytes).has_value(); }
  [[nodiscard]] bool HasMemoryFor(std::size_t size_bytes, bool written) const {
    return publisher_.pool().HasRoomApart(size_bytes, written ? BlockPool::kCopiesReceived : BlockPool::kCopiesWritten);
  }
  void Receive(const Visit& visit) noexcept { receiver_.Receive(visit); }
  [[nodiscard]] bool ReceiveHere(const Visit& visit) noexcept { return receiver_.ReceiveHere(visit); }
  void WakeReceiver() noexcept { receiver_.WakeReceiver(); }

  [[nodiscard]] ShmUsage usage() const;
  [[nodiscard]] TransportStats stats() const;
  [[nodiscard]] std::vector<PeerInfo> Peers() const { return registry_.List(); }
  [[nodiscard]] const ShmOptions& options() const noexcept { return session_.options; }
  [[nodiscard]] bool IsChild() const noexcept { return session_.fork->IsChild(); }

 private:
  ShmSession session_;
  PeerRegistry registry_;
  PairTable pairs_;
  Destinations destinations_;
  Obstacles obstacles_;
  SocketThread sockets_;
  ShmPublisher publisher_;
  OfferedChannels offered_;
  WantedChannels wanted_;
  ShmReceiver receiver_;
  Connections connections_;
};

}  // namespace hgros::shm
