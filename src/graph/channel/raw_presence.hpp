#pragma once

#include <atomic>
#include <memory>
#include <vector>

#include "graph/channel/two_forms.hpp"
#include "graph/nodes/node.hpp"

namespace hgros {

// Whether messages of one channel may be raw. Then its nodes look at each message before they call back, which costs
// time.
//
// Thread safety: messages(), expected() and MayEnd() from any thread; the rest under the channel's lock.
// Invariants: a raw message is counted before expected() is read, and every node expects it before it is delivered.
// End() writes expected_ before it reads the count. So one of the two threads sees the other.
class RawPresence {
 public:
  using Nodes = std::vector<std::shared_ptr<Node>>;

  [[nodiscard]] bool expected() const noexcept { return expected_.load(std::memory_order_seq_cst); }
  // The counter for raw messages that are subscribed to.
  [[nodiscard]] const std::shared_ptr<two_forms::Living>& messages() const noexcept { return messages_; }

  // From now on messages may be raw. `nodes`: those of the channel.
  void Expect(const Nodes& nodes) {
    if (expected()) return;
    for (const std::shared_ptr<Node>& node : nodes) node->ExpectTwoForms();
    expected_.store(true, std::memory_order_seq_cst);
  }
  // Raw nodes have come, or the last one has gone.
  void SetObserved(bool observed) noexcept { observed_.store(observed, std::memory_order_relaxed); }
  // Messages are published raw, or have two types: this never ends.
  void Keep() noexcept { kept_.store(true, std::memory_order_relaxed); }

  // Cheap. False if End() would do nothing.
  [[nodiscard]] bool MayEnd() const noexcept {
    constexpr auto kRelaxed = std::memory_order_relaxed;
    return expected_.load(kRelaxed) && !observed_.load(kRelaxed) && !kept_.load(kRelaxed) &&
           messages_->load(kRelaxed) == 0;
  }
  // When the last raw node has gone, and the last raw message, the other nodes expect none any more.
  void End(const Nodes& nodes) {
    if (!MayEnd()) return;
    expected_.store(false, std::memory_order_seq_cst);
    if (messages_->load(std::memory_order_seq_cst) > 0) {
      expected_.store(true, std::memory_order_seq_cst);
      return;
    }
    for (const std::shared_ptr<Node>& node : nodes) node->ExpectOneForm();
  }

 private:
  std::atomic<bool> expected_{false};
  std::atomic<bool> observed_{false};
  std::atomic<bool> kept_{false};
  const std::shared_ptr<two_forms::Living> messages_ = std::make_shared<two_forms::Living>(0);
};

}  // namespace hgros
