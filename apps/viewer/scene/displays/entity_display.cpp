#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "hgros/clock/clock.hpp"
#include "viewer/data/inbox.hpp"
#include "viewer/data/mesh/model_meshes.hpp"
#include "viewer/data/quantity_text.hpp"
#include "viewer/data/shapes/scene_store.hpp"
#include "viewer/data/shapes/shape_bounds.hpp"
#include "viewer/scene/display_types.hpp"
#include "viewer/scene/displays/settling.hpp"
#include "viewer/scene/displays/transform_wait.hpp"
#include "viewer/scene/layers/drawn_shapes.hpp"

namespace hgros::viewer {
namespace {

constexpr std::size_t kMostUpdatesWaiting = 1024;
constexpr double kFarMeters = 1000;     ///< Distance from the drawing's origin at which a new origin is chosen.
constexpr double kTooFarMeters = 1e10;  ///< Farther away, no new origin is chosen.

void Fade(float alpha, SceneShapes& shapes) {
  if (alpha >= 1) return;
  const auto fade = [alpha](Rgba& color) {
    color = (color & 0xFFFFFFU) | static_cast<Rgba>(std::lround(static_cast<float>(AlphaOf(color)) * alpha)) << 24U;
  };
  for (auto* const solids : {&shapes.cubes, &shapes.spheres, &shapes.cylinders}) {
    for (SolidShape& solid : *solids) fade(solid.color);
  }
  for (LinePiece& line : shapes.lines) {
    fade(line.from_color);
    fade(line.to_color);
  }
  for (TriangleCorner& corner : shapes.triangles) fade(corner.color);
}

/// The entities of a channel, changed by one kind of message. All opaque ones are drawn in at most five calls, and so
/// are all transparent ones.
template <class Message>
class EntityDisplay : public Display {
 public:
  explicit EntityDisplay(const DisplayInputs& inputs)
      : clock_(inputs.session.clock()),
        subscription_(inputs.session.FromAny<Message>(
            inputs.channel, Invoke::kSerial,
            [inbox = inbox_, wake = inputs.wake](std::shared_ptr<const Message> update) {
              const std::size_t bytes = update->SpaceUsedLong();
              if (inbox->Put(std::move(update), bytes)) wake();
            },
            {.queue = Queue::KeepLast(kMostUpdatesWaiting)})) {}

  [[nodiscard]] Change Update(const UpdateContext& context) override {
    Change change = Change::kNothing;
    if (std::exchange(setting_changed_, false)) {
      change = Change::kRedraw;
      outdated_ = true;
    }
    const Time now = clock_->Now();
    for (const auto& update : inbox_->TakeAll()) {
      fault_ = store_.Apply(*update, now);
      outdated_ = true;
      for (const auto& [id, entity] : store_.entities()) {
        if (context.frame.Saw(entity.frame) || !context.frame.name().empty()) break;
      }
    }
    outdated_ |= store_.Expire(now);
    if (context.frame_changed) {
      change = std::max(change, settling_.Gone());
      placed_.clear();
      outdated_ = true;
    }
    if (context.transforms_changed) outdated_ |= provisional_ || drawing_.unplaced > 0 || HasMoved(context);
    if (std::exchange(outdated_, false)) {
      Rebuild(context);
      change = std::max(change, settling_.Replaced(context.now_s));
    }
    if (drawing_.unplaced > 0) {
      wait_.Miss(Unplaced(), context.now_s);
    } else {
      wait_ = {};
    }
    const auto ends = store_.NextEnd();
    end_s_ = ends ? context.now_s + std::max(0.01, std::chrono::duration<double>(*ends - now).count())
                  : std::numeric_limits<double>::infinity();
    return std::max(change, settling_.Rest(context.now_s));
  }

  // Places of its frames at the last drawing; they may have moved since.
  [[nodiscard]] Change ApplySettings(const UpdateContext& context) override {
    if (!std::exchange(setting_changed_, false)) return Change::kNothing;
    stands_ = true;
    Rebuild(context);
    stands_ = false;
    return Change::kRedraw;
  }

  void DrawNew(const DrawContext& context) override {
    if (settling_.TakeNew()) drawn_.Draw(context, Place(), false);
  }
  void DrawSettled(const DrawContext& context, const Slice& slice) override {
    if (slice.index == 0 && settling_.TakeSettled()) drawn_.Draw(context, Place(), false);
  }
  void DrawMoving(const DrawContext& context) override {
    if (settling_.moves()) drawn_.Draw(context, Place(), false);
  }
  void DrawBlended(const DrawContext& context) override { drawn_.Draw(context, Place(), true); }
  [[nodiscard]] bool blends() const override { return true; }
  void Clear() override {
    store_.Clear();
    outdated_ = true;
  }

  [[nodiscard]] std::vector<Setting> Settings() override {
    return {
        {"alpha", "Opacity: 0 is invisible, 1 is opaque.", Setting::Number{&alpha_, 0, 1, ""}},
        {"texts", "The texts among the shapes.", Setting::Switch{&texts_}},
    };
  }
  void OnSetting(const std::string& /*name*/) override { setting_changed_ = true; }

  [[nodiscard]] std::vector<std::string> Status() const override {
    std::vector<std::string> lines;
    if (!fault_.empty()) lines.push_back(fault_);
    if (!model_fault_.empty()) lines.push_back(model_fault_);
    if (!wait_.fault().empty()) lines.push_back(wait_.fault());
    if (inbox_->received() == 0) {
      lines.emplace_back("Nothing has arrived yet.");
    } else if (store_.entities().empty()) {
      lines.emplace_back("No entity is left.");
    }
    lines.push_back(Counted(store_.entities().size(), "entity", "entities") + ", " +
                    Counted(shapes_, "shape", "shapes"));
    if (inbox_->dropped() > 0)
      lines.push_back(Counted(inbox_->dropped(), "message", "messages") + " arrived too fast.");
    return lines;
  }
  [[nodiscard]] bool HasFault() const override {
    return !fault_.empty() || !model_fault_.empty() || !wait_.fault().empty();
  }
  [[nodiscard]] std::string WaitsFor() const override { return wait_.waits_for(); }
  [[nodiscard]] std::vector<Label> Labels() const override { return texts_ ? labels_ : std::vector<Label>(); }
  [[nodiscard]] std::uint64_t received() const override { return inbox_->received(); }
  [[nodiscard]] std::uint64_t dropped() const override { return inbox_->dropped(); }
  [[nodiscard]] std::size_t gpu_bytes() const override { return drawn_.gpu_bytes(); }
  [[nodiscard]] Eigen::AlignedBox3d Bounds() const override { return bounds_; }
  [[nodiscard]] std::string ValueAt(const Eigen::Vector3d& at, double radius_m) const override {
    const auto pose_of = [&](const std::string& frame, std::optional<Time> when) -> std::optional<Eigen::Isometry3d> {
      const Key key{frame, when ? std::optional(when->nanoseconds) : std::nullopt};
      if (const auto known = placed_.find(key); known != placed_.end()) return known->second;
      if (const auto known = passing_.find(key); known != passing_.end()) return known->second;
      return std::nullopt;
    };
    const SceneStore::Entity* const entity = store_.EntityAt(pose_of, models_, at, radius_m);
    return entity == nullptr ? std::string() : entity->told;
  }
  [[nodiscard]] double next_change_s() const override {
    return std::min({end_s_, settling_.next_change_s(), wait_.next_change_s()});
  }

 private:
  /// A frame at a time, or now.
  using Key = std::pair<std::string, std::optional<std::int64_t>>;

  [[nodiscard]] std::string Unplaced() const {
    return why_ + " (Not shown: " + Counted(drawing_.unplaced, "entity", "entities") + " in " +
           drawing_.unplaced_frame + " and other frames.)";
  }

  [[nodiscard]] RigidTransform Place() const { return {{1, 0, 0, 0}, origin_}; }

  /// Whether a frame that entities are locked to has moved since they were drawn.
  [[nodiscard]] bool HasMoved(const UpdateContext& context) const {
    return std::ranges::any_of(placed_, [&](const auto& placed) {
      RigidTransform T_fixed_frame;
      std::string why;
      const auto& [frame, at] = placed.first;
      return !at && context.frame.Find(frame, T_fixed_frame, why) == FixedFrame::Answer::kFound &&
             !T_fixed_frame.Isometry().matrix().isApprox(placed.second.matrix(), 0);
    });
  }

  /// A past place of a frame is looked up once, because transforms are forgotten later. If the time is in the future or
  /// too long ago, the latest place is used.
  [[nodiscard]] std::optional<Eigen::Isometry3d> Find(const UpdateContext& context, const std::string& frame,
                                                      std::optional<Time> at,
                                                      std::map<Key, Eigen::Isometry3d>& placed) {
    const Key key{frame, at ? std::optional(at->nanoseconds) : std::nullopt};
    if (const auto known = placed.find(key); known != placed.end()) return known->second;
    if (const auto known = placed_.find(key); (at || stands_) && known != placed_.end()) {
      return placed.emplace(key, known->second).first->second;
    }
    if (const auto known = passing_.find(key); stands_ && known != passing_.end()) {
      provisional_ = true;
      return known->second;
    }
    RigidTransform T_fixed_frame;
    auto answer =
        at ? context.frame.Find(frame, *at, T_fixed_frame, why_) : context.frame.Find(frame, T_fixed_frame, why_);
    const bool later = at && answer == FixedFrame::Answer::kLater;
    if (at && answer != FixedFrame::Answer::kFound) answer = context.frame.Find(frame, T_fixed_frame, why_);
    if (answer != FixedFrame::Answer::kFound) return std::nullopt;
    if (!(T_fixed_frame.Isometry().translation().norm() < kTooFarMeters)) {
      why_ = "The frame " + frame + " is farther away than 10,000,000 km.";
      return std::nullopt;
    }
    if (later) {
      provisional_ = true;
      return passing_[key] = T_fixed_frame.Isometry();
    }
    return placed.emplace(key, T_fixed_frame.Isometry()).first->second;
  }

  void Rebuild(const UpdateContext& context) {
    provisional_ = false;
    if (!stands_) passing_.clear();
    why_.clear();
    std::map<Key, Eigen::Isometry3d> placed;
    const auto pose_of = [&](const std::string& frame, std::optional<Time> at) {
      return Find(context, frame, at, placed);
    };
    drawing_ = store_.Draw(pose_of, origin_);
    bounds_ = BoundsOf(drawing_.shapes);
    // Entities in a frame that is much too far away are not drawn: the origin could never return from there.
    const double far = bounds_.isEmpty() ? 0 : bounds_.center().norm();
    if (far > kFarMeters && far < kTooFarMeters) {
      origin_ += bounds_.center();
      drawing_ = store_.Draw(pose_of, origin_);
      bounds_ = BoundsOf(drawing_.shapes);
    }
    placed_ = std::move(placed);
    shapes_ = drawing_.shapes.size();
    const bool models = !drawing_.shapes.models.empty();
    model_fault_ = models_.AddTo(drawing_.shapes);
    if (models) bounds_ = BoundsOf(drawing_.shapes);
    if (!bounds_.isEmpty()) bounds_.translate(origin_);
    Fade(alpha_, drawing_.shapes);
    drawn_.Set(drawing_.shapes);
    labels_.clear();
    for (SceneText& text : drawing_.shapes.texts) {
      labels_.push_back({origin_ + text.pose.col(3), std::move(text.text), text.color, static_cast<float>(text.height),
                         !text.pixels});
    }
    drawing_.shapes = {};
  }

  const std::shared_ptr<Clock> clock_;
  SceneStore store_;
  SceneStore::Drawing drawing_;  ///< Without the data that is on the GPU.
  DrawnShapes drawn_;
  std::vector<Label> labels_;
  Settling settling_;
  TransformWait wait_;
  Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();
  Eigen::AlignedBox3d bounds_;
  std::map<Key, Eigen::Isometry3d> placed_;
  std::map<Key, Eigen::Isometry3d> passing_;  ///< Provisional places, while a transform is still missing.
  ModelMeshes models_;
  std::string fault_, model_fault_, why_;
  std::size_t shapes_ = 0;
  double end_s_ = std::numeric_limits<double>::infinity();
  bool outdated_ = false;
  bool provisional_ = false;  ///< Some transform is still missing.
  bool setting_changed_ = false;
  bool stands_ = false;  ///< No frame has moved.

  float alpha_ = 1;
  bool texts_ = true;

  std::shared_ptr<Inbox<Message>> inbox_ = std::make_shared<Inbox<Message>>(kMostUpdatesWaiting);
  Subscription subscription_;
};

}  // namespace

DisplayType SceneDisplayType() {
  return {"Scene", {"foxglove.SceneUpdate"}, [](const DisplayInputs& inputs) -> std::unique_ptr<Display> {
            return std::make_unique<EntityDisplay<foxglove::SceneUpdate>>(inputs);
          }};
}

DisplayType ShapesDisplayType() {
  return {"Shapes", {"hgros.Shapes"}, [](const DisplayInputs& inputs) -> std::unique_ptr<Display> {
            return std::make_unique<EntityDisplay<hgros::Shapes>>(inputs);
          }};
}

}  // namespace hgros::viewer
