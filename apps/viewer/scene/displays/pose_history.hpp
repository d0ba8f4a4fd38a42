#pragma once

#include <Eigen/Geometry>
#include <array>
#include <limits>
#include <string>
#include <vector>

#include "viewer/data/frames/pose_list.hpp"
#include "viewer/scene/display.hpp"
#include "viewer/scene/displays/placement.hpp"
#include "viewer/scene/layers/pose_strip.hpp"

namespace hgros::viewer {

/// The common part of trajectories and poses: a list of poses in one frame, as a line, as axes, or both. A list that
/// only grows is settled. A list that is rewritten moves until it has not changed for a while.
class PoseHistory : public Display {
 public:
  [[nodiscard]] Change Update(const UpdateContext& context) final;
  void DrawNew(const DrawContext& context) final;
  void DrawSettled(const DrawContext& context, const Slice& slice) final;
  void DrawMoving(const DrawContext& context) final;
  void Clear() final;
  [[nodiscard]] std::vector<Setting> Settings() override;
  void OnSetting(const std::string& name) override;
  [[nodiscard]] std::vector<std::string> Status() const final;
  [[nodiscard]] bool HasFault() const final { return !placement_.fault().empty(); }
  [[nodiscard]] std::string WaitsFor() const final {
    return poses_.poses().empty() ? std::string() : placement_.waits_for();
  }
  [[nodiscard]] std::size_t gpu_bytes() const final { return strip_.gpu_bytes(); }
  [[nodiscard]] Eigen::AlignedBox3d Bounds() const final;
  [[nodiscard]] double next_change_s() const final;
  [[nodiscard]] Change LookBack(double newest_s, double back_s) final;
  [[nodiscard]] double oldest_s() const final;
  [[nodiscard]] std::string data_frame() const final { return frame_; }

 protected:
  /// Takes what has arrived into `poses`, and sets their frame.
  [[nodiscard]] virtual PoseList::Change TakeArrived(PoseList& poses, std::string& frame) = 0;
  [[nodiscard]] std::uint64_t received() const override = 0;

  enum Style { kLine, kAxes, kBoth };
  int style_ = kLine;
  std::array<float, 3> color_ = {0.20F, 0.85F, 0.65F};
  float width_ = 2;
  float axes_meters_ = 0.5F;

 private:
  static constexpr double kRestS = 2;  ///< After this time without a rewrite it is settled again.

  void DrawFrom(const DrawContext& context, std::size_t first);

  [[nodiscard]] Change Rewritten(double now_s);
  /// Each pose has the time of its first arrival. In a rewritten list, times stay with the index.
  void KeepTimes(double now_s);
  [[nodiscard]] Change TakeTransform(const UpdateContext& context);

  PoseList poses_;
  PoseStrip strip_;
  std::vector<double> times_s_;  ///< Time of arrival of each pose.
  std::size_t removed_ = 0;      ///< Poses removed from the front, as known to times_s_.
  bool looking_back_ = false;    ///< The strip holds only the first poses.
  std::string frame_;
  Placement placement_;
  bool setting_changed_ = false;
  double rewritten_s_ = -std::numeric_limits<double>::infinity();
  bool moving_ = false;    ///< It is drawn in every frame instead of settled.
  std::size_t drawn_ = 0;  ///< Poses in the settled layer.
};

}  // namespace hgros::viewer
