#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "viewer/scene/display.hpp"
#include "viewer/scene/displays/placement.hpp"
#include "viewer/scene/displays/settling.hpp"

namespace hgros::viewer {

/// A display of the newest message of a channel in the message's frame. It is settled while it does not change, and
/// drawn last while it is transparent.
class PlacedDisplay : public Display {
 public:
  [[nodiscard]] Change Update(const UpdateContext& context) final;
  [[nodiscard]] Change ApplySettings(const UpdateContext& context) final;
  void DrawNew(const DrawContext& context) final;
  void DrawSettled(const DrawContext& context, const Slice& slice) final;
  void DrawMoving(const DrawContext& context) final;
  void DrawBlended(const DrawContext& context) final;
  [[nodiscard]] bool blends() const final { return blended() && placement_.known() && !empty(); }
  void Clear() final;
  void OnSetting(const std::string& name) final;
  [[nodiscard]] std::vector<std::string> Status() const final;
  [[nodiscard]] bool HasFault() const final { return !fault_.empty() || !placement_.fault().empty(); }
  [[nodiscard]] std::string WaitsFor() const final { return empty() ? std::string() : placement_.waits_for(); }
  [[nodiscard]] Eigen::AlignedBox3d Bounds() const final;
  [[nodiscard]] std::string data_frame() const final { return frame(); }
  [[nodiscard]] double next_change_s() const final {
    return empty() ? settling_.next_change_s() : std::min(settling_.next_change_s(), placement_.next_change_s());
  }

 protected:
  /// Takes what has arrived. Returns what is wrong with it, or an empty sentence. None if nothing has arrived.
  [[nodiscard]] virtual std::optional<std::string> TakeArrived() = 0;
  /// Reads the shown message again. Returns the same as TakeArrived.
  [[nodiscard]] virtual std::optional<std::string> TakeAgain() = 0;
  /// Call it when a setting has changed. If the setting affects reading, the last message is read again.
  virtual void TakeSetting(const std::string& name) = 0;
  virtual void Forget() = 0;
  /// Whether nothing of the last message can be drawn.
  [[nodiscard]] virtual bool empty() const = 0;
  [[nodiscard]] virtual bool blended() const = 0;
  [[nodiscard]] virtual const std::string& frame() const = 0;
  /// The corner of the picture, in its frame.
  [[nodiscard]] virtual const Eigen::Isometry3d& T_frame_corner() const = 0;
  /// Its box, along the axes of the corner.
  [[nodiscard]] virtual Eigen::AlignedBox3d box() const = 0;
  virtual void Draw(const DrawContext& context, const RigidTransform& T_fixed_corner, const Slice& slice) = 0;
  /// The status of a message that is not empty.
  virtual void Describe(std::vector<std::string>& lines) const = 0;
  [[nodiscard]] std::uint64_t received() const override = 0;
  [[nodiscard]] std::uint64_t dropped() const override = 0;

  /// Converts a point of the fixed frame to the axes of the corner. None while the corner has no place.
  [[nodiscard]] std::optional<Eigen::Vector3d> FromCorner(const Eigen::Vector3d& at) const {
    if (!placement_.known() || empty()) return std::nullopt;
    return T_fixed_corner().Inverse() * at;
  }

 private:
  [[nodiscard]] RigidTransform T_fixed_corner() const {
    return placement_.T_fixed_frame() * RigidTransform(T_frame_corner());
  }

  Placement placement_;
  Settling settling_;
  std::string fault_;
  bool setting_changed_ = false;
};

/// "There are: x y z" if there are several.
void ListFields(const std::vector<std::string>& fields, std::vector<std::string>& lines);

}  // namespace hgros::viewer
