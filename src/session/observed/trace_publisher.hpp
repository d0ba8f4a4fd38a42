#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "hgros/bridge/channel_outlet.hpp"
#include "hgros/graph/trace_recorder.hpp"

namespace hgros {

class Trace;

// Writes the events into the message, which has none yet.
void Fill(Trace& message, TraceRecorder::Batch&& batch);

// Publishes what the nodes of this session do while another session subscribes to that. Otherwise nothing is recorded,
// and it costs only an entry in the session's announcement.
//
// Thread safety: all functions from any thread.
class TracePublisher {
 public:
  // Runs an errand after the delay, never inside the call, and never after this object has ended.
  using Later = std::function<void(std::chrono::nanoseconds, std::function<void()>)>;

  TracePublisher(std::string name, TraceRecorder& recorder, MessageId publisher, const std::shared_ptr<Log>& log,
                 const std::shared_ptr<const HostClocks>& clocks, Later later);

  [[nodiscard]] const std::shared_ptr<ChannelOutlet>& outlet() const noexcept { return outlet_; }

 private:
  void Plan(std::chrono::nanoseconds delay) noexcept;
  void Tell();

  const std::string name_;
  TraceRecorder& recorder_;
  const SessionId session_;
  const std::shared_ptr<const HostClocks> clocks_;
  const Later later_;
  std::atomic<bool> planned_{false};
  std::shared_ptr<ChannelOutlet> outlet_;
};

}  // namespace hgros
