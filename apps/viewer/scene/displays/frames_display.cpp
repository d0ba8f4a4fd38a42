#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "viewer/data/bounds_of_most.hpp"
#include "viewer/data/frames/frame_ages.hpp"
#include "viewer/data/frames/pose_list.hpp"
#include "viewer/data/quantity_text.hpp"
#include "viewer/scene/display_types.hpp"
#include "viewer/scene/displays/transform_wait.hpp"
#include "viewer/scene/layers/pose_strip.hpp"
#include "viewer/scene/layers/segments.hpp"

namespace hgros::viewer {
namespace {

/// Every frame at its latest place: axes, name, and a line to its parent.
class FramesDisplay : public Display {
 public:
  [[nodiscard]] Change Update(const UpdateContext& context) override {
    const bool due = context.transforms_changed || context.frame_changed || std::exchange(setting_changed_, false) ||
                     context.now_s >= next_change_s();
    if (due) fixed_ = &context.frame;
    if (fixed_ != nullptr) updated_s_ = context.now_s;
    if (due) {
      back_ns_ = 0;
      UpdateEdges();
      known_.Update(edges_, context.now_s);
    }
    if (unplaced_.empty()) {
      wait_ = {};
    } else {
      wait_.Miss(unplaced_, context.now_s);
    }
    return due ? Change::kMoving : Change::kNothing;
  }

  // All frames at that time before the newest transform.
  [[nodiscard]] Change LookBack(double /*newest_s*/, double back_s) override {
    const auto back_ns = static_cast<std::int64_t>(back_s * 1e9);
    if (std::exchange(back_ns_, back_ns) == back_ns || fixed_ == nullptr) return Change::kNothing;
    UpdateEdges();
    return Change::kMoving;
  }

  // All transforms are read while drawing.
  [[nodiscard]] Change ApplySettings(const UpdateContext& /*context*/) override {
    return fixed_ != nullptr && std::exchange(setting_changed_, false) ? Change::kMoving : Change::kNothing;
  }

  [[nodiscard]] double oldest_s() const override { return updated_s_ - remembered_s_; }
  [[nodiscard]] double truthful_since_s() const override {
    return moves_ ? oldest_s() : -std::numeric_limits<double>::infinity();
  }
  // The name of the nearest frame.
  [[nodiscard]] std::string ValueAt(const Eigen::Vector3d& at, double radius_m) const override {
    const auto distance = [&](const ShownFrame& frame) { return (frame.at - at).norm(); };
    const auto nearest = std::ranges::min_element(frames_, {}, distance);
    const double reach_m = radius_m + static_cast<double>(axes_meters_);
    return nearest == frames_.end() || distance(*nearest) > reach_m ? std::string() : nearest->name;
  }

  void DrawMoving(const DrawContext& context) override {
    const RigidTransform T_fixed_origin({1, 0, 0, 0}, poses_.origin());
    if (links_) segments_.Draw(context.view, T_fixed_origin, 1.5F * context.scale);
    strip_.DrawAxes(context.view, T_fixed_origin, axes_meters_, 3 * context.scale);
  }

  [[nodiscard]] std::vector<Setting> Settings() override {
    return {
        {"axes length", "The length of the axes.", Setting::Number{&axes_meters_, 0.001F, 100, "m"}},
        {"names", "Each frame's name beside it.", Setting::Switch{&names_}},
        {"links", "A line from each frame to its parent.", Setting::Switch{&links_}},
        {"ages", "The time since the last transform of each moving frame, beside its name.", Setting::Switch{&ages_}},
        {"silent after", "A frame without a transform for this time is shown in orange.",
         Setting::Number{&silent_after_s_, 0.1F, 3600, "s"}},
    };
  }
  void OnSetting(const std::string& /*name*/) override { setting_changed_ = true; }

  [[nodiscard]] std::vector<std::string> Status() const override {
    std::vector<std::string> lines;
    if (!wait_.fault().empty()) lines.push_back(wait_.fault());
    lines.push_back(edges_.empty() ? "No transforms have arrived yet." : Counted(frames_.size(), "frame", "frames"));
    for (std::size_t i = 0; i < std::min(edges_.size(), kMostTold); ++i) lines.push_back(LineOf(edges_[i]));
    if (edges_.size() > kMostTold) lines.push_back("and " + std::to_string(edges_.size() - kMostTold) + " more");
    return lines;
  }
  // The time when the next frame becomes silent. With ages shown, each second.
  [[nodiscard]] double next_change_s() const override {
    if (back_ns_ != 0 || known_.empty()) return std::numeric_limits<double>::infinity();
    const double silent_s =
        std::min(known_.NextAged(static_cast<double>(silent_after_s_), updated_s_), wait_.next_change_s());
    return ages_ && names_ ? std::min(silent_s, std::floor(updated_s_) + 1) : silent_s;
  }
  [[nodiscard]] bool HasFault() const override { return !wait_.fault().empty(); }
  [[nodiscard]] std::vector<Label> Labels() const override {
    std::vector<Label> labels;
    if (!names_) return labels;
    for (const ShownFrame& frame : frames_) labels.push_back(LabelOf(frame));
    return labels;
  }
  [[nodiscard]] std::size_t gpu_bytes() const override { return strip_.gpu_bytes(); }
  [[nodiscard]] Eigen::AlignedBox3d Bounds() const override {
    std::vector<Eigen::AlignedBox3d> boxes;
    for (const ShownFrame& frame : frames_) boxes.emplace_back(frame.at);
    return BoundsOfMost(std::move(boxes));
  }

 private:
  struct ShownFrame {
    std::string name;
    Eigen::Vector3d at;
  };

  [[nodiscard]] Time ShownTime() const {
    if (back_ns_ == 0) return {};
    Time newest;
    for (const EdgeSnapshot& edge : edges_) newest = std::max(newest, edge.newest);
    return {std::max<std::int64_t>(newest.nanoseconds - back_ns_, 1)};
  }

  /// Seconds since the last transform of a moving frame, unless the picture looks back.
  [[nodiscard]] std::optional<double> AgeOf(const std::string& frame) const {
    return back_ns_ == 0 ? known_.AgeOf(frame, updated_s_) : std::nullopt;
  }
  [[nodiscard]] bool IsSilent(const std::string& frame) const {
    return back_ns_ == 0 && known_.HasAged(frame, static_cast<double>(silent_after_s_), updated_s_);
  }
  [[nodiscard]] static std::string AgeText(double age_s) {
    if (age_s < 1) return "under 1 s";
    return age_s < 120 ? std::to_string(static_cast<std::int64_t>(age_s)) + " s"
                       : std::to_string(static_cast<std::int64_t>(age_s / 60)) + " min";
  }

  [[nodiscard]] Label LabelOf(const ShownFrame& frame) const {
    Label label{frame.at, frame.name};
    const auto age_s = AgeOf(frame.name);
    if (ages_ && age_s) label.text += ", " + AgeText(*age_s);
    if (!IsSilent(frame.name)) return label;
    if (!ages_) label.text += " (silent)";
    label.color = kSilent;
    return label;
  }

  /// Describes a frame that has a parent.
  [[nodiscard]] std::string LineOf(const EdgeSnapshot& edge) const {
    std::string line = edge.child + ": below " + edge.parent;
    if (edge.is_static) return line + ", static";
    const auto age_s = AgeOf(edge.child);
    if (!age_s) return line;
    if (IsSilent(edge.child)) {
      line += ", silent";
    } else if (edge.RateHz() > 0) {
      line += ", " + RateText(edge.RateHz());
    }
    if (ages_) line += ", " + AgeText(*age_s) + " ago";
    return line;
  }

  void UpdateEdges() {
    edges_ = fixed_->tree().Edges();
    const Time shown = ShownTime();
    std::int64_t remembered_ns = 0;
    moves_ = false;
    for (const EdgeSnapshot& edge : edges_) {
      moves_ |= !edge.is_static;
      if (!edge.is_static) remembered_ns = std::max(remembered_ns, (edge.newest - edge.oldest).count());
    }
    remembered_s_ = 1e-9 * static_cast<double>(remembered_ns);
    unplaced_.clear();
    frames_.clear();
    std::vector<RigidTransform> poses;
    std::map<std::string, std::size_t, std::less<>> index;
    const auto place = [&](const std::string& frame) {
      if (index.contains(frame)) return;
      RigidTransform T_fixed_frame;
      std::string why;
      if (fixed_->Find(frame, shown, T_fixed_frame, why) != FixedFrame::Answer::kFound) {
        unplaced_ = why;
        return;
      }
      index.emplace(frame, poses.size());
      poses.push_back(T_fixed_frame);
      frames_.push_back({frame, T_fixed_frame.translation});
    };
    for (const EdgeSnapshot& edge : edges_) {
      place(edge.parent);
      place(edge.child);
    }
    poses_.Clear();
    (void)poses_.Replace(poses);
    strip_.Set(poses_.poses());

    std::vector<Segments::Segment> links;
    for (const EdgeSnapshot& edge : edges_) {
      const auto parent = index.find(edge.parent);
      const auto child = index.find(edge.child);
      if (parent == index.end() || child == index.end()) continue;
      const auto local = [&](std::size_t i) {
        return Eigen::Vector3f((poses[i].translation - poses_.origin()).cast<float>());
      };
      links.push_back({local(child->second), local(parent->second), edge.is_static ? 0xB0A0A0A0U : 0xD03CC8F0U});
    }
    segments_.Set(links);
  }

  static constexpr std::size_t kMostTold = 50;
  static constexpr Rgba kSilent = MakeRgba(255, 178, 90);

  FrameAges known_;
  PoseList poses_;
  PoseStrip strip_;
  Segments segments_;
  std::vector<EdgeSnapshot> edges_;
  std::vector<ShownFrame> frames_;
  std::string unplaced_;  ///< Why a frame has no place; empty: all have one.
  TransformWait wait_;
  const FixedFrame* fixed_ = nullptr;
  std::int64_t back_ns_ = 0;
  double updated_s_ = std::numeric_limits<double>::infinity();
  double remembered_s_ = 0;  ///< How far back the transforms reach.
  bool moves_ = false;       ///< Some transform is not static.
  bool setting_changed_ = true;
  float axes_meters_ = 0.5F;
  bool names_ = true;
  bool links_ = true;
  bool ages_ = false;
  float silent_after_s_ = 5;
};

}  // namespace

DisplayType FramesDisplayType() {
  return {"Frames", {}, [](const DisplayInputs& /*inputs*/) -> std::unique_ptr<Display> {
            return std::make_unique<FramesDisplay>();
          }};
}

}  // namespace hgros::viewer
