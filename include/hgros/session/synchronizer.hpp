#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "hgros/codec/bulk.hpp"
#include "hgros/codec/type_info.hpp"
#include "hgros/graph/invoke.hpp"
#include "hgros/graph/node_options.hpp"
#include "hgros/graph/subscription.hpp"
#include "hgros/session/stamp_matcher.hpp"

namespace hgros {

/// The time of a google.protobuf.Timestamp, limited to 285 years before and after 1970.
template <class T>
requires requires(const T& stamp) { stamp.seconds() + stamp.nanos(); }
[[nodiscard]] Time StampOf(const T& stamp) {
  constexpr std::int64_t kMostSeconds = 9'000'000'000;
  return {std::clamp<std::int64_t>(stamp.seconds(), -kMostSeconds, kMostSeconds) * 1'000'000'000 + stamp.nanos()};
}
/// The stamp of a message: its field `timestamp`. For a type without one, declare a StampOf in the type's namespace.
template <class T>
requires requires(const T& message) { message.timestamp().seconds(); }
[[nodiscard]] Time StampOf(const T& message) { return StampOf(message.timestamp()); }
template <class T>
[[nodiscard]] Time StampOf(const Bulk<T>& message) {
  return StampOf(message.head());
}

/// Subscribes to several channels, and calls one callback with each set of messages whose stamps match; see
/// StampMatcher.
///
///     hgros::Synchronizer<foxglove::RawImage, foxglove::LaserScan> both(
///         session, {"camera", "scan"}, {.tolerance = 20ms},
///         [](const std::shared_ptr<const foxglove::RawImage>& image,
///            const std::shared_ptr<const foxglove::LaserScan>& scan) { ... });
///
/// Threading: the callback is called by a worker, one call at a time. counts() is thread-safe.
/// Ordering:  sets in the order of their stamps.
/// Lifetime:  the subscriptions to a Session end with this object, those of a component with the component. At
///            most `depth` messages of each channel wait. They have been handled, so a component that moves or starts
///            again loses them.
template <class... Ts>
class Synchronizer {
 public:
  using Callback = std::function<void(const std::shared_ptr<const Ts>&... messages)>;
  using ChannelNames = std::array<std::string, sizeof...(Ts)>;

  /// `from` is a Session, or the Context of a component. `nodes` is for the node of each channel; with a name, they are
  /// called "NAME/CHANNEL". Errors: as FromAny and StampMatcher.
  template <class From>
  Synchronizer(From& from, const ChannelNames& channels, MatchOptions options, Callback callback,
               NodeOptions nodes = {}, const CallSite& where = CallSite::Current())
      : matching_(std::make_shared<Matching>(options, std::move(callback))) {
    Subscribe(from, channels, nodes, where, std::index_sequence_for<Ts...>{});
  }

  /// Those of the channel at this place.
  [[nodiscard]] MatchCounts counts(std::size_t channel) const {
    const std::scoped_lock lock(matching_->mutex);
    return matching_->matcher.counts(channel);
  }

 private:
  using Matcher = StampMatcher<AnyMessage>;

  struct Matching {
    Matching(MatchOptions options, Callback on_set) : matcher(sizeof...(Ts), options), callback(std::move(on_set)) {}

    // Called back one set at a time, in order: a set has a message of each channel, and until the callback has
    // returned, the serial node of the channel that completed the set takes no other.
    void Push(std::size_t channel, Time stamp, AnyMessage message) {
      std::unique_lock lock(mutex);
      const auto set = matcher.Push(channel, stamp, std::move(message));
      lock.unlock();
      if (set) Call(*set, std::index_sequence_for<Ts...>{});
    }
    template <std::size_t... I>
    void Call(const typename Matcher::Set& set, std::index_sequence<I...> /*channels*/) {
      callback(std::static_pointer_cast<const Ts>(set[I].item)...);
    }

    std::mutex mutex;
    Matcher matcher;  // Guarded by mutex.
    const Callback callback;
  };

  template <class From, std::size_t... I>
  void Subscribe(From& from, const ChannelNames& channels, const NodeOptions& nodes, const CallSite& where,
                 std::index_sequence<I...> /*channels*/) {
    (SubscribeTo<Ts>(from, channels[I], I, nodes, where), ...);
  }
  template <class T, class From>
  void SubscribeTo(From& from, const std::string& channel, std::size_t index, NodeOptions node, const CallSite& where) {
    if (!node.name.empty()) node.name += "/" + channel;
    const auto push = [matching = matching_, index](const std::shared_ptr<const T>& message) {
      matching->Push(index, StampOf(*message), message);
    };
    if constexpr (std::is_void_v<decltype(from.template FromAny<T>(channel, Invoke::kSerial, push, node, where))>) {
      from.template FromAny<T>(channel, Invoke::kSerial, push, std::move(node), where);
    } else {
      subscriptions_.push_back(from.template FromAny<T>(channel, Invoke::kSerial, push, std::move(node), where));
    }
  }

  std::shared_ptr<Matching> matching_;
  std::vector<Subscription> subscriptions_;
};

}  // namespace hgros
