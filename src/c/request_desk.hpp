#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "c/handles.hpp"
#include "hgros/c/services.h"
#include "hgros/codec/raw_message.hpp"

namespace hgros::c {

class RequestDesk;

// What a request is answered with: one of both.
struct Answer {
  std::optional<Payload> data;
  std::optional<std::string> failure;
};

// The reply, or an exception with the sentence, which the graph passes on to the caller.
Payload PayloadOf(Answer answer);

// Hands the requests of one service to threads of the program, one at a time. The thread of the service waits for each
// answer.
//
// Thread safety: all functions.
// Invariants: the descriptor is readable while request_ is set and in time, and once it has ended.
class RequestDesk final : public Dependent, public std::enable_shared_from_this<RequestDesk> {
 public:
  // Throws Error.
  explicit RequestDesk(std::shared_ptr<Life> life);
  ~RequestDesk() override;

  // For the thread of the service: waits until the program has answered. Throws the failure of the answer, or
  // NotHandled if nobody took the request before its caller gave up, or the service has ended.
  [[nodiscard]] Payload Handle(const RawMessage& request);
  // For threads of the program.
  [[nodiscard]] hgros_status Take(std::int64_t timeout_ns, hgros_message*& request, hgros_reply*& reply);
  // False if it has ended.
  [[nodiscard]] bool Reply(std::uint64_t number, Answer answer);

  [[nodiscard]] int descriptor() const noexcept { return event_; }
  [[nodiscard]] bool in_forked_child() const noexcept { return life_->in_forked_child(); }

  void Stop() noexcept override;
  void End() override {}             // The session ends its services.
  void Leave() noexcept override {}  // Stop() came before.

 private:
  // Under mutex_.
  void SetReadable(bool readable) noexcept;

  const std::shared_ptr<Life> life_;
  const int event_;
  std::mutex mutex_;
  std::condition_variable answered_;
  std::uint64_t number_ = 0;  // Of the last request.
  std::shared_ptr<const RawMessage> request_;
  std::chrono::steady_clock::time_point due_;  // Of request_: later, nobody takes it.
  std::optional<Answer> answer_;
  bool ended_ = false;
  bool readable_ = false;
};

}  // namespace hgros::c

struct hgros_reply {
  std::shared_ptr<hgros::c::RequestDesk> desk;  // Null in a handler.
  std::uint64_t number = 0;                     // Of the request at the desk.
  bool replied = false;
  hgros::c::Answer answer;  // In a handler.
};
