#include "viewer/scene/displays/placed_display.hpp"

#include <algorithm>
#include <utility>

#include "viewer/data/quantity_text.hpp"

namespace hgros::viewer {

Change PlacedDisplay::Update(const UpdateContext& context) {
  Change change = std::exchange(setting_changed_, false) ? Change::kRedraw : Change::kNothing;
  if (context.frame_changed) change = std::max(change, settling_.Gone());
  bool replaced = false;
  if (auto fault = TakeArrived()) {
    fault_ = *std::move(fault);
    replaced = fault_.empty();
  }
  if (empty()) {
    placement_.Forget();
    return replaced ? std::max(change, settling_.Gone()) : change;
  }
  replaced |= placement_.Follow(frame(), context);
  if (!placement_.known()) {
    return settling_.settled() || settling_.moves() ? std::max(change, settling_.Gone()) : change;
  }
  if (blended()) {
    if (settling_.settled() || settling_.moves()) change = std::max(change, settling_.Gone());
    return replaced ? std::max(change, Change::kMoving) : change;
  }
  if (replaced || (!settling_.settled() && !settling_.moves())) {
    change = std::max(change, settling_.Replaced(context.now_s));
  }
  return std::max(change, settling_.Rest(context.now_s));
}

// It stays in its place, and in its layer unless that is the transparent one.
Change PlacedDisplay::ApplySettings(const UpdateContext& context) {
  if (!std::exchange(setting_changed_, false)) return Change::kNothing;
  if (auto fault = TakeAgain()) fault_ = *std::move(fault);
  if (empty() || !placement_.known() || blended()) {
    (void)settling_.Gone();
  } else if (!settling_.settled() && !settling_.moves()) {
    (void)settling_.Replaced(context.now_s);
  }
  return Change::kRedraw;
}

void PlacedDisplay::DrawNew(const DrawContext& context) {
  if (settling_.TakeNew()) Draw(context, T_fixed_corner(), {});
}

void PlacedDisplay::DrawSettled(const DrawContext& context, const Slice& slice) {
  if (settling_.TakeSettled()) Draw(context, T_fixed_corner(), slice);
}

void PlacedDisplay::DrawMoving(const DrawContext& context) {
  if (settling_.moves()) Draw(context, T_fixed_corner(), {});
}

void PlacedDisplay::DrawBlended(const DrawContext& context) { Draw(context, T_fixed_corner(), {}); }

void PlacedDisplay::Clear() {
  Forget();
  placement_.Forget();
  (void)settling_.Gone();
}

void PlacedDisplay::OnSetting(const std::string& name) {
  setting_changed_ = true;
  TakeSetting(name);
}

std::vector<std::string> PlacedDisplay::Status() const {
  std::vector<std::string> lines;
  if (!fault_.empty()) lines.push_back(fault_);
  if (!placement_.fault().empty()) lines.push_back(placement_.fault());
  if (received() == 0) {
    lines.emplace_back("Nothing has arrived yet.");
  } else if (empty()) {
    if (fault_.empty()) lines.emplace_back("The last message is empty.");
  } else {
    Describe(lines);
  }
  if (dropped() > 0) lines.push_back(Counted(dropped(), "message", "messages") + " arrived too fast.");
  return lines;
}

Eigen::AlignedBox3d PlacedDisplay::Bounds() const {
  if (!placement_.known() || empty()) return {};
  return box().transformed(T_fixed_corner().Isometry());
}

void ListFields(const std::vector<std::string>& fields, std::vector<std::string>& lines) {
  if (fields.size() < 2) return;
  std::string names = "There are:";
  for (const std::string& field : fields) names += " " + field;
  lines.push_back(std::move(names));
}

}  // namespace hgros::viewer
