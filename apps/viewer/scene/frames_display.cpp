#include <map>
#include <utility>

#include "viewer/data/pose_list.hpp"
#include "viewer/scene/display_types.hpp"
#include "viewer/scene/pose_strip.hpp"
#include "viewer/scene/segments.hpp"

namespace hgros::viewer {
namespace {

/// Every frame of the transforms, where it is now: axes, name, and a line to its parent.
class FramesDisplay : public Display {
 public:
  [[nodiscard]] Change Update(const UpdateContext& context) override {
    const bool due = context.transforms_changed || context.frame_changed || std::exchange(setting_changed_, false);
    if (!due) return Change::kNothing;
    Take(context);
    return Change::kMoving;
  }

  void DrawMoving(const DrawContext& context) override {
    const RigidTransform T_fixed_origin({1, 0, 0, 0}, poses_.origin());
    if (links_) segments_.Draw(context.view, T_fixed_origin, 1.5F * context.scale);
    strip_.DrawAxes(context.view, T_fixed_origin, axes_metres_, 3 * context.scale);
  }

  [[nodiscard]] std::vector<Setting> Settings() override {
    return {
        {"axes length", "Of the axes.", Setting::Number{&axes_metres_, 0.001F, 100, "m"}},
        {"names", "Each frame's name beside it.", Setting::Switch{&names_}},
        {"links", "A line from each frame to its parent.", Setting::Switch{&links_}},
    };
  }
  void OnSetting(const std::string& /*name*/) override { setting_changed_ = true; }

  [[nodiscard]] std::vector<std::string> Status() const override {
    std::vector<std::string> lines;
    if (!fault_.empty()) lines.push_back(fault_);
    lines.push_back(edges_ == 0 ? "No transforms have arrived yet." : std::to_string(labels_.size()) + " frames");
    return lines;
  }
  [[nodiscard]] bool HasFault() const override { return !fault_.empty(); }
  [[nodiscard]] std::vector<Label> Labels() const override { return names_ ? labels_ : std::vector<Label>(); }
  [[nodiscard]] std::size_t gpu_bytes() const override { return strip_.gpu_bytes(); }
  [[nodiscard]] Eigen::AlignedBox3d Bounds() const override {
    Eigen::AlignedBox3d bounds;
    for (const Label& label : labels_) bounds.extend(label.at);
    return bounds;
  }

 private:
  void Take(const UpdateContext& context) {
    const std::vector<EdgeSnapshot> edges = context.frame.tree().Edges();
    edges_ = edges.size();
    fault_.clear();
    labels_.clear();
    std::vector<RigidTransform> poses;
    std::map<std::string, std::size_t, std::less<>> index;
    const auto place = [&](const std::string& frame) {
      if (index.contains(frame)) return;
      RigidTransform T_fixed_frame;
      std::string why;
      if (context.frame.Find(frame, T_fixed_frame, why) != FixedFrame::Answer::kFound) {
        fault_ = why;
        return;
      }
      index.emplace(frame, poses.size());
      poses.push_back(T_fixed_frame);
      labels_.push_back({T_fixed_frame.translation, frame});
    };
    for (const EdgeSnapshot& edge : edges) {
      place(edge.parent);
      place(edge.child);
    }
    poses_.Clear();
    (void)poses_.Replace(poses);
    strip_.Set(poses_.poses());

    std::vector<Segments::Segment> links;
    for (const EdgeSnapshot& edge : edges) {
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

  PoseList poses_;
  PoseStrip strip_;
  Segments segments_;
  std::vector<Label> labels_;
  std::size_t edges_ = 0;
  std::string fault_;
  bool setting_changed_ = true;
  float axes_metres_ = 0.5F;
  bool names_ = true;
  bool links_ = true;
};

}  // namespace

DisplayType FramesDisplayType() {
  return {"Frames", {}, [](const DisplayInputs& /*inputs*/) -> std::unique_ptr<Display> {
            return std::make_unique<FramesDisplay>();
          }};
}

}  // namespace hgros::viewer
