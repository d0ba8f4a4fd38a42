#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "transport/peer_registry.hpp"
#include "transport/shm/offered_channels.hpp"
#include "transport/shm/pair/destinations.hpp"
#include "transport/shm/pair/handshake.hpp"
#include "transport/shm/pair/obstacles.hpp"
#include "transport/shm/pair/pair_table.hpp"
#include "transport/shm/pair/socket_thread.hpp"
#include "transport/shm/shm_publisher.hpp"
#include "transport/shm/shm_session.hpp"
#include "transport/shm/wanted_channels.hpp"

namespace hgros::shm {

/// The life of pairs: accepts and makes connections, reads the frames of peers and passes them on, and notices when a
/// peer has gone.
///
/// Thread safety: none; the socket thread, and Close() after that has ended. Holds no mutex itself.
/// Invariants: a pair is in the table from its connection until its socket has ended and the peer has released all
/// that it held of ours; only then is its number used again. A pair that ends (`ending`) is read to its end
/// (`finished`), then forgotten.
class Connections final : public SocketThread::Handler {
 public:
  /// The parts that work on a pair.
  struct Parts {
    PairTable& pairs;
    SocketThread& sockets;
    ShmPublisher& publisher;
    OfferedChannels& offered;
    WantedChannels& wanted;
    SessionBell& bell;
    Destinations& destinations;
    Obstacles& obstacles;
    PeerRegistry& registry;
  };
  /// Throws Error if another session listens at our place.
  Connections(ShmSession& session, const Parts& parts);

  SteadyTime DoWhatIsDue(SteadyTime now) override;
  void OnReady(SocketThread::Source source, std::uint32_t number) override;
  void OnLie(const std::shared_ptr<Pair>& liar, const std::string& what) override;
  void OnAllRead(const std::shared_ptr<Pair>& pair) override;

  /// Sends `bye` to all peers and forgets all pairs. `nobody_listens` ends when no mutex is held.
  void Close(Actions& nobody_listens);

 private:
  using LinkEnd = ShmPublisher::LinkEnd;

  // connections.cpp: the pair's socket, its end, and periodic work.
  void Connect(SteadyTime now);
  void Accept();
  std::shared_ptr<Pair> AddPair(Handle connection, bool by_us, const std::string& place);
  void Refuse(const std::string& why, const std::string& place);
  void EndPair(const std::shared_ptr<Pair>& pair, const std::string& reason, bool say_bye,
               LinkEnd links = LinkEnd::kPairLost);
  void OnProcessEnd(const std::shared_ptr<Pair>& pair);
  void ForgetPair(const std::shared_ptr<Pair>& pair);
  void Beat(SteadyTime now);

  // connection_frames.cpp: frames that are read from the socket.
  void Read(const std::shared_ptr<Pair>& pair);
  void OnFrame(const std::shared_ptr<Pair>& pair, PairSocket::Frame& frame);
  void OnHello(const std::shared_ptr<Pair>& pair, PairSocket::Frame& frame);
  void Follow(const std::shared_ptr<Pair>& pair, const Handshake::Outcome& outcome);
  void BeginPair(const std::shared_ptr<Pair>& pair);
  void OnSegment(Pair& pair, std::uint32_t segment, PairSocket::Frame& frame);

  ShmSession& session_;
  PairTable& pairs_;
  SocketThread& sockets_;
  ShmPublisher& publisher_;
  OfferedChannels& offered_;
  WantedChannels& wanted_;
  SessionBell& bell_;
  Destinations& destinations_;
  Obstacles& obstacles_;
  PeerRegistry& registry_;
  Handshake handshake_;
  Handle listening_;
  bool listens_ = true;  // False while no file descriptors are left; true again from the next heartbeat.
  SteadyTime next_beat_;
};

}  // namespace hgros::shm
