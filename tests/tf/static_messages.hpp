#pragma once

#include <algorithm>
#include <map>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include <foxglove/FrameTransforms.pb.h>

#include "hgros/session/session.hpp"
#include "hgros/tf/transforms.hpp"
#include "support/await.hpp"

namespace hgros::test {

/// The messages with static edges that a session gets, each as x by child.
class StaticMessages {
 public:
  using Edges = std::map<std::string, double>;

  explicit StaticMessages(Session& session) {
    const auto keep = [this](const foxglove::FrameTransforms& message) {
      Edges edges;
      for (const auto& one : message.transforms()) edges[one.child_frame_id()] = one.translation().x();
      const std::scoped_lock lock(mutex_);
      all_.push_back(std::move(edges));
    };
    messages_ = session.FromAny<foxglove::FrameTransforms>(kStaticTransformsChannel, Invoke::kSerial, keep,
                                                           {.queue = Queue::KeepAll(1000)});
  }
  [[nodiscard]] std::vector<Edges> all() const {
    const std::scoped_lock lock(mutex_);
    return all_;
  }
  [[nodiscard]] bool Gets(const Edges& edges) const {
    return Await([&] { return std::ranges::count(all(), edges) != 0; });
  }

 private:
  mutable std::mutex mutex_;
  std::vector<Edges> all_;
  Subscription messages_;
};

}  // namespace hgros::test
