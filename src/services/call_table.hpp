#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <thread>
#include <unordered_map>
#include <utility>
#include <vector>

#include "hgros/base/fork_guard.hpp"
#include "hgros/base/log.hpp"
#include "hgros/graph/publisher.hpp"
#include "services/call_state.hpp"

namespace hgros {

// The pending calls of one session, by number, and one thread that ends those whose timeout has expired. The thread
// starts with the first call that has a timeout, and wakes only for due calls.
//
// Thread safety: all functions. Invariants: a call is in the table until it ends. The thread that removes it ends it,
// once, outside the table's lock. The table's own thread runs no user code but inline callbacks: others go to a node of
// the graph.
class CallTable {
 public:
  // Maximum number of pending calls, including ended ones whose callbacks have not run yet.
  static constexpr std::size_t kMaxCalls = 65536;

  CallTable(std::shared_ptr<const ForkGuard> fork, std::shared_ptr<Log> log)
      : fork_(std::move(fork)), log_(std::move(log)) {}
  CallTable(const CallTable&) = delete;
  CallTable& operator=(const CallTable&) = delete;
  ~CallTable();

  // Numbers the call and adds it. False if there are too many calls, or the table is closed.
  [[nodiscard]] bool Begin(const std::shared_ptr<CallState>& call, std::chrono::nanoseconds timeout);
  // False if the call had already ended.
  bool End(std::uint64_t number, CallEnd end);
  [[nodiscard]] std::shared_ptr<CallState> Find(std::uint64_t number) const;
  void EndAll(const std::function<std::optional<CallEnd>(const CallState&)>& end_of);
  // Ends all calls and refuses new ones.
  void Close();
  [[nodiscard]] bool closed() const;
  // Then no call may be ended or waited for.
  [[nodiscard]] bool in_forked_child() const noexcept { return fork_->IsChild(); }

  // Callbacks run on the node behind `answers`, which calls Answered() for each. While the session shuts down they run
  // here: on the thread that closes it, or on the caller's thread if its call was refused.
  void SetAnswers(Publisher<AnsweredCall> answers);
  void Answer(const std::shared_ptr<const AnsweredCall>& answered);
  // What the callback throws is logged with the service: the node behind `answers` does not know it.
  void RunCallback(const AnsweredCall& answered) noexcept;
  void Answered() noexcept { answering_.fetch_sub(1, std::memory_order_relaxed); }

 private:
  using Moment = std::chrono::steady_clock::time_point;
  void Loop(const std::stop_token& stop);
  // Under mutex_.
  [[nodiscard]] std::shared_ptr<CallState> Remove(std::uint64_t number);

  const std::shared_ptr<const ForkGuard> fork_;
  const std::shared_ptr<Log> log_;
  mutable std::mutex mutex_;
  bool closed_ = false;
  std::uint64_t last_number_ = 0;
  std::unordered_map<std::uint64_t, std::shared_ptr<CallState>> calls_;
  std::set<std::pair<Moment, std::uint64_t>> due_;
  Moment wakes_at_ = Moment::max();
  std::condition_variable_any changed_;
  Publisher<AnsweredCall> answers_;
  std::atomic<std::size_t> answering_{0};
  std::jthread thread_;
};

}  // namespace hgros
