#pragma once

#include <string>
#include <string_view>

#include "hgros/tf/transform_tree.hpp"

namespace hgros::viewer {

/// The frame that everything is shown in, and where other frames are in it. It is requested by name, or chosen: a root
/// of the transforms, preferably one with a usual name (map, world, odom, earth). While there are no transforms, it is
/// the frame of the first message, and only messages of that frame can be shown.
class FixedFrame {
 public:
  enum class Answer {
    kFound,
    kLater,  ///< May still come.
    kNever,  ///< Too old, or contradictory.
  };

  explicit FixedFrame(const TransformTree& tree) : tree_(tree) {}

  /// Requests a frame. Empty: the frame is chosen.
  void Ask(std::string_view name);
  /// Chooses again after transforms have arrived. Returns whether the fixed frame has changed.
  bool Refresh();
  /// Call it for each message with its frame. Returns whether the fixed frame has changed.
  bool Saw(std::string_view frame);

  /// Gives T_fixed_frame at `stamp`, or the latest one if the stamp is 0. A message without a frame is in the fixed
  /// frame. If there is no transform, `why` is a sentence with the reason.
  [[nodiscard]] Answer Find(std::string_view frame, Time stamp, RigidTransform& T_fixed_frame, std::string& why) const;
  /// The latest.
  [[nodiscard]] Answer Find(std::string_view frame, RigidTransform& T_fixed_frame, std::string& why) const;

  [[nodiscard]] const std::string& name() const noexcept { return name_; }
  [[nodiscard]] bool chosen() const noexcept { return !asked_; }
  [[nodiscard]] const TransformTree& tree() const noexcept { return tree_; }

 private:
  const TransformTree& tree_;
  std::string name_;
  bool asked_ = false;
};

}  // namespace hgros::viewer
