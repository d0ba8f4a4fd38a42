#include "tf/tree/tree_core.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "hgros/base/error.hpp"
#include "hgros/base/names.hpp"
#include "tf/tree/edge_reading.hpp"
#include "tf/tree/edge_writing.hpp"

namespace hgros::tf {
namespace {

std::uint64_t NextTreeNumber() {
  static std::atomic<std::uint64_t> last{0};
  return last.fetch_add(1, std::memory_order_relaxed) + 1;
}

constexpr double kUnitTolerance = 1e-3;
// In meters, along each axis. Lookups multiply and add translations, which must stay finite.
constexpr double kFarthest = 1e12;
// Limits the time for an edge or a lookup, also if a peer sends a long chain.
constexpr std::size_t kMostEdgesDown = 1000;

// With a rotation of exactly unit length; false if it is too far from that, or not a number.
bool MakeUnit(Pose& pose) {
  const double square = pose.w * pose.w + pose.x * pose.x + pose.y * pose.y + pose.z * pose.z;
  const double off = square - 1;
  if (!(std::abs(off) <= 2 * kUnitTolerance)) return false;
  // Near 1 the first terms of the series of 1 / sqrt are exact to the last bit.
  const double scale = std::abs(off) < 1e-8 ? 1 - 0.5 * off : 1 / std::sqrt(square);
  pose.w *= scale;
  pose.x *= scale;
  pose.y *= scale;
  pose.z *= scale;
  return true;
}

Frame* Above(const Frame* frame) { return frame->parent.load(std::memory_order_relaxed); }

// The edges from the root down to the lowest frame, if `below` hung from `above`; null: a new frame. Under topology_.
std::size_t EdgesDown(const Frame* above, const Frame* below) {
  std::size_t edges = (below == nullptr ? 0 : below->height) + (above == nullptr ? 1 : 0);
  for (; above != nullptr; above = Above(above)) ++edges;
  return edges;
}

SetFault PoseFault(Pose& pose) {
  if (!MakeUnit(pose)) return SetFault::kRotation;
  const bool near = std::abs(pose.px) <= kFarthest && std::abs(pose.py) <= kFarthest && std::abs(pose.pz) <= kFarthest;
  return near ? SetFault::kNone : SetFault::kTranslation;  // A NaN is not near, either.
}

}  // namespace

TreeCore::TreeCore(const TransformTreeOptions& options)
    : limits_{std::max<std::int64_t>(options.buffer.count(), 0),
              std::max<std::uint64_t>(options.max_transforms_per_edge, 2)},
      number_(NextTreeNumber()),
      frames_(options.max_frames),
      publishers_{""},
      waits_(std::make_shared<Waits>(*this)) {}

TreeCore::~TreeCore() { waits_->Close(); }

PublisherId TreeCore::Publisher(std::string_view name) {
  if (name.empty()) return {};
  const std::scoped_lock lock(publishers_mutex_);
  const auto place = std::find(publishers_.begin(), publishers_.end(), name);
  const auto number = static_cast<std::uint32_t>(place - publishers_.begin());
  if (place == publishers_.end()) publishers_.emplace_back(name);
  return {number};
}

SetResult TreeCore::Set(FrameId parent, FrameId child, const EdgeValue& value) {
  Frame* above = frames_.At(parent);
  Frame* below = frames_.At(child);
  if (above != nullptr && below != nullptr) return SetFrames(*above, *below, value);
  return {SetFault::kName, std::string("The edge from ") +
                               (above == nullptr ? "an unknown id" : "\"" + above->name + "\"") + " to " +
                               (below == nullptr ? "an unknown id" : "\"" + below->name + "\"") +
                               " was refused: such an id is not of this tree; use an id that Frame returned."};
}

SetResult TreeCore::Set(std::string_view parent, std::string_view child, const EdgeValue& value,
                        std::string_view publisher) {
  Frame* above = frames_.Find(parent);
  Frame* below = frames_.Find(child);
  for (const auto& [frame, name] : {std::pair(above, parent), std::pair(below, child)}) {
    if (frame != nullptr) continue;
    if (const std::string fault = ChannelNameFault(name); !fault.empty()) {
      return {SetFault::kName, "The edge from \"" + std::string(parent.substr(0, 200)) + "\" to \"" +
                                   std::string(child.substr(0, 200)) + "\" was refused: the " +
                                   (name.data() == parent.data() && frame == above ? "parent's" : "child's") +
                                   " name is invalid: " + fault + "."};
    }
  }
  if (above == nullptr || below == nullptr) {  // A refused transform leaves no frames behind.
    Pose pose = PoseOf(value.T_parent_child);
    SetFault fault = PoseFault(pose);
    if (fault == SetFault::kNone && parent == child) fault = SetFault::kCycle;
    const bool hangs = below != nullptr && below->parent.load(std::memory_order_acquire) != nullptr;
    if (fault == SetFault::kNone && hangs) fault = SetFault::kTwoParents;
    if (fault == SetFault::kNone) {
      const std::scoped_lock lock(topology_);
      if (EdgesDown(above, below) > kMostEdgesDown) fault = SetFault::kTooDeep;
    }
    const std::size_t missing = (above == nullptr ? 1 : 0) + (below == nullptr ? 1 : 0);
    if (fault == SetFault::kNone && frames_.size() + missing > frames_.most()) fault = SetFault::kTooManyFrames;
    if (fault == SetFault::kNone && (above = frames_.Intern(parent)) != nullptr) below = frames_.Intern(child);
    if (fault == SetFault::kNone && (above == nullptr || below == nullptr)) fault = SetFault::kTooManyFrames;
    if (fault != SetFault::kNone) {
      Frame upper;
      upper.name = parent;
      Frame lower;
      lower.name = child;
      return Refuse(fault, upper, hangs ? *below : (parent == child ? upper : lower), value);
    }
  }
  EdgeValue named = value;
  if (!publisher.empty()) named.publisher = Publisher(publisher);
  return SetFrames(*above, *below, named);
}

SetResult TreeCore::SetFrames(Frame& parent, Frame& child, const EdgeValue& value) {
  Pose pose = PoseOf(value.T_parent_child);
  SetFault fault = PoseFault(pose);
  const Frame* now = child.parent.load(std::memory_order_acquire);
  if (fault == SetFault::kNone && now == nullptr) {
    fault = Connect(parent, child, value, pose);
    if (fault == SetFault::kNone) return {};
    now = child.parent.load(std::memory_order_acquire);
    if (now == &parent) fault = SetFault::kNone;  // Another thread was first; this is a further transform.
  }
  if (fault != SetFault::kNone) return Refuse(fault, parent, child, value);
  if (now != &parent) return Refuse(SetFault::kTwoParents, parent, child, value);
  if (child.is_static != value.is_static) return Refuse(SetFault::kStatic, parent, child, value);

  bool awaited = false;
  bool restarts = false;
  bool jumped = false;
  {
    const std::scoped_lock lock(child.write);
    const std::uint64_t time = time_.load(std::memory_order_acquire);
    jumped = HasJumped(child, value);
    const bool begins = jumped || IsRestarting(child);
    restarts = jumped || (begins && value.stamp <= restart_limit_.load(std::memory_order_relaxed));
    // A later stamp counts as one from before the jump, unless it is too old for the edge.
    const bool written = !restarts && Write(child, {value.stamp, pose});
    if (begins && !written) {
      restarts = true;
      child.time = time;
      child.jumps.Begin(value.publisher);
      restarted_edges_.fetch_add(1, std::memory_order_relaxed);
      Rewrite(child, {value.stamp, pose});
    }
    if (restarts || written) {
      awaited = child.newest >= child.awaited_from;
      if (value.publisher.value != 0) child.publisher.store(value.publisher.value, std::memory_order_relaxed);
    } else {
      fault = SetFault::kTooOld;
    }
  }
  if (restarts) {
    waits_->EdgeHasRestarted();
  } else if (awaited) {
    waits_->EdgeHasGrown(child);
  }
  return fault == SetFault::kNone ? SetResult::Stored(jumped) : Refuse(fault, parent, child, value);
}

bool TreeCore::HasJumped(Frame& edge, const EdgeValue& value) noexcept {
  if (value.is_static || value.stamp >= edge.newest) {
    edge.jumps.Begin(value.publisher);
    return false;
  }
  return edge.jumps.HasJumped(edge.newest, value.stamp, value.publisher, std::chrono::steady_clock::now());
}

bool TreeCore::RestartEdge(std::string_view child, std::int64_t possible) noexcept {
  Frame* const edge = frames_.Find(child);
  if (edge == nullptr || edge->parent.load(std::memory_order_acquire) == nullptr) return false;
  const std::scoped_lock lock(edge->write);
  if (edge->is_static || edge->newest <= possible) return false;
  edge->time = time_.load(std::memory_order_acquire) - 1;
  return true;
}

SetFault TreeCore::Connect(Frame& parent, Frame& child, const EdgeValue& value, const Pose& pose) {
  bool awaited = false;
  {
    const std::scoped_lock lock(topology_);
    for (const Frame* frame = &parent; frame != nullptr; frame = Above(frame)) {
      if (frame == &child) return SetFault::kCycle;
    }
    if (Above(&child) != nullptr) return SetFault::kTwoParents;
    if (EdgesDown(&parent, &child) > kMostEdgesDown) return SetFault::kTooDeep;
    {
      const std::scoped_lock write(child.write);
      child.time = time_.load(std::memory_order_relaxed);
      BeginEdge(child, value.is_static, limits_, {value.is_static ? 0 : value.stamp, pose});
      child.jumps.Begin(value.publisher);
      child.publisher.store(value.publisher.value, std::memory_order_relaxed);
    }
    child.parent.store(&parent, std::memory_order_release);
    std::uint32_t height = child.height + 1;
    for (Frame* frame = &parent; frame != nullptr && frame->height < height; frame = Above(frame)) {
      frame->height = height++;
    }
    child.known.store(true, std::memory_order_release);
    parent.known.store(true, std::memory_order_release);
    ++edge_count_;
    awaited = std::exchange(edges_are_awaited_, false);
  }
  if (awaited) waits_->TreeHasGrown();
  return SetFault::kNone;
}

std::vector<EdgeSnapshot> TreeCore::Edges() const {
  std::vector<EdgeSnapshot> edges;
  std::vector<std::string> publishers;
  {
    const std::scoped_lock lock(publishers_mutex_);
    publishers = publishers_;
  }
  std::vector<std::vector<const Frame*>> children(frames_.size());
  std::vector<const Frame*> to_visit;
  for (std::uint32_t i = 0; i < children.size(); ++i) {
    const Frame* frame = frames_.At(FrameId{i});
    const Frame* parent = frame->parent.load(std::memory_order_acquire);
    if (parent == nullptr) {
      to_visit.push_back(frame);
    } else if (parent->id.value < children.size()) {
      children[parent->id.value].push_back(frame);
    }
  }
  const auto by_falling_name = [](const Frame* a, const Frame* b) { return a->name > b->name; };
  std::sort(to_visit.begin(), to_visit.end(), by_falling_name);
  while (!to_visit.empty()) {
    const Frame* parent = to_visit.back();
    to_visit.pop_back();
    if (const Frame* above = parent->parent.load(std::memory_order_acquire)) {
      EdgeSnapshot edge;
      edge.parent = above->name;
      edge.child = parent->name;
      const std::uint32_t publisher = parent->publisher.load(std::memory_order_relaxed);
      if (publisher < publishers.size()) edge.publisher = publishers[publisher];
      edge.is_static = parent->is_static;
      edge.sets = parent->sets.load(std::memory_order_relaxed);
      Pose newest;
      std::uint64_t version = 0;
      (void)ReadNewest(*parent, newest, version);
      edge.T_parent_child = TransformOf(newest);
      const EdgeRange range = ReadRange(*parent);
      edge.transforms = edge.is_static ? 1 : range.count;
      if (!edge.is_static) {
        edge.oldest = Time{range.oldest};
        edge.newest = Time{range.newest};
      }
      edges.push_back(std::move(edge));
    }
    auto& next = children[parent->id.value];
    std::sort(next.begin(), next.end(), by_falling_name);
    to_visit.insert(to_visit.end(), next.begin(), next.end());
  }
  return edges;
}

}  // namespace hgros::tf
