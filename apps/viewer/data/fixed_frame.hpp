#pragma once

#include <string>
#include <string_view>

#include "hgros/tf/transform_tree.hpp"

namespace hgros::viewer {

/// The frame that everything is shown in, and how other frames lie in it. Asked for by name, or chosen: the root of the
/// transforms, one that is usually meant (map, world, odom, earth) before others; while there are no transforms, the
/// frame of the first message. Without any transform messages of that one frame can be shown.
class FixedFrame {
 public:
  enum class Answer {
    kFound,
    kLater,  ///< May still come.
    kNever,  ///< Too old, or contradictory.
  };

  explicit FixedFrame(const TransformTree& tree) : tree_(tree) {}

  /// Empty: it is to be chosen.
  void Ask(std::string_view name);
  /// Chooses anew after transforms have come. Whether it is another frame now.
  bool Refresh();
  /// A message has come in that frame. Whether the fixed frame is another one now.
  bool Saw(std::string_view frame);

  /// T_fixed_frame at `stamp`; at the latest time if that is 0. A message without a frame is in the fixed one.
  /// `why` is a sentence if there is none.
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
