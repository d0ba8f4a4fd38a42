#include "viewer/scene/displays/points_display.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <iterator>
#include <limits>
#include <string_view>
#include <utility>

#include "viewer/data/quantity_text.hpp"
#include "viewer/scene/settings/color_map_settings.hpp"

namespace hgros::viewer {
namespace {

constexpr std::size_t kMostMessagesWaiting = 64;
/// Each of these, once given, decides what the color shows.
constexpr std::array<std::string_view, 8> kColorSettings = {"color", "flat",       "axis",   "field",
                                                            "map",   "auto range", "lowest", "highest"};
constexpr std::size_t kKeepCapacity = 100'000;  // positions; memory for more is returned after they were placed

bool IsOfColor(std::string_view setting) { return std::ranges::find(kColorSettings, setting) != kColorSettings.end(); }

}  // namespace

Change PointsDisplay::Update(const UpdateContext& context) {
  Change change = context.frame_changed || context.transforms_changed ? PlaceAgain(context) : Change::kNothing;
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
    if (!empty_ && !std::exchange(color_given_, true) && !read.batch.colors.empty()) {
      color_by_ = static_cast<int>(ColorBy::kRgb);
    }
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

Change PointsDisplay::PlaceAgain(const UpdateContext& context) {
  if (context.frame_changed) axis_ranges_ = {};
  bool placed = recent_.PlaceAgain(context.frame, context.frame_changed, lost_);
  for (KeptPoints& kept : kept_) placed |= kept.PlaceAgain(context.frame, context.frame_changed, lost_);
  if (!context.frame_changed && !placed) return Change::kNothing;
  if (const Eigen::AlignedBox3d box = Bounds(); !box.isEmpty()) {
    const Eigen::AlignedBox3f ends = box.cast<float>();
    std::size_t messages = recent_.messages();
    for (const KeptPoints& kept : kept_) messages += kept.messages();
    const std::size_t shown = keep_ == kForEver ? ValueRange::kAllMessages : messages;
    for (int axis = 0; axis < 3; ++axis) {
      const std::array<float, 2> both = {ends.min()[axis], ends.max()[axis]};
      (void)axis_ranges_[static_cast<std::size_t>(axis)].Cover(both, shown, messages);
    }
  }
  return Change::kRedraw;
}

Change PointsDisplay::PlaceWaiting(const UpdateContext& context) {
  Change change = Change::kNothing;
  while (!waiting_.empty()) {
    Waiting& next = waiting_.front();
    context.frame.Saw(next.batch.frame);
    RigidTransform T_fixed_frame;
    std::string why;
    FixedFrame::Answer answer = context.frame.Find(next.batch.frame, next.batch.stamp, T_fixed_frame, why);
    const bool newest = waiting_.size() == 1;
    next.late = context.now_s - next.since_s >= kLongestWaitS;
    if (answer != FixedFrame::Answer::kFound && newest && next.late) {  // As grids are placed.
      std::string ignored;
      answer = context.frame.Find(next.batch.frame, T_fixed_frame, ignored);
    }
    if (answer == FixedFrame::Answer::kFound) {
      fault_.clear();
      if (keep_ != kForEver) lost_.clear();  // Older kept points still have no place.
      if (next.reported) --unplaced_;
      const bool recolored = Place(next.batch, T_fixed_frame, context);
      const Change placed = keep_ != kForEver ? Change::kMoving : recolored ? Change::kRedraw : Change::kAppended;
      change = std::max(change, placed);
    } else if (answer == FixedFrame::Answer::kLater && !next.late) {
      waits_for_ = std::move(why);
      break;  // Those after it are even later.
    } else {
      fault_ = std::move(why);
      waits_for_.clear();
      if (!std::exchange(next.reported, true)) ++unplaced_;
      if (newest) break;  // Its transform may still come.
    }
    waiting_.pop_front();
  }
  return change;
}

bool PointsDisplay::Place(const PointBatch& batch, const RigidTransform& T_fixed_frame, const UpdateContext& context) {
  const RigidTransform T_fixed_points = T_fixed_frame * batch.T_frame_points;
  const PlacedPoints placed(batch.positions, T_fixed_points);
  const std::size_t shown = keep_ == kForEver ? ValueRange::kAllMessages : recent_.messages() + 1;

  bool other_range = false;
  if (!placed.empty()) {
    std::vector<float> sample;
    const std::size_t step = std::max<std::size_t>(1, placed.size() / 4096);
    for (int axis = 0; axis < 3; ++axis) {
      sample.clear();
      for (std::size_t i = 0; i < placed.size(); i += step) sample.push_back(static_cast<float>(placed[i][axis]));
      const bool other = axis_ranges_[static_cast<std::size_t>(axis)].Cover(sample, shown);
      other_range |= other && color_by_ == static_cast<int>(ColorBy::kAxis) && axis == axis_;
    }
    other_range |= value_range_.Cover(batch.scalars, shown) && color_by_ == static_cast<int>(ColorBy::kScalar);
  }

  if (keep_ == kForEver) {
    Keep(placed, batch, context.frame.name());
  } else {
    recent_.Add(batch, context.frame.name(), T_fixed_frame, context.now_s);
  }
  return other_range && auto_range_;
}

void PointsDisplay::Keep(const PlacedPoints& placed, const PointBatch& batch, const std::string& fixed_frame) {
  if (placed.empty()) return;
  placed_.resize(placed.size());
  for (std::size_t i = 0; i < placed.size(); ++i) placed_[i] = placed[i];
  auto kept = std::ranges::find(kept_, fixed_frame, &KeptPoints::frame);
  if (kept == kept_.end()) {
    kept_.emplace_back(fixed_frame, !batch.scalars.empty(), !batch.colors.empty());
    kept = std::prev(kept_.end());
  }
  kept->Add(placed_, batch.scalars, batch.colors);
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
  for (KeptPoints& kept : kept_) kept.DrawNew(context.points, context.view, Style(context.scale));
}

void PointsDisplay::DrawSettled(const DrawContext& context, const Slice& slice) {
  for (KeptPoints& kept : kept_) kept.Draw(context.points, context.view, Style(context.scale), slice);
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
  for (const KeptPoints& kept : kept_) kept.Find(at, nearest);
  if (!nearest.value || shown_field_.empty()) return {};
  char text[64];
  std::snprintf(text, sizeof text, " = %.4g", static_cast<double>(*nearest.value));
  return shown_field_ + text;
}

std::optional<ColorLegend> PointsDisplay::Legend() const {
  if (!mapped() || points() == 0) return std::nullopt;
  const PointStyle style = Style(1);
  const bool by_axis = style.color_by == ColorBy::kAxis;
  if (!by_axis && shown_field_.empty()) return std::nullopt;
  return ColorLegend{by_axis ? std::string(1, "xyz"[axis_]) + " in m" : shown_field_, style.map, style.lo, style.hi};
}

void PointsDisplay::Clear() {
  kept_.clear();
  recent_.Clear();
  waiting_.clear();
  lost_.clear();
  axis_ranges_ = {};
  value_range_ = {};
}

std::vector<Setting> PointsDisplay::Settings() {
  const auto colored_by = [this](ColorBy by) { return [this, by] { return color_by_ == static_cast<int>(by); }; };
  const auto by_map = [this] { return mapped(); };
  const auto [map, automatic, lowest, highest] =
      ColorMapSettings({&map_, &auto_range_, &lo_, &hi_},
                       "The colors go from the lowest to the highest value, without the outer 2 % at each end, which "
                       "have the first and the last color.",
                       by_map, {"color", {"axis", "value"}});
  std::vector<Setting> settings = {
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
  for (Setting& setting : settings) setting.decided = color_given_ || !IsOfColor(setting.name);
  return settings;
}

void PointsDisplay::OnSetting(const std::string& name) {
  setting_changed_ = true;
  if (IsOfColor(name)) color_given_ = true;
  if (name == "keep") {
    Clear();
  } else if (name == "field") {
    value_range_ = {};
    Clear();
  }
}

std::vector<std::string> PointsDisplay::Status() const {
  std::vector<std::string> lines;
  for (const std::string& fault : {fault_, lost_}) {
    if (!fault.empty()) lines.push_back(fault);
  }
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
  for (const KeptPoints& kept : kept_) bounds.extend(kept.Bounds());
  return bounds;
}

std::size_t PointsDisplay::settled_points() const {
  std::size_t points = 0;
  for (const KeptPoints& kept : kept_) points += kept.points();
  return points;
}

std::size_t PointsDisplay::gpu_bytes() const {
  std::size_t bytes = recent_.gpu_bytes();
  for (const KeptPoints& kept : kept_) bytes += kept.gpu_bytes();
  return bytes;
}

double PointsDisplay::next_change_s() const {
  double next = std::numeric_limits<double>::infinity();
  if (keep_ == kTime) next = recent_.oldest_s() + keep_s_;
  if (!waiting_.empty() && !waiting_.front().late) next = std::min(next, waiting_.front().since_s + kLongestWaitS);
  return next;
}

}  // namespace hgros::viewer
