#include "hgros/tf/transform_tree.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "hgros/base/error.hpp"
#include "hgros/base/names.hpp"
#include "tf/tree/tree_core.hpp"

namespace hgros {
namespace {

// Both ids of a lookup by name, or the failure.
struct Ends {
  FrameId target;
  FrameId source;
  std::optional<TransformFailure> failure;
};

const tf::Frame* FindOrSay(const tf::TreeCore& core, std::string_view name, std::optional<TransformFailure>& failure) {
  const tf::Frame* frame = core.frames().Find(name);
  if (frame == nullptr && !failure) failure = core.DescribeUnknown(name);
  return frame;
}

Ends Resolve(const tf::TreeCore& core, std::string_view target, std::string_view source) {
  Ends ends;
  if (const tf::Frame* frame = FindOrSay(core, target, ends.failure)) ends.target = frame->id;
  if (const tf::Frame* frame = FindOrSay(core, source, ends.failure)) ends.source = frame->id;
  return ends;
}

std::string InSeconds(Duration time) {
  std::string text = std::to_string(std::max(std::chrono::duration<double>(time).count(), 0.0));
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text + " s";
}

}  // namespace

TransformTree::TransformTree(const TransformTreeOptions& options) : core_(std::make_shared<tf::TreeCore>(options)) {}
TransformTree::~TransformTree() = default;

FrameId TransformTree::Frame(std::string_view name) {
  if (const tf::Frame* frame = core_->frames().Find(name)) return frame->id;
  RequireChannelName(name);
  if (const tf::Frame* frame = core_->frames().Intern(name)) return frame->id;
  throw Error("The tree has " + std::to_string(core_->frames().most()) + " frames already, so \"" + std::string(name) +
                  "\" gets no id.",
              {}, "Raise max_frames.");
}

std::optional<FrameId> TransformTree::Find(std::string_view name) const noexcept {
  const tf::Frame* frame = core_->frames().Find(name);
  return frame == nullptr ? std::nullopt : std::optional(frame->id);
}

std::string_view TransformTree::Name(FrameId frame) const noexcept {
  const tf::Frame* found = core_->frames().At(frame);
  return found == nullptr ? std::string_view() : found->name;
}

PublisherId TransformTree::Publisher(std::string_view name) { return core_->Publisher(name); }

SetResult TransformTree::Set(FrameId parent, FrameId child, Time stamp, const RigidTransform& T_parent_child,
                             PublisherId publisher) {
  return core_->Set(parent, child, {stamp.nanoseconds, false, T_parent_child, publisher});
}

SetResult TransformTree::Set(std::string_view parent, std::string_view child, Time stamp,
                             const RigidTransform& T_parent_child, std::string_view publisher) {
  return core_->Set(parent, child, {stamp.nanoseconds, false, T_parent_child, {}}, publisher);
}

SetResult TransformTree::SetStatic(FrameId parent, FrameId child, const RigidTransform& T_parent_child,
                                   PublisherId publisher) {
  return core_->Set(parent, child, {0, true, T_parent_child, publisher});
}

SetResult TransformTree::SetStatic(std::string_view parent, std::string_view child,
                                   const RigidTransform& T_parent_child, std::string_view publisher) {
  return core_->Set(parent, child, {0, true, T_parent_child, {}}, publisher);
}

void TransformTree::RestartTime(Time latest) noexcept { core_->RestartTime(latest.nanoseconds); }

bool TransformTree::RestartEdge(std::string_view child, Time possible) noexcept {
  return core_->RestartEdge(child, possible.nanoseconds);
}

TransformResult TransformTree::Lookup(FrameId target, FrameId source) const {
  tf::Outcome outcome;
  core_->LookupLatest(target, source, outcome);
  return core_->Result(outcome);
}

TransformResult TransformTree::Lookup(FrameId target, FrameId source, Time time) const {
  tf::Outcome outcome;
  core_->LookupAt(target, source, time.nanoseconds, outcome);
  return core_->Result(outcome);
}

TransformResult TransformTree::Lookup(const TransformQuery& query) const {
  tf::Outcome outcome;
  core_->Lookup(query, outcome);
  return core_->Result(outcome);
}

TransformResult TransformTree::Lookup(std::string_view target, std::string_view source) const {
  Ends ends = Resolve(*core_, target, source);
  return ends.failure ? TransformResult::Failed(std::move(*ends.failure)) : Lookup(ends.target, ends.source);
}

TransformResult TransformTree::Lookup(std::string_view target, std::string_view source, Time time) const {
  Ends ends = Resolve(*core_, target, source);
  return ends.failure ? TransformResult::Failed(std::move(*ends.failure)) : Lookup(ends.target, ends.source, time);
}

TransformResult TransformTree::Lookup(std::string_view target, Time target_time, std::string_view source,
                                      Time source_time, std::string_view fixed) const {
  Ends ends = Resolve(*core_, target, source);
  const tf::Frame* still = FindOrSay(*core_, fixed, ends.failure);
  if (ends.failure) return TransformResult::Failed(std::move(*ends.failure));
  return Lookup({ends.target, target_time, ends.source, source_time, still->id});
}

bool TransformTree::CanTransform(const TransformQuery& query) const {
  tf::Outcome outcome;
  core_->Lookup(query, outcome);
  return outcome.fault == TransformFault::kNone;
}

bool TransformTree::CanTransform(std::string_view target, std::string_view source) const {
  const auto to = Find(target);
  const auto from = Find(source);
  return to && from && CanTransform({*to, *from});
}

bool TransformTree::CanTransform(std::string_view target, std::string_view source, Time time) const {
  const auto to = Find(target);
  const auto from = Find(source);
  return to && from && CanTransform({*to, *from, time});
}

TransformResult TransformTree::Wait(const TransformQuery& query, Duration timeout, std::stop_token stop) const {
  const std::chrono::steady_clock::time_point deadline = DeadlineIn(timeout);
  const auto waiter = std::make_shared<tf::Waiter>(query);
  core_->waits()->Add(waiter);
  std::optional<TransformResult> result = waiter->Sleep(deadline, stop);
  if (result) return *std::move(result);
  core_->waits()->Remove(waiter);
  tf::Outcome outcome;
  core_->Lookup(query, outcome);
  if (outcome.fault == TransformFault::kNone) return core_->Result(outcome);
  TransformFailure failure = core_->Describe(outcome);
  failure.fault = stop.stop_requested() ? TransformFault::kStopped : TransformFault::kTimeout;
  failure.text =
      (stop.stop_requested() ? "Waiting was stopped. " : "Nothing has come within " + InSeconds(timeout) + ". ") +
      failure.text;
  return TransformResult::Failed(std::move(failure));
}

PendingTransform TransformTree::WhenAvailable(const TransformQuery& query, TransformCallback callback) const {
  auto waiter = std::make_shared<tf::Waiter>(query, std::move(callback));
  core_->waits()->Add(waiter);
  return {core_->waits(), std::move(waiter)};
}

std::vector<EdgeSnapshot> TransformTree::Edges() const { return core_->Edges(); }

}  // namespace hgros
