#pragma once

#include <array>
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "hgros/base/fork_guard.hpp"
#include "hgros/transport/shm_transport.hpp"
#include "transport/actions.hpp"
#include "transport/leader_pool.hpp"
#include "transport/peer_registry.hpp"
#include "transport/shm/pair.hpp"
#include "transport/waker.hpp"

namespace hgros::shm {

/// The pairs of one transport, the threads that read from them, and a thread of its own that minds the sockets. Shared
/// by the transport and its channels, so that these may outlive it.
///
/// Thread safety: all functions. Order of locks: mutex_, a pair's in_mutex.
/// Invariants: a pair is in pairs_ from its connection until its socket has ended and all that the peer held of ours is
/// let go of; its number is used again only then. Calls into the session are made without a lock, by the core's own
/// thread, but for OnRoom, Accept and Run.
class ShmCore : public LeaderPool::Input {
 public:
  ShmCore(ShmOptions options, TransportListener& listener, Log& log);
  ~ShmCore() override;

  void Start();
  void Close(int linger_ms) noexcept;

  void AddPeer(const std::string& place);
  void RemovePeer(const std::string& place);
  void AskAgain();

  void Offer(const std::shared_ptr<OutChannel>& core);
  void Withdraw(const std::shared_ptr<OutChannel>& core);
  void Want(const std::shared_ptr<InboundCore>& core);
  void Unwant(const std::shared_ptr<InboundCore>& core);
  void ChangeDemand(const std::shared_ptr<InboundCore>& core);

  [[nodiscard]] PublishStatus Reserve(OutChannel& channel);
  void Cancel(const std::shared_ptr<OutChannel>& core);
  void Commit(const std::shared_ptr<OutChannel>& core, const PacketHead& head, const Payload& data);

  [[nodiscard]] std::optional<Block> Loan(std::size_t size_bytes);
  [[nodiscard]] ShmUsage usage() const;
  [[nodiscard]] TransportStats stats() const;
  [[nodiscard]] std::vector<PeerInfo> Peers() const { return registry_.List(); }
  [[nodiscard]] const ShmOptions& options() const noexcept { return options_; }
  [[nodiscard]] bool IsChild() const noexcept { return fork_->IsChild(); }

  void Wait() noexcept override;
  LeaderPool::Task Lead() noexcept override;
  void Wake() noexcept override;
  bool BeginAsking() noexcept override { return bell_.BeginLooking(); }
  bool MayRead() const noexcept override { return bell_.HasRung(); }
  void EndAsking() noexcept override { bell_.EndLooking(); }
  void Receive(const Visit& visit) noexcept { pool_of_readers_.Receive(visit); }

 private:
  struct Destination {
    std::string place;
    SteadyTime next_try{};
    std::chrono::milliseconds pause{0};
    std::weak_ptr<Pair> pair;
    SessionId session;  // Who was found there.
    [[nodiscard]] bool Connected() const {
      const auto known = pair.lock();
      return known && !known->ending;  // One that has ended may hold messages for a long time.
    }
  };

  // What epoll says of what is no pair's socket.
  static constexpr std::uint64_t kListening = 1ULL << 32;
  static constexpr std::uint64_t kWoken = 1ULL << 33;
  static constexpr std::uint64_t kProcess = 1ULL << 34;  ///< With a pair's number.

  // shm_core.cpp: wiring, and the core's own thread.
  void Mind(const std::stop_token& stop);
  [[nodiscard]] SteadyTime NextDeadline() const;
  void Turn(std::uint64_t mark);
  [[nodiscard]] bool Watch(int fd, std::uint64_t mark, std::uint32_t events) noexcept;
  void Post(std::function<void()> action);
  /// For as long as the pair is known: its number may be another's by then.
  void PostFor(Pair& pair, std::function<void(const std::shared_ptr<Pair>&)> action);
  void Post(Actions&& actions);
  void WaitUntilSent(int linger_ms);
  void CountRound();
  [[nodiscard]] std::vector<std::shared_ptr<Pair>> Pairs() const;
  [[nodiscard]] std::shared_ptr<Pair> PairAt(std::uint32_t number) const;

  // pair_life.cpp: how pairs begin and end.
  void Tick(SteadyTime now);
  void TryDestinations(SteadyTime now);
  void AcceptPairs();
  [[nodiscard]] std::shared_ptr<Pair> AddPair(Handle connection, bool by_us, const std::string& place);
  void Read(const std::shared_ptr<Pair>& pair);
  // How a link to a subscriber ends: as that asks; so that nobody gets the rest; or with its pair, while it may live
  // on.
  enum class LinkEnd { kAsked, kForGood, kPairLost };
  void EndPair(const std::shared_ptr<Pair>& pair, const std::string& reason, bool say_bye,
               LinkEnd links = LinkEnd::kPairLost);
  void OnProcessEnd(const std::shared_ptr<Pair>& pair);
  void FinishPair(const std::shared_ptr<Pair>& pair);
  void ForgetPair(const std::shared_ptr<Pair>& pair);

  // publisher_control.cpp: what subscribing peers say.
  void OnWish(Pair& pair, const wire::Wish& wish);
  void OnUnwish(Pair& pair, const wire::Unwish& unwish);
  void Activate(Pair& pair, PeerWish& wish, Actions& actions);
  void SayGranted(Pair& pair, const OutLink& link, const std::string& descriptor_set);
  void StartLink(const std::shared_ptr<OutChannel>& core, Pair& pair, std::uint64_t link);
  void RemoveLink(PeerWish& wish, LinkEnd why, Actions& actions);
  // What the link's subscriber has not confirmed is left to the source; false if that does not take it. Under mutex_.
  [[nodiscard]] static bool KeepForLater(const OutLink& link);
  [[nodiscard]] static bool KeepForLater(OutChannel& core, SessionId subscriber, const Demand& demand,
                                         std::vector<OutboundMessage>&& messages);

  // subscriber_control.cpp: what publishing peers say.
  void OnFrame(const std::shared_ptr<Pair>& pair, PairSocket::Frame& frame);
  void OnHello(const std::shared_ptr<Pair>& pair, PairSocket::Frame& frame);
  [[nodiscard]] std::string OpenPages(Pair& pair, const wire::PairHello& hello, PairSocket::Frame& frame);
  [[nodiscard]] std::string WhyNot(Pair& pair);
  void OnWelcome(const std::shared_ptr<Pair>& pair);
  void BeginPair(const std::shared_ptr<Pair>& pair);
  void OnGranted(Pair& pair, const wire::Granted& granted);
  void OnMisfit(Pair& pair, const wire::Misfit& misfit);
  void OnEnded(Pair& pair, const wire::Ended& ended);
  void EndLink(Pair& pair, std::uint64_t link);
  void OnSegment(Pair& pair, std::uint32_t segment, PairSocket::Frame& frame);
  void AskForAll(Pair& pair);
  [[nodiscard]] bool Takes(const Pair& pair, const std::string& channel) const;
  void OnPayload(Pair& pair, wire::PayloadApart& payload);
  void OnTooLarge(Pair& pair, const wire::TooLarge& said);
  void Ask(Pair& pair, const std::shared_ptr<InboundCore>& core);
  void SayWish(Pair& pair, InLink& link);
  void ForgetWish(Pair& pair, const std::string& channel, std::string_view mismatch, Actions& actions);
  void TellMismatch(Pair& pair, const std::string& channel, const std::string& what);

  // shm_publish.cpp
  [[nodiscard]] std::shared_ptr<const ShmMessage> Pack(const PacketHead& head, const Payload& data);
  [[nodiscard]] bool Accepts(OutLink& link, const ShmMessage& message, Actions& actions);
  static void SayTooLarge(OutLink& link);
  void Drain(OutLink& link, Leavings& leavings, Bells& bells);
  [[nodiscard]] bool Send(OutLink& link, Leavings& leavings);
  void Write(OutLink& link, const PendingMessage& message);
  void ReadCredit(OutLink& link, Leavings& leavings);
  void Collect(Pair& pair, Leavings& leavings);
  [[nodiscard]] static bool HasRoom(const OutChannel& channel);
  [[nodiscard]] bool FindRoom(const OutChannel& channel, Leavings& leavings);
  static void CountWaiting(OutLink& link);
  void Pump(Pair& pair);
  void RemoveSegments(Pair& pair, const std::vector<std::uint32_t>& gone);

  // shm_receive.cpp
  [[nodiscard]] LeaderPool::Task Serve(const std::shared_ptr<Pair>& pair);
  enum class Step { kMessage, kSkipped, kNothing, kNotYet, kLie };
  [[nodiscard]] Step Next(Pair& pair, std::shared_ptr<InLink>& link, InboundMessage& message, const char*& lie);
  [[nodiscard]] static Payload PayloadOf(const std::shared_ptr<Slip>& slip, const Descriptor& descriptor,
                                         std::shared_ptr<Mapping> segment);
  // The pair ends: its peer says what cannot be.
  void Distrust(Pair& pair, const std::string& what);

  const ShmOptions options_;
  const SessionFacts self_;
  TransportListener& listener_;
  Log& log_;
  const std::shared_ptr<const ForkGuard> fork_ = std::make_shared<const ForkGuard>();
  PeerRegistry registry_;
  Bell bell_;
  const std::shared_ptr<BlockPool> pool_;
  std::array<std::atomic<std::uint64_t>, kPacketFaultCount> faults_{};
  std::atomic<std::uint64_t> repeats_{0};
  std::atomic<std::uint64_t> sent_apart_{0};
  std::atomic<bool> closing_{false};

  mutable std::mutex mutex_;
  std::map<std::string, std::shared_ptr<OutChannel>, std::less<>> channels_;  // Offered.
  std::map<std::string, std::shared_ptr<InboundCore>, std::less<>> inbound_;
  std::list<Destination> destinations_;
  bool closed_ = false;

  mutable std::mutex pairs_mutex_;  // Taken after mutex_, alone otherwise.
  std::map<std::uint32_t, std::shared_ptr<Pair>> pairs_;

  // The core's own thread.
  Handle listening_;
  Handle epoll_;
  Waker waker_;
  SteadyTime next_tick_;
  bool listens_ = true;  // Until there are no descriptors left; then again at the next tick.
  std::mutex posted_mutex_;
  Actions posted_;

  // The reading thread.
  std::vector<std::uint32_t> to_serve_;
  std::uint32_t last_served_ = 0;

  std::mutex sent_mutex_;
  std::condition_variable sent_;
  std::uint64_t rounds_ = 0;

  LeaderPool pool_of_readers_{*this};
  std::jthread minder_;
};

}  // namespace hgros::shm
