#pragma once

#include <algorithm>
#include <limits>

#include "viewer/app/displays/channel_list.hpp"
#include "viewer/scene/scene.hpp"

namespace hgros::viewer {

/// Counts, every two seconds, the messages of each display that could not be read. Such messages wake nobody, so the
/// session is asked.
class UnreadableCounter {
 public:
  UnreadableCounter(const Session& session, Scene& scene, const ChannelList& channels)
      : session_(session), scene_(scene), channels_(channels) {}

  /// Counts if it is due. Returns whether the list of displays has to be drawn again.
  [[nodiscard]] bool Update(double now_s);
  [[nodiscard]] double next_s() const noexcept { return next_s_; }
  void CountSoon(double at_s) { next_s_ = std::min(next_s_, at_s); }

 private:
  const Session& session_;
  Scene& scene_;
  const ChannelList& channels_;
  double next_s_ = 0;
};

}  // namespace hgros::viewer
