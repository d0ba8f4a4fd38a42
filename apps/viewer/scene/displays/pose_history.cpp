#include "viewer/scene/displays/pose_history.hpp"

#include <algorithm>
#include <span>
#include <utility>

#include "viewer/data/bounds_of_most.hpp"
#include "viewer/data/quantity_text.hpp"

namespace hgros::viewer {

Change PoseHistory::Rewritten(double now_s) {
  rewritten_s_ = now_s;
  const bool was_settled = !moving_ && drawn_ > 0;
  moving_ = true;
  drawn_ = 0;
  return was_settled ? Change::kRedraw : Change::kMoving;
}

Change PoseHistory::TakeTransform(const UpdateContext& context) {
  if (poses_.poses().empty()) {
    placement_.Forget();
    return Change::kNothing;
  }
  const bool was_known = placement_.known();
  if (!placement_.Follow(frame_, context)) return Change::kNothing;
  return was_known ? Rewritten(context.now_s) : Change::kAppended;
}

Change PoseHistory::Update(const UpdateContext& context) {
  Change change = Change::kNothing;
  if (context.frame_changed) {
    placement_.Forget();
    change = drawn_ > 0 ? Change::kRedraw : Change::kMoving;
    drawn_ = 0;
    moving_ = false;
  }
  if (std::exchange(setting_changed_, false)) change = Change::kRedraw;
  const std::string frame_before = frame_;
  const std::size_t before = poses_.poses().size();
  PoseList::Change taken = TakeArrived(poses_, frame_);
  if (frame_ != frame_before) {
    placement_.Forget();
    taken = PoseList::Change::kRewritten;
  }
  if (taken != PoseList::Change::kNothing) KeepTimes(context.now_s);
  if (std::exchange(looking_back_, false)) taken = PoseList::Change::kRewritten;
  if (taken == PoseList::Change::kAppended) {
    strip_.Set(poses_.poses(), before);
    change = std::max(change, moving_ ? Change::kMoving : Change::kAppended);
  } else if (taken == PoseList::Change::kRewritten) {
    strip_.Set(poses_.poses());
    change = std::max(change, Rewritten(context.now_s));
  }
  change = std::max(change, TakeTransform(context));
  if (moving_ && context.now_s - rewritten_s_ >= kRestS) {
    moving_ = false;
    change = std::max(change, Change::kAppended);
  }
  return change;
}

void PoseHistory::KeepTimes(double now_s) {
  const std::size_t gone = std::min(poses_.removed() - removed_, times_s_.size());
  times_s_.erase(times_s_.begin(), times_s_.begin() + static_cast<std::ptrdiff_t>(gone));
  removed_ = poses_.removed();
  times_s_.resize(poses_.poses().size(), now_s);
}

Change PoseHistory::LookBack(double newest_s, double back_s) {
  const std::span<const PoseList::Pose> all(poses_.poses());
  const auto later = std::ranges::upper_bound(times_s_, newest_s - back_s);
  const std::size_t shown =
      back_s > 0 ? std::min(all.size(), static_cast<std::size_t>(later - times_s_.begin())) : all.size();
  looking_back_ = shown < all.size();
  if (shown == strip_.size()) return Change::kNothing;
  strip_.Set(all.first(shown));
  drawn_ = 0;
  return Change::kRedraw;
}

double PoseHistory::oldest_s() const {
  return times_s_.empty() ? std::numeric_limits<double>::infinity() : times_s_.front();
}

void PoseHistory::DrawFrom(const DrawContext& context, std::size_t first) {
  if (!placement_.known()) return;
  const RigidTransform T_fixed_poses = placement_.T_fixed_frame() * RigidTransform({1, 0, 0, 0}, poses_.origin());
  const float width = width_ * context.scale;
  if (style_ != kAxes) strip_.DrawLine(context.view, T_fixed_poses, color_, width, first);
  if (style_ != kLine) strip_.DrawAxes(context.view, T_fixed_poses, axes_meters_, width, first);
}

void PoseHistory::DrawNew(const DrawContext& context) {
  if (moving_ || !placement_.known()) return;
  DrawFrom(context, drawn_);
  drawn_ = strip_.size();
}

void PoseHistory::DrawSettled(const DrawContext& context, const Slice& slice) {
  if (moving_ || slice.index != 0 || !placement_.known()) return;
  DrawFrom(context, 0);
  drawn_ = strip_.size();
}

void PoseHistory::DrawMoving(const DrawContext& context) {
  if (moving_) DrawFrom(context, 0);
}

void PoseHistory::Clear() {
  poses_.Clear();
  times_s_.clear();
  looking_back_ = false;
  strip_.Set({});
  drawn_ = 0;
  moving_ = false;
  setting_changed_ = true;
}

std::vector<Setting> PoseHistory::Settings() {
  return {
      {"style", "A line through the poses, the axes of each, or both.",
       Setting::Choice{&style_, {"line", "axes", "both"}}},
      {"color",
       "The color of the line.",
       Setting::Color{&color_},
       [this] { return style_ != kAxes; },
       {{"style", {"both", "line"}}}},
      {"axes length",
       "The length of the axes.",
       Setting::Number{&axes_meters_, 0.001F, 100, "m"},
       [this] { return style_ != kLine; },
       {{"style", {"both", "axes"}}}},
      {"width", "The width of all lines.", Setting::Number{&width_, 1, 20, "px"}},
  };
}

void PoseHistory::OnSetting(const std::string& /*name*/) { setting_changed_ = true; }

std::vector<std::string> PoseHistory::Status() const {
  std::vector<std::string> lines;
  if (!placement_.fault().empty()) lines.push_back(placement_.fault());
  if (received() == 0) {
    lines.emplace_back("Nothing has arrived yet.");
  } else if (poses_.poses().empty()) {
    lines.emplace_back("The last message has no poses.");
  }
  lines.push_back(Counted(poses_.poses().size(), "pose", "poses") + " in " + (frame_.empty() ? "no frame" : frame_));
  if (poses_.left_out() > 0)
    lines.push_back(Counted(poses_.left_out(), "pose is not", "poses are not") + " made of numbers.");
  return lines;
}

Eigen::AlignedBox3d PoseHistory::Bounds() const {
  if (!placement_.known()) return {};
  std::vector<Eigen::AlignedBox3d> boxes;
  boxes.reserve(poses_.poses().size());
  for (const PoseList::Pose& pose : poses_.poses()) {
    boxes.emplace_back(Eigen::Vector3d(placement_.T_fixed_frame() * (poses_.origin() + pose.position.cast<double>())));
  }
  return BoundsOfMost(std::move(boxes));
}

double PoseHistory::next_change_s() const {
  const double rests_s = moving_ ? rewritten_s_ + kRestS : std::numeric_limits<double>::infinity();
  return poses_.poses().empty() ? rests_s : std::min(rests_s, placement_.next_change_s());
}

}  // namespace hgros::viewer
