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

#include "hgros/graph/publisher.hpp"
#include "services/call_state.hpp"

namespace hgros {

// The calls of one session that are under way, by number, and one thread that ends those whose time is up; it starts
// with the first call that has a time-out, and wakes for due calls alone.
//
// Thread safety: all functions. Invariants: a call is in the table until it ends; who takes it out ends it, once, and
// not under the table's lock. The thread runs no user code: callbacks go to a node of the graph.
class CallTable {
 public:
  // Number of calls under way at once, including those whose callbacks have not been called yet.
  static constexpr std::size_t kMaxCalls = 65536;

  CallTable() = default;
  CallTable(const CallTable&) = delete;
  CallTable& operator=(const CallTable&) = delete;
  ~CallTable();

  // Numbers the call and puts it in. False if there are too many, or the table is closed.
  [[nodiscard]] bool Begin(const std::shared_ptr<CallState>& call, std::chrono::nanoseconds timeout);
  // False if it had ended.
  bool End(std::uint64_t number, CallEnd end);
  [[nodiscard]] std::shared_ptr<CallState> Find(std::uint64_t number) const;
  void EndAll(const std::function<std::optional<CallEnd>(const CallState&)>& end_of);
  // Ends all, and refuses more.
  void Close();
  [[nodiscard]] bool closed() const;

  // Where callbacks run: a node that calls Answered() for each.
  void SetAnswers(Publisher<AnsweredCall> answers);
  // False while the session shuts down.
  [[nodiscard]] bool Answer(const std::shared_ptr<const AnsweredCall>& answered);
  void Answered() noexcept { answering_.fetch_sub(1, std::memory_order_relaxed); }

 private:
  using Moment = std::chrono::steady_clock::time_point;
  void Loop(const std::stop_token& stop);
  // Under mutex_.
  [[nodiscard]] std::shared_ptr<CallState> Take(std::uint64_t number);

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
