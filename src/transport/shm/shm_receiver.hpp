#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "transport/leader_pool.hpp"
#include "transport/shm/memory/bell.hpp"
#include "transport/shm/pair/pair_table.hpp"
#include "transport/shm/pair/socket_thread.hpp"
#include "transport/shm/shm_publisher.hpp"
#include "transport/shm/shm_session.hpp"
#include "transport/shm/wanted_channels.hpp"

namespace hgros::shm {

/// The threads that wait for this session's bell, and read from the pairs that have rung it.
///
/// Thread safety: all functions; of the Input's, Lead() is called by one thread at a time, as LeaderPool says.
/// Invariants: a ring is never lost: if a pair is not read to its end, it is rung again before the thread does
/// something else. Messages of one peer are delivered in the order of its lane.
class ShmReceiver final : public LeaderPool::Input {
 public:
  /// Throws Error if there is no shared memory.
  ShmReceiver(ShmSession& session, PairTable& pairs, SocketThread& sockets, ShmPublisher& publisher,
              WantedChannels& wanted);

  void Start() { threads_.Start(); }
  void Stop() noexcept { threads_.Stop(); }
  /// Reads on the calling thread.
  void Receive(const Visit& visit) noexcept { threads_.Receive(visit); }
  [[nodiscard]] bool ReceiveHere(const Visit& visit) noexcept { return threads_.ReceiveHere(visit); }
  void WakeReceiver() noexcept { threads_.WakeReceiver(); }
  [[nodiscard]] SessionBell& bell() noexcept { return bell_; }

  void Wait() noexcept override;
  LeaderPool::Task Lead() noexcept override;
  void Wake() noexcept override;
  bool BeginAsking() noexcept override { return bell_.BeginLooking(); }
  bool MayRead() const noexcept override { return bell_.HasRung(); }
  void EndAsking() noexcept override { bell_.EndLooking(); }
  bool CanWaitFirst() const noexcept override { return bell_.sleeps_at_once(); }
  bool WaitFirst(const std::function<bool()>& ends, std::chrono::steady_clock::time_point until) noexcept override {
    return bell_.WaitFirst(ends, until);
  }
  void WakeFirst() noexcept override { bell_.WakeFirst(); }

 private:
  [[nodiscard]] LeaderPool::Task ReadFrom(const std::shared_ptr<Pair>& pair);

  ShmSession& session_;
  PairTable& pairs_;
  SocketThread& sockets_;
  ShmPublisher& publisher_;
  WantedChannels& wanted_;
  SessionBell bell_;

  // The reading thread.
  std::vector<std::uint32_t> to_read_;
  std::uint32_t last_read_ = 0;

  LeaderPool threads_{*this};
};

}  // namespace hgros::shm
