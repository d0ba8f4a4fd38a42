#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include <foxglove/FrameTransforms.pb.h>

#include "hgros/clock/timer_queue.hpp"
#include "hgros/tf/transforms.hpp"
#include "tf/edge_setter.hpp"

namespace hgros::tf {

/// Sends a session's transforms. A burst becomes one message.
///
/// Thread safety: all functions except construction and destruction. Nothing is published under the lock, because
/// subscribers may set transforms themselves.
class TransformSender {
 public:
  TransformSender(Session& session, Duration batch);
  TransformSender(const TransformSender&) = delete;
  TransformSender& operator=(const TransformSender&) = delete;
  ~TransformSender();

  /// Announces the channel at the first call. Throws Error if it is used with another type.
  void OpenMoving();
  void OpenStatic();
  void SendMoving(std::span<const StampedEdge* const> edges);
  /// `setter`: who sets them; null if no component does. They wait while it withholds its edges.
  void SendStatic(std::span<const StampedEdge* const> edges, const std::shared_ptr<EdgeSetter>& setter);
  void Flush();

  void SetConstructing(EdgeSetter& setter, bool constructing);
  /// The static edges that the setter was the last one to set are not sent any more, nor those that it sets from now
  /// on. Returns the former.
  std::vector<StampedEdge> Withhold(EdgeSetter& setter);
  [[nodiscard]] bool Withholds(const EdgeSetter& setter) const;
  [[nodiscard]] std::vector<EdgeSetter::Withheld> Withheld(const EdgeSetter& setter) const;
  /// Sends `edges`, those that are left of the first `count` that were withheld, and withholds nothing more. Does
  /// nothing and returns false if there are more by now.
  bool Release(const std::shared_ptr<EdgeSetter>& setter, std::size_t count,
               std::span<const EdgeSetter::Withheld> edges);

  /// True if this object has sent the message.
  [[nodiscard]] bool IsOwn(const foxglove::FrameTransforms& message) const;

  [[nodiscard]] std::uint64_t sent_messages() const noexcept { return sent_messages_; }
  [[nodiscard]] std::uint64_t sent_transforms() const noexcept { return sent_transforms_; }
  [[nodiscard]] std::uint64_t unsent_transforms() const noexcept { return unsent_transforms_; }

 private:
  using Message = foxglove::FrameTransforms;
  // One channel. The rest is guarded by mutex_.
  struct Lane {
    Publisher<Message> publisher;
    std::once_flag opened;
    Message waiting;        // In the static lane: all edges.
    bool changed = false;   // `waiting` has something that was not sent yet.
    bool sending = false;   // One thread at a time, so that messages keep their order.
    bool armed = false;     // A timer is set and will send.
    bool keeps = false;     // Sent transforms stay in `waiting`.
    Time quiet_until = {};  // Transforms before this time wait for it.
    Timer timer;
  };
  struct StaticPlace {
    int index = 0;  // In the waiting message of static_.
    std::shared_ptr<EdgeSetter> setter;
    bool by_constructor = false;
  };
  // The messages that have not ended yet. They may outlive the sender.
  struct Sent {
    std::mutex mutex;
    std::set<const Message*> messages;
  };

  void Open(Lane& lane, std::string_view channel, PublishOptions options);
  // Called with `lock` held; it may be released on return.
  void Arm(Lane& lane, Time now, std::unique_lock<std::mutex>& lock);
  void Touch(Lane& lane, std::unique_lock<std::mutex>& lock);
  void Send(Lane& lane, std::unique_lock<std::mutex>& lock);
  void OnTimer(Lane& lane);
  [[nodiscard]] std::shared_ptr<const Message> MakeMessage(Lane& lane) const;
  void PutStatic(const StampedEdge& edge, const std::shared_ptr<EdgeSetter>& setter, bool by_constructor);

  Session& session_;
  const Duration batch_;
  const std::shared_ptr<Clock> clock_;
  const std::shared_ptr<Sent> sent_ = std::make_shared<Sent>();
  std::atomic<std::uint64_t> sent_messages_{0};
  std::atomic<std::uint64_t> sent_transforms_{0};
  std::atomic<std::uint64_t> unsent_transforms_{0};

  mutable std::mutex mutex_;
  bool closing_ = false;                                        // No further timer is made.
  std::unordered_map<std::string, StaticPlace> static_places_;  // By child.
  std::optional<TimerQueue> timers_;                            // Made at the first burst.
  Lane moving_;
  Lane static_;
};

}  // namespace hgros::tf
