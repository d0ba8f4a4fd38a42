#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "hgros/graph/message_info.hpp"
#include "hgros/internal/codec/packet.hpp"

namespace hgros {

class DataGraph;

// Records what the nodes of a graph do while somebody watches: each publish and each callback.
//
// Thread safety: all functions. Recording takes a mutex for a moment; while nobody watches, on() is all that is called.
class TraceRecorder {
 public:
  static constexpr std::size_t kMostEvents = 16384;  // Until the next Take(); the rest is counted.

  struct Publish {
    std::uint32_t channel = 0;  // This and `node`: indexes in Batch::names.
    std::uint32_t node = 0;     // In whose callback it was; names[0] is empty: in none.
    std::uint32_t thread = 0;   // The kernel's number.
    std::uint64_t message = 0;  // Its key.
    std::uint64_t cause = 0;
    std::int64_t at_ns = 0;  // CLOCK_MONOTONIC, as all times except `sent_ns`.
  };
  struct Run {
    std::uint32_t channel = 0;
    std::uint32_t node = 0;
    std::uint32_t thread = 0;
    std::uint64_t message = 0;
    std::uint64_t publisher = 0;   // The session.
    std::int64_t sent_ns = 0;      // The publisher's wall clock when a transport got the message; 0: a local one.
    std::int64_t received_ns = 0;  // Local messages: published.
    std::int64_t start_ns = 0;
    std::int64_t end_ns = 0;
  };
  struct Batch {
    std::vector<std::string> names;
    std::vector<Publish> publishes;
    std::vector<Run> runs;
    std::uint64_t lost = 0;
  };

  // The recorder of a graph.
  [[nodiscard]] static TraceRecorder& Of(DataGraph& graph) noexcept;
  // Records publishes of messages that the graph does not number, such as calls; for OutletEvents::on_numbered.
  [[nodiscard]] static std::function<void(const PacketHead&)> OfOutlets(DataGraph& graph);

  [[nodiscard]] bool on() const noexcept { return on_.load(std::memory_order_relaxed); }
  // Turning it off forgets what was recorded.
  void SetOn(bool on);
  void AddPublish(std::string_view channel, std::string_view node, const MessageInfo& info) noexcept;
  void AddRun(std::string_view channel, std::string_view node, const MessageInfo& info, std::int64_t start_ns,
              std::int64_t end_ns) noexcept;
  // Everything since the last call.
  [[nodiscard]] Batch Take();

 private:
  [[nodiscard]] std::uint32_t IndexOf(std::string_view name);
  template <class Event, class Fill>
  void Add(std::vector<Event>& events, const Fill& fill) noexcept;

  std::atomic<bool> on_{false};
  std::mutex mutex_;  // Guards all below.
  Batch batch_;
  std::unordered_map<std::string, std::uint32_t> indexes_;
};

}  // namespace hgros
