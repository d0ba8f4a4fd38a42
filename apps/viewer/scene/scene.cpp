#include "viewer/scene/scene.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "viewer/data/bounds_of_most.hpp"
#include "viewer/scene/blending_order.hpp"

namespace hgros::viewer {
namespace {

constexpr float kBackground[3] = {0.105F, 0.115F, 0.13F};
constexpr double kSliceMs = 60;                  // time for a slice, so that a moving camera stays smooth
constexpr double kMovingMs = 60;                 // time for the moving layer in every frame
constexpr std::size_t kSmallestSlice = 100'000;  // points
constexpr std::size_t kWorthMeasuring = 50'000;  // points

}  // namespace

Scene::Entry& Scene::Add(const DisplayType& type, const DisplayInputs& inputs) {
  Entry entry;
  entry.name = inputs.channel.empty() ? type.name : inputs.channel;
  entry.channel = inputs.channel;
  entry.type = &type;
  const auto has_number = [&](const Entry& other) { return other.type == &type && other.number == entry.number; };
  while (std::ranges::any_of(entries_, has_number)) ++entry.number;
  DisplayInputs numbered = inputs;
  numbered.number = entry.number;
  entry.display = type.make(numbered);
  entries_.push_back(std::move(entry));
  Redraw();
  return entries_.back();
}

void Scene::Remove(std::size_t index) {
  entries_.erase(entries_.begin() + static_cast<std::ptrdiff_t>(index));
  Redraw();
}

void Scene::MoveUp(std::size_t index) {
  if (index == 0 || index >= entries_.size()) return;
  std::swap(entries_[index - 1], entries_[index]);
  Redraw();
}

void Scene::SetVisible(std::size_t index, bool visible) {
  entries_[index].visible = visible;
  Redraw();
}

void Scene::Update(const UpdateContext& context) {
  for (Entry& entry : entries_) {
    const bool had_fault = entry.display->HasFault();
    const Change change = entry.display->Update(context);
    if (entry.visible) pending_ = std::max(pending_, change);
    // Its row changes its color.
    if (entry.display->HasFault() != had_fault) pending_ = std::max(pending_, Change::kMoving);
  }
}

void Scene::ApplySettings(const UpdateContext& context) {
  for (Entry& entry : entries_) {
    const Change change = entry.display->ApplySettings(context);
    if (entry.visible) pending_ = std::max(pending_, change);
  }
}

void Scene::LookBack(double newest_s, double back_s) {
  for (Entry& entry : entries_) {
    const Change change = entry.display->LookBack(newest_s, back_s);
    if (entry.visible) pending_ = std::max(pending_, change);
  }
}

double Scene::oldest_s() const {
  double oldest = std::numeric_limits<double>::infinity();
  for (const Entry& entry : entries_) {
    if (entry.visible) oldest = std::min(oldest, entry.display->oldest_s());
  }
  return oldest;
}

double Scene::truthful_since_s() const {
  double since = -std::numeric_limits<double>::infinity();
  for (const Entry& entry : entries_) {
    if (entry.visible) since = std::max(since, entry.display->truthful_since_s());
  }
  return since;
}

float Scene::NearestDepth(const ViewMatrices& view, float scale, int& x, int& y, int radius) {
  if (Moved(view) || picture_.size() != view.viewport) Draw(view, scale);
  if (std::ranges::none_of(entries_, [](const Entry& entry) { return entry.visible && entry.display->blends(); })) {
    return picture_.NearestDepth(x, y, radius);
  }
  Picture probe;
  probe.Resize(view.viewport);
  picture_.CopyTo(probe);
  probe.Bind();
  glEnable(GL_SCISSOR_TEST);
  glScissor(x - radius, view.viewport.height - 1 - y - radius, 2 * radius + 1, 2 * radius + 1);
  DrawBlended({.view = view, .points = points_, .scale = scale, .marks_depth = true});
  glDisable(GL_SCISSOR_TEST);
  return probe.NearestDepth(x, y, radius);
}

float Scene::DepthAlone(Display& display, const DrawContext& context, Picture& probe, int x, int y) {
  probe.Bind();
  probe.Clear(kBackground);
  display.DrawSettled(context, {});
  display.DrawMoving(context);
  if (display.blends()) display.DrawBlended(context);
  return probe.NearestDepth(x, y, 0);
}

const Scene::Entry* Scene::FindAt(const ViewMatrices& view, float scale, int x, int y, float& depth,
                                  bool only_moved_back) {
  constexpr float kSameDepth = 1e-6F;
  const auto may_be_there = [&](const Entry& entry) {
    return entry.visible && (!only_moved_back || entry.display->moves_back());
  };
  if (std::ranges::none_of(entries_, may_be_there)) return nullptr;
  Picture probe;
  probe.Resize(view.viewport);
  DrawContext context{.view = view, .points = points_, .scale = scale, .marks_depth = true};
  const Entry* found = nullptr;
  glEnable(GL_SCISSOR_TEST);
  glScissor(x, view.viewport.height - 1 - y, 1, 1);
  // Their bounds say nothing here: they leave out what is far from all else, which can be seen nevertheless.
  for (const Entry& entry : entries_) {
    if (!may_be_there(entry)) continue;
    if (std::abs(DepthAlone(*entry.display, context, probe, x, y) - depth) < kSameDepth) found = &entry;
  }
  if (found != nullptr && found->display->moves_back()) {
    context.true_depth = true;
    depth = std::min(depth, DepthAlone(*found->display, context, probe, x, y));
  }
  glDisable(GL_SCISSOR_TEST);
  if (pending()) Redraw();  // New data of a display may have been drawn into the probe.
  return found;
}

void Scene::CountDropped() {
  for (Entry& entry : entries_) entry.dropped_before = entry.display->dropped();
}

std::uint64_t Scene::dropped() const {
  std::uint64_t dropped = 0;
  for (const Entry& entry : entries_) dropped += entry.display->dropped() - entry.dropped_before;
  return dropped;
}

void Scene::DrawSlice(const DrawContext& context) {
  std::size_t drawn = 0;
  for (const Entry& entry : entries_) {
    if (entry.visible) drawn += entry.display->settled_points() / slices_;
  }
  const auto begin = std::chrono::steady_clock::now();
  for (Entry& entry : entries_) {
    if (entry.visible) entry.display->DrawSettled(context, {next_slice_, slices_});
  }
  ++next_slice_;
  if (drawn < kWorthMeasuring) return;
  Measure(drawn, begin);
}

void Scene::DrawMoving(const DrawContext& context) {
  std::size_t drawn = 0;
  for (const Entry& entry : entries_) {
    if (entry.visible) drawn += entry.display->moving_points() / context.moving_thinned;
  }
  const auto begin = std::chrono::steady_clock::now();
  for (Entry& entry : entries_) {
    if (entry.visible) entry.display->DrawMoving(context);
  }
  if (drawn >= kWorthMeasuring) Measure(drawn, begin);
  DrawBlended(context);
}

void Scene::DrawBlended(const DrawContext& context) {
  std::vector<Display*> blended;
  std::vector<Eigen::AlignedBox3d> boxes;
  for (Entry& entry : entries_) {
    if (!entry.visible || !entry.display->blends()) continue;
    blended.push_back(entry.display.get());
    boxes.push_back(entry.display->Bounds());
  }
  for (const std::size_t i : BlendingOrder(boxes, context.view.eye)) blended[i]->DrawBlended(context);
}

void Scene::Measure(std::size_t drawn, std::chrono::steady_clock::time_point begin) {
  glFinish();
  const double ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
  points_per_ms_ = 0.5 * points_per_ms_ + 0.5 * static_cast<double>(drawn) / std::max(ms, 0.01);
}

std::size_t Scene::Affordable(double ms) const {
  return std::max(kSmallestSlice, static_cast<std::size_t>(points_per_ms_ * ms));
}

void Scene::Draw(const ViewMatrices& view, float scale) {
  const bool resized = settled_.Resize(view.viewport);
  picture_.Resize(view.viewport);
  const Change change = std::exchange(pending_, Change::kNothing);
  std::size_t moving = 0;
  for (const Entry& entry : entries_) {
    if (entry.visible) moving += entry.display->moving_points();
  }
  const DrawContext context{view, points_, scale, moving / Affordable(kMovingMs) + 1};
  if (resized || Moved(view) || change == Change::kRedraw) {
    drawn_clip_ = view.clip_from_eye;
    drawn_eye_ = view.eye;
    std::size_t total = 0;
    for (const Entry& entry : entries_) {
      if (entry.visible) total += entry.display->settled_points();
    }
    slices_ = total / Affordable(kSliceMs) + 1;
    next_slice_ = 0;
    settled_.Clear(kBackground);
    DrawSlice(context);
  } else {
    settled_.Bind();
    if (change == Change::kAppended) {
      for (Entry& entry : entries_) {
        if (entry.visible) entry.display->DrawNew(context);
      }
    }
    if (unfinished()) DrawSlice(context);
  }
  settled_.CopyTo(picture_);
  picture_.Bind();
  DrawMoving(context);
}

std::size_t Scene::points() const {
  std::size_t points = 0;
  for (const Entry& entry : entries_) points += entry.display->points();
  return points;
}

std::size_t Scene::gpu_bytes() const {
  std::size_t bytes = 0;
  for (const Entry& entry : entries_) bytes += entry.display->gpu_bytes();
  return bytes;
}

Eigen::AlignedBox3d Scene::Bounds() const {
  std::vector<Eigen::AlignedBox3d> boxes;
  for (const Entry& entry : entries_) {
    if (entry.visible) boxes.push_back(entry.display->Bounds());
  }
  return BoundsOfMost(std::move(boxes));
}

double Scene::next_change_s() const {
  double next = std::numeric_limits<double>::infinity();
  for (const Entry& entry : entries_) {
    if (entry.visible) next = std::min(next, entry.display->next_change_s());
  }
  return next;
}

std::vector<Label> Scene::Labels() const {
  std::vector<Label> all;
  for (const Entry& entry : entries_) {
    if (!entry.visible) continue;
    for (Label& label : entry.display->Labels()) all.push_back(std::move(label));
  }
  return all;
}

}  // namespace hgros::viewer
