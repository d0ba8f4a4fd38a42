#pragma once

#include <cstdint>
#include <memory>

#include "hgros/base/export.hpp"
#include "hgros/graph/message_info.hpp"

namespace hgros {

class GraphCore;
class Node;

/// A node whose callback only hands messages to another thread of the program, such as one of another language. That
/// thread counts here what becomes of them.
///
/// Thread safety: all functions. They do nothing once the subscription has ended.
class HGROS_EXPORT HandedOver {
 public:
  /// Of the node whose callback the calling thread runs: from now on it counts no runs by itself. Outside callbacks
  /// nothing is counted.
  [[nodiscard]] static HandedOver TakeFromRunningNode();

  /// A message was dropped because newer ones came. The first time is logged.
  void CountDropped() const noexcept;
  /// The program did not take the message: it is of another type, or no message.
  void CountRefused() const noexcept;
  /// The same for a message that the callback on the calling thread has got.
  static void CountRefusedHere() noexcept;
  /// The message was handled from `start_ns` to `end_ns` (CLOCK_MONOTONIC).
  void CountRun(const MessageInfo& info, std::int64_t start_ns, std::int64_t end_ns, bool failed) const noexcept;

 private:
  std::weak_ptr<GraphCore> graph_;
  std::weak_ptr<Node> node_;
};

}  // namespace hgros
