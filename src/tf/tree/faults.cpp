// The tree's texts when it refuses a transform or has none.
#include <array>
#include <cstdio>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "hgros/base/error.hpp"
#include "hgros/base/names.hpp"
#include "tf/tree/edge_reading.hpp"
#include "tf/tree/tree_core.hpp"

namespace hgros {

TransformResult TransformResult::Failed(TransformFailure failure) {
  return TransformResult(std::make_shared<const TransformFailure>(std::move(failure)));
}

const TransformFailure& TransformResult::failure() const noexcept {
  static const TransformFailure none;
  return failure_ ? *failure_ : none;
}

void TransformResult::Throw() const { throw Error(failure_->text); }

namespace tf {
namespace {

constexpr std::size_t kMostNamed = 20;  // Of the frames of a cycle.

std::string Quoted(std::string_view name) { return "\"" + std::string(name) + "\""; }

std::string Seconds(std::int64_t nanoseconds) {
  std::array<char, 40> text{};
  const std::int64_t whole = nanoseconds / 1'000'000'000;
  const auto rest = static_cast<long long>(std::abs(nanoseconds % 1'000'000'000));
  std::snprintf(text.data(), text.size(), "%s%lld.%09lld s", nanoseconds < 0 && whole == 0 ? "-" : "",
                static_cast<long long>(whole), rest);
  return text.data();
}

std::string NumberText(double value) {
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), "%.6g", value);
  return text.data();
}

std::string NameOf(const FrameTable& frames, FrameId id) {
  const Frame* frame = frames.At(id);
  return frame == nullptr ? "an id that is not of this tree" : Quoted(frame->name);
}

// The names of frames that have an edge: of all, unless there are more than a robot has. A lookup may fail again and
// again.
std::vector<std::string> KnownNames(const FrameTable& frames) {
  constexpr std::size_t kMost = 2000;
  std::vector<std::string> names;
  for (std::uint32_t i = 0; i < frames.size() && names.size() < kMost; ++i) {
    const Frame* frame = frames.At(FrameId{i});
    if (frame->known.load(std::memory_order_acquire)) names.push_back(frame->name);
  }
  return names;
}

TransformFailure Unknown(const FrameTable& frames, std::string_view name) {
  TransformFailure failure;
  failure.fault = TransformFault::kUnknownFrame;
  const std::vector<std::string> known = KnownNames(frames);
  if (known.empty()) {
    failure.text =
        "No transforms received yet: a session listens from its first use of them on. Pass a timeout to wait.";
    return failure;
  }
  failure.nearest_name = NearestName(name, known);
  failure.text = "No edge has a frame " + Quoted(name) + (failure.nearest_name.empty() ? "." : ";") +
                 (failure.nearest_name.empty() ? "" : " the nearest name is " + Quoted(failure.nearest_name) + ".");
  return failure;
}

}  // namespace

TransformFailure TreeCore::DescribeUnknown(std::string_view name) const {
  return Unknown(frames_, name.substr(0, 200));
}

TransformFailure TreeCore::Describe(const Outcome& outcome) const {
  if (outcome.fault == TransformFault::kUnknownFrame) {
    const Frame* frame = frames_.At(outcome.unknown);
    if (frame != nullptr) return Unknown(frames_, frame->name);
    return {outcome.fault, "A frame's id is not of this tree; Frame and Find give ids.", {}, {}, {}, {}, {}, {}, {}};
  }
  TransformFailure failure;
  failure.fault = outcome.fault;
  const std::string pair = "from " + NameOf(frames_, outcome.source) + " to " + NameOf(frames_, outcome.target);
  if (outcome.fault == TransformFault::kNotConnected) {
    failure.target_root = outcome.target_root->name;
    failure.source_root = outcome.source_root->name;
    failure.text = "No edges lead " + pair + ": the first is in the tree of " + Quoted(failure.source_root) +
                   ", the second in that of " + Quoted(failure.target_root) + ".";
    return failure;
  }
  const EdgeRange range = ReadRange(*outcome.edge);
  failure.edge_parent = outcome.edge->parent.load(std::memory_order_acquire)->name;
  failure.edge_child = outcome.edge->name;
  failure.oldest = Time{range.oldest};
  failure.newest = Time{range.newest};
  failure.text = "There is no transform " + pair + " at " + Seconds(outcome.wanted) + ", which is too " +
                 (outcome.fault == TransformFault::kTooOld ? "old" : "new") + ": the edge from " +
                 Quoted(failure.edge_parent) + " to " + Quoted(failure.edge_child) + " has " + Seconds(range.oldest) +
                 " to " + Seconds(range.newest) + ".";
  return failure;
}

SetResult TreeCore::Refuse(SetFault fault, const Frame& parent, const Frame& child, const EdgeValue& value) const {
  std::string why;
  const RigidTransform& T = value.T_parent_child;
  switch (fault) {
    case SetFault::kRotation: {
      const double length = T.rotation.norm();
      why = "its rotation is a quaternion of length " + NumberText(length) + ", not 1. Normalize it.";
      break;
    }
    case SetFault::kTranslation:
      why = "its translation (" + NumberText(T.translation.x()) + ", " + NumberText(T.translation.y()) + ", " +
            NumberText(T.translation.z()) + ") is not finite, or above 1e12 m.";
      break;
    case SetFault::kCycle: {
      if (&parent == &child) {
        why = "a frame cannot be below itself.";
        break;
      }
      why = "it would close a cycle: " + Quoted(parent.name);
      std::size_t named = 0;
      for (const Frame* frame = &parent; frame != &child && frame != nullptr;) {
        if (++named > kMostNamed) {
          why += " is below others, which are below " + Quoted(child.name);
          break;
        }
        frame = frame->parent.load(std::memory_order_acquire);
        if (frame != nullptr) why += " is below " + Quoted(frame->name);
        if (frame != nullptr && frame != &child) why += ", which";
      }
      why += ".";
      break;
    }
    case SetFault::kTwoParents: {
      const Frame* now = child.parent.load(std::memory_order_acquire);
      why = Quoted(child.name) + " is below " + Quoted(now == nullptr ? "" : now->name) +
            " already, and a frame keeps its parent.";
      break;
    }
    case SetFault::kStatic:
      why = child.is_static ? "it is a static edge. Set it without a stamp, as a static one."
                            : "it is an edge that moves. Set it with a stamp, not as a static one.";
      break;
    case SetFault::kTooOld: {
      const EdgeRange range = ReadRange(child);
      why = "its stamp " + Seconds(value.stamp) + " is older than the buffer, which has " + Seconds(range.oldest) +
            " to " + Seconds(range.newest) + ".";
      break;
    }
    case SetFault::kTooManyFrames:
      why = "the tree has " + std::to_string(frames_.most()) + " frames, which is its limit (max_frames).";
      break;
    case SetFault::kTooDeep:
      why = "frames would be more than 1000 edges below their root. Set frames below a nearer one.";
      break;
    case SetFault::kTooNew:  // Only Transforms knows a clock.
    case SetFault::kName:
    case SetFault::kNone: break;
  }
  return {fault, "The transform from " + Quoted(parent.name) + " to " + Quoted(child.name) + " was refused: " + why};
}

}  // namespace tf
}  // namespace hgros
