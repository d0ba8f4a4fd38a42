#pragma once

#include <array>
#include <deque>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "viewer/data/points/placed_points.hpp"
#include "viewer/data/points/point_batch.hpp"
#include "viewer/data/value_range.hpp"
#include "viewer/scene/display.hpp"
#include "viewer/scene/layers/kept_points.hpp"
#include "viewer/scene/layers/recent_points.hpp"

namespace hgros::viewer {

/// The common part of clouds and scans: points that are shown until the next message, for some messages, for a time,
/// or forever. Points that stay forever are in the settled layer, the others in the moving one.
class PointsDisplay : public Display {
 public:
  [[nodiscard]] Change Update(const UpdateContext& context) final;
  void DrawNew(const DrawContext& context) final;
  void DrawSettled(const DrawContext& context, const Slice& slice) final;
  void DrawMoving(const DrawContext& context) final;
  void Clear() final;
  [[nodiscard]] std::vector<Setting> Settings() final;
  void OnSetting(const std::string& name) final;
  [[nodiscard]] std::vector<std::string> Status() const final;
  [[nodiscard]] bool HasFault() const final { return !fault_.empty() || !lost_.empty(); }
  [[nodiscard]] std::string WaitsFor() const final { return waiting_.empty() ? std::string() : waits_for_; }
  [[nodiscard]] std::size_t settled_points() const final;
  [[nodiscard]] std::size_t moving_points() const final { return recent_.points(); }
  [[nodiscard]] std::size_t points() const final { return settled_points() + recent_.points(); }
  [[nodiscard]] std::size_t gpu_bytes() const final;
  [[nodiscard]] Eigen::AlignedBox3d Bounds() const final;
  [[nodiscard]] double next_change_s() const final;
  [[nodiscard]] Change LookBack(double newest_s, double back_s) final;
  [[nodiscard]] double oldest_s() const final { return recent_.oldest_s(); }
  [[nodiscard]] std::string data_frame() const final { return frame_; }
  [[nodiscard]] std::string ValueAt(const Eigen::Vector3d& at, double radius_m) const final;
  [[nodiscard]] std::optional<ColorLegend> Legend() const final;

 protected:
  /// The color starts as the z axis, or as the points' own colors if the first ones have some.
  PointsDisplay() = default;
  /// All points start with one color.
  explicit PointsDisplay(const std::array<float, 3>& flat)
      : color_given_(true), color_by_(static_cast<int>(ColorBy::kFlat)), flat_(flat) {}
  struct Read {
    PointBatch batch;
    std::string fault;  ///< If it is not empty, there is no batch.
  };
  /// The messages that have arrived since the last call: at most the newest `most`.
  [[nodiscard]] virtual std::vector<Read> ReadArrived(const std::string& field, std::size_t most) = 0;
  [[nodiscard]] std::uint64_t received() const override = 0;

 private:
  enum Keep { kLatest, kCount, kTime, kForEver };
  struct Waiting {
    PointBatch batch;
    double since_s;
    bool late = false;      ///< It has waited for kLongestWaitS.
    bool reported = false;  ///< It is counted in unplaced_.
  };

  [[nodiscard]] std::size_t MostMessages() const;
  [[nodiscard]] PointStyle Style(float scale) const;
  [[nodiscard]] bool mapped() const {
    return color_by_ == static_cast<int>(ColorBy::kAxis) || color_by_ == static_cast<int>(ColorBy::kScalar);
  }
  /// Places a batch in the fixed frame. Returns whether the range of the colors has changed.
  bool Place(const PointBatch& batch, const RigidTransform& T_fixed_frame, const UpdateContext& context);
  void Keep(const PlacedPoints& placed, const PointBatch& batch, const std::string& fixed_frame);
  [[nodiscard]] Change PlaceWaiting(const UpdateContext& context);
  /// Places what is shown in another fixed frame.
  [[nodiscard]] Change PlaceAgain(const UpdateContext& context);

  std::deque<Waiting> waiting_;  ///< Batches that wait for their transforms.
  std::deque<KeptPoints> kept_;  ///< One for each fixed frame in which points came.
  RecentPoints recent_;
  std::array<ValueRange, 3> axis_ranges_;
  ValueRange value_range_;
  std::vector<Eigen::Vector3d> placed_;
  std::vector<std::string> fields_;
  std::string fault_;
  std::string lost_;       ///< Why the last message, or kept points, have no place in the new fixed frame.
  std::string waits_for_;  ///< Why the first of waiting_ has no place yet.
  std::string shown_field_;
  std::string frame_;  ///< The frame of the last message.
  double shown_until_s_ = std::numeric_limits<double>::infinity();
  std::uint64_t unplaced_ = 0;
  bool setting_changed_ = false;
  bool empty_ = false;        ///< The last message had no points.
  bool color_given_ = false;  ///< The first points do not decide what the color shows.

  int keep_ = kLatest;
  float keep_count_ = 10;
  float keep_s_ = 5;
  int color_by_ = static_cast<int>(ColorBy::kAxis);
  std::string field_;
  int axis_ = 2;
  int map_ = 0;
  bool auto_range_ = true;
  float lo_ = 0;
  float hi_ = 10;
  std::array<float, 3> flat_ = {0.92F, 0.92F, 0.92F};
  float size_ = 2;
  int size_unit_ = 0;  ///< 0: pixels, 1: meters.
};

}  // namespace hgros::viewer
