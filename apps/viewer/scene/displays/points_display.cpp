#include "viewer/scene/displays/points_display.hpp"

#include <algorithm>
#include <cstdio>
#include <limits>
#include <utility>

#include "viewer/data/quantity_text.hpp"
#include "viewer/scene/settings/color_map_settings.hpp"

namespace hgros::viewer {
namespace {

constexpr std::size_t kMostMessagesWaiting = 64;
constexpr std::size_t kKeepCapacity = 100'000;  // positions; memory for more is returned after they were placed

}  // namespace

Change PointsDisplay::Update(const UpdateContext& context) {
  Change change = Change::kNothing;
  if (context.frame_changed) {
    Clear();
    change = Change::kRedraw;
  }
  if (std::exchange(setting_changed_, false)) change = Change::kRedraw;
  for (Read& read : ReadArrived(field_, MostMessages())) {
    if (!read.fault.empty()) {
      fault_ = std::move(read.fault);
      continue;
    }
    if (!read.batch.fields.empty()) fields_ = read.batch.fields;
    shown_field_ = read.batch.scalar_name;
    frame_ = read.batch.frame;
    empty_ = read.batch.positions.empty();
    if (waiting_.size() == kMostMessagesWaiting) {
      waiting_.pop_front();
      ++unplaced_;
    }
    waiting_.push_back({std::move(read.batch), context.now_s});
  }
  change = std::max(change, PlaceWaiting(context));
  const double oldest_s = keep_ == kTime ? context.now_s - keep_s_ : -std::numeric_limits<double>::infinity();
  const bool gone = keep_ != kForEver && recent_.Expire(MostMessages(), oldest_s);
  return gone ? std::max(change, Change::kMoving) : change;
}

std::size_t PointsDisplay::MostMessages() const {
  if (keep_ == kLatest) return 1;
  return keep_ == kCount ? static_cast<std::size_t>(std::max(1.0F, keep_count_))
                         : std::numeric_limits<std::size_t>::max();
}

Change PointsDisplay::PlaceWaiting(const UpdateContext& context) {
  Change change = Change::kNothing;
  while (!waiting_.empty()) {
    const Waiting& next = waiting_.front();
    context.frame.Saw(next.batch.frame);
    RigidTransform T_fixed_frame;
    std::string why;
    const FixedFrame::Answer answer = context.frame.Find(next.batch.frame, next.batch.stamp, T_fixed_frame, why);
    if (answer == FixedFrame::Answer::kFound) {
      fault_.clear();
      const bool recolored = Place(next.batch, T_fixed_frame, context.now_s);
      const Change placed = keep_ != kForEver ? Change::kMoving : recolored ? Change::kRedraw : Change::kAppended;
      change = std::max(change, placed);
    } else {
      const bool patient = answer == FixedFrame::Answer::kLater && context.now_s - next.since_s < kLongestWaitS;
      if (patient) {
        waits_for_ = std::move(why);
        break;  // Those after it are even later.
      }
      fault_ = std::move(why);
      ++unplaced_;
    }
    waiting_.pop_front();
  }
  return change;
}

bool PointsDisplay::Place(const PointBatch& batch, const RigidTransform& T_fixed_frame, double now_s) {
  const RigidTransform T_fixed_points = T_fixed_frame * batch.T_frame_points;
  const PlacedPoints placed(batch.positions, T_fixed_points);

  bool other_range = false;
  if (!placed.empty()) {
    std::vector<float> sample;
    const std::size_t step = std::max<std::size_t>(1, placed.size() / 4096);
    for (int axis = 0; axis < 3; ++axis) {
      sample.clear();
      for (std::size_t i = 0; i < placed.size(); i += step) sample.push_back(static_cast<float>(placed[i][axis]));
      const bool other = axis_ranges_[static_cast<std::size_t>(axis)].Cover(sample);
      other_range |= other && color_by_ == static_cast<int>(ColorBy::kAxis) && axis == axis_;
    }
    other_range |= value_range_.Cover(batch.scalars) && color_by_ == static_cast<int>(ColorBy::kScalar);
  }

  if (keep_ == kForEver) {
    Keep(placed, batch);
  } else {
    recent_.Add(placed, batch.scalars, batch.colors, now_s);
  }
  return other_range && auto_range_;
}

void PointsDisplay::Keep(const PlacedPoints& placed, const PointBatch& batch) {
  placed_.resize(placed.size());
  for (std::size_t i = 0; i < placed.size(); ++i) placed_[i] = placed[i];
  if (!kept_ && !placed_.empty()) {
    Eigen::AlignedBox3d box;
    for (const Eigen::Vector3d& at : placed_) box.extend(at);
    kept_ = std::make_unique<KeptPoints>(PageBook::CellFor(box.sizes().maxCoeff()), !batch.scalars.empty(),
                                         !batch.colors.empty());
  }
  if (kept_) kept_->Add(placed_, batch.scalars, batch.colors);
  placed_.clear();
  if (placed_.capacity() > kKeepCapacity) placed_.shrink_to_fit();
}

PointStyle PointsDisplay::Style(float scale) const {
  PointStyle style;
  style.color_by = static_cast<ColorBy>(color_by_);
  style.flat = flat_;
  style.axis = axis_;
  style.map = static_cast<ColorMap>(map_);
  const ValueRange& range =
      style.color_by == ColorBy::kScalar ? value_range_ : axis_ranges_[static_cast<std::size_t>(axis_)];
  style.lo = auto_range_ ? range.lo() : lo_;
  style.hi = auto_range_ ? range.hi() : hi_;
  style.size_in_meters = size_unit_ == 1;
  style.size = style.size_in_meters ? size_ : size_ * scale;
  return style;
}

void PointsDisplay::DrawNew(const DrawContext& context) {
  if (kept_) kept_->DrawNew(context.points, context.view, Style(context.scale));
}

void PointsDisplay::DrawSettled(const DrawContext& context, const Slice& slice) {
  if (kept_) kept_->Draw(context.points, context.view, Style(context.scale), slice);
}

void PointsDisplay::DrawMoving(const DrawContext& context) {
  recent_.Draw(context.points, context.view, Style(context.scale), {0, context.moving_thinned}, shown_until_s_);
}

Change PointsDisplay::LookBack(double newest_s, double back_s) {
  const double until_s = back_s > 0 ? newest_s - back_s : std::numeric_limits<double>::infinity();
  if (std::exchange(shown_until_s_, until_s) == until_s || recent_.points() == 0) return Change::kNothing;
  return Change::kMoving;
}

std::string PointsDisplay::ValueAt(const Eigen::Vector3d& at, double radius_m) const {
  NearestPoint nearest{radius_m, std::nullopt};
  recent_.Find(at, shown_until_s_, nearest);
  if (kept_) kept_->Find(at, nearest);
  if (!nearest.value || shown_field_.empty()) return {};
  char text[64];
  std::snprintf(text, sizeof text, " = %.4g", static_cast<double>(*nearest.value));
  return shown_field_ + text;
}

void PointsDisplay::Clear() {
  kept_.reset();
  recent_.Clear();
  waiting_.clear();
  axis_ranges_ = {};
  value_range_ = {};
}

std::vector<Setting> PointsDisplay::Settings() {
  const auto colored_by = [this](ColorBy by) { return [this, by] { return color_by_ == static_cast<int>(by); }; };
  const auto mapped = [this] {
    return color_by_ == static_cast<int>(ColorBy::kAxis) || color_by_ == static_cast<int>(ColorBy::kScalar);
  };
  const auto [map, automatic, lowest, highest] =
      ColorMapSettings({&map_, &auto_range_, &lo_, &hi_},
                       "The colors go from the lowest to the highest value so far, without the outer 2 % at "
                       "each end, which have the first and the last color.",
                       mapped, {"color", {"axis", "value"}});
  return {
      {"keep", "Which points stay: those of the latest message, of some messages, of some time, or all.",
       Setting::Choice{&keep_, {"latest", "count", "time", "all"}}},
      {"count",
       "Number of recent messages kept.",
       Setting::Number{&keep_count_, 1, 10000, ""},
       [this] { return keep_ == kCount; },
       {{"keep", {"count"}}}},
      {"seconds",
       "How long messages are kept.",
       Setting::Number{&keep_s_, 0.1F, 3600, "s"},
       [this] { return keep_ == kTime; },
       {{"keep", {"time"}}}},
      {"color", "What the color shows.", Setting::Choice{&color_by_, {"flat", "axis", "value", "rgb"}}},
      {"flat", "The color of all points.", Setting::Color{&flat_}, colored_by(ColorBy::kFlat), {{"color", {"flat"}}}},
      {"axis",
       "The axis of the fixed frame whose coordinate is shown.",
       Setting::Choice{&axis_, {"x", "y", "z"}},
       colored_by(ColorBy::kAxis),
       {{"color", {"axis"}}}},
      {"field",
       "The field whose value is shown; empty: intensity. A change clears kept points.",
       Setting::Text{&field_},
       colored_by(ColorBy::kScalar),
       {{"color", {"value"}}}},
      map,
      automatic,
      lowest,
      highest,
      {"size", "The size of a point.", Setting::Number{&size_, 0.001F, 64, ""}},
      {"unit", "The unit of the size: pixels on the screen, or meters in the scene.",
       Setting::Choice{&size_unit_, {"px", "m"}}},
  };
}

void PointsDisplay::OnSetting(const std::string& name) {
  setting_changed_ = true;
  if (name == "keep") {
    Clear();
  } else if (name == "field") {
    value_range_ = {};
    Clear();
  }
}

std::vector<std::string> PointsDisplay::Status() const {
  std::vector<std::string> lines;
  if (!fault_.empty()) lines.push_back(fault_);
  if (received() == 0) lines.emplace_back("Nothing has arrived yet.");
  if (empty_ && fault_.empty()) lines.emplace_back("The last message has no points.");
  lines.push_back(Counted(points(), "point", "points"));
  if (color_by_ == static_cast<int>(ColorBy::kScalar)) {
    lines.push_back(shown_field_.empty() ? "The points have no such value." : "The value is " + shown_field_ + ".");
    if (!fields_.empty()) {
      std::string names = "There are:";
      for (const std::string& field : fields_) names += " " + field;
      lines.push_back(std::move(names));
    }
  }
  std::string lost;
  if (dropped() > 0) lost = Counted(dropped(), "message", "messages") + " arrived too fast";
  if (dropped() > 0 && unplaced_ > 0) {
    lost += ", " + std::to_string(unplaced_) + " had no transform";
  } else if (unplaced_ > 0) {
    lost = Counted(unplaced_, "message", "messages") + " had no transform";
  }
  if (!lost.empty()) lines.push_back(lost + ".");
  return lines;
}

Eigen::AlignedBox3d PointsDisplay::Bounds() const {
  Eigen::AlignedBox3d bounds = recent_.Bounds();
  if (kept_) bounds.extend(kept_->Bounds());
  return bounds;
}

double PointsDisplay::next_change_s() const {
  double next = std::numeric_limits<double>::infinity();
  if (keep_ == kTime) next = recent_.oldest_s() + keep_s_;
  if (!waiting_.empty()) next = std::min(next, waiting_.front().since_s + kLongestWaitS);
  return next;
}

}  // namespace hgros::viewer
