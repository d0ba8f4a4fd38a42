// The new place of a component that moves.
#include <algorithm>
#include <deque>
#include <exception>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "component/components_core.hpp"
#include "component/stream_position.hpp"
#include "hgros/base/error.hpp"
#include "hgros/clock/time.hpp"
#include "hgros/codec/run_time_type.hpp"
#include "hgros/component/component_move.hpp"
#include "hgros/session/session_parts.hpp"

namespace hgros {
namespace {

constexpr std::chrono::seconds kInputPatience{10};
constexpr int kMostAtOnce = 256;

}  // namespace

class ArrivingComponent::Core {
 public:
  struct Stream {
    StreamPosition there{};               // The last message that was handled in the other place.
    StreamPosition handled{};             // The last message that was handled, in either place.
    std::optional<StreamPosition> own{};  // From here on, all come by themselves.
    // The other place has come to that one, too, so nothing waits there that came before it. Another publisher may have
    // sent that: the same component in another place.
    bool complete = false;
    std::deque<InputGate::Waiting> early{};  // Came by themselves; the other place may still have some before them.

    void UseNumbers() {
      there.UseNumbers();
      handled.UseNumbers();
      if (own) own->UseNumbers();
    }
  };
  struct Input {
    std::shared_ptr<InputGate> gate;
    std::map<MessageSender, Stream> streams{};
    std::size_t early = 0;  // In all streams.
  };

  Core(Components::Core& its_components, OneComponent& its_one, std::function<void()> its_wake)
      : components(its_components), one(its_one), wake(std::move(its_wake)) {}

  void LetPass(Input& input, InputGate::Waiting waiting) { one.LetPass(*input.gate, std::move(waiting)); }
  // Whether it takes this one although a later one was handled already.
  static bool IsLate(const Input& input, const Stream& stream, const MessageInfo& info) {
    return input.gate->takes_late() && stream.handled.Misses(info);
  }
  void HandleOwn(Input& input, Stream& stream, const InputGate::Waiting& waiting) {
    // A late one that the other place does not hand over.
    const bool late =
        IsLate(input, stream, waiting.info) && (finished || (stream.own && stream.own->Ahead(waiting.info) >= 0));
    if (stream.handled.Ahead(waiting.info) <= 0 && !late) return;
    stream.handled.Note(waiting.info);
    LetPass(input, waiting);
  }
  // A message that came by itself. False: it is too early.
  bool TakeOwn(Input& input, Stream& stream, const InputGate::Waiting& waiting) {
    const MessageInfo& info = waiting.info;
    if (!info.remote) stream.UseNumbers();
    const bool settled = info.publish_monotonic_ns > settled_ns;
    if (settled && !stream.own) {
      stream.own.emplace().Note(info);
      own.push_back({input.gate->node(), info.id, info.number, info.remote});
      stream.complete = stream.handled.Ahead(info) <= 0;
    }
    if (stream.handled.Ahead(info) > 0 && !stream.complete && !finished) return false;
    HandleOwn(input, stream, waiting);
    return true;
  }

  void TakeOwn(Input& input, InputGate::Waiting waiting) {
    if (waiting.info.number == 0) {
      if (finished) LetPass(input, std::move(waiting));  // Until then the other place hands it over.
      return;
    }
    Stream& stream = input.streams[SenderOf(waiting.info.id)];
    if (stream.early.empty() && TakeOwn(input, stream, waiting)) return;
    stream.early.push_back(std::move(waiting));
    ++input.early;
  }

  void TakeEarly(Input& input, Stream& stream) {
    while (!stream.early.empty() && TakeOwn(input, stream, stream.early.front())) PopEarly(input, stream);
  }
  static void PopEarly(Input& input, Stream& stream) {
    stream.early.pop_front();
    --input.early;
  }

  // Those that the other place has skipped.
  void HandleBefore(Input& input, Stream& stream, const MessageInfo& handed) {
    while (!stream.early.empty()) {
      const InputGate::Waiting waiting = stream.early.front();
      if (stream.handled.Ahead(waiting.info) >= stream.handled.Ahead(handed)) return;
      PopEarly(input, stream);
      HandleOwn(input, stream, waiting);
    }
  }

  Components::Core& components;
  OneComponent& one;
  const std::function<void()> wake;
  std::vector<Input> inputs;
  std::vector<InputPosition> own;                                            // What FirstOwn has not told.
  std::map<std::string, std::vector<SessionParts::LatchedMessage>> latched;  // By channel.
  SessionId from{};
  bool begun = false;
  bool finished = false;
  // The links were made before. What came earlier may have come over those of an earlier subscription of this session,
  // so it does not show that the next message will come as well.
  std::int64_t settled_ns = std::numeric_limits<std::int64_t>::max();
};

ArrivingComponent::ArrivingComponent(Components& components, const ComponentSetup& setup, std::function<void()> wake) {
  ComponentSetup blank = setup;
  blank.state = nullptr;
  OneComponent& one = components.core_->Add(nullptr, blank, true);
  core_ = std::make_unique<Core>(*components.core_, one, wake);
  for (const auto& gate : one.core.gates()) {
    // It may be long until this place begins. Until then a thread that waits would hold up other components.
    gate->Hold(wake, InputGate::Full::kDropsOldest);
    core_->inputs.push_back({gate});
  }
  try {
    one.core.JoinInputs();
    for (const ComponentChannel& input : one.core.description().inputs) {
      if (SessionParts(components.core_->session()).SettleInput(input.channel, kInputPatience)) continue;
      throw Error(Named(setup) + "the channel \"" + input.channel +
                      "\" cannot be subscribed to: an earlier subscription "
                      "of this session has not ended within 10 s.",
                  {}, "Look for a callback that does not return.");
    }
    core_->settled_ns = MonotonicNow();
  } catch (...) {
    components.core_->End(setup.name);
    throw;
  }
}

ArrivingComponent::~ArrivingComponent() {
  if (!core_->begun) {
    (void)core_->one.core.transforms().Withhold();
    for (const std::string& channel : core_->components.OwnOutputs(core_->one)) {
      SessionParts(core_->components.session()).ForgetLatched(channel);
    }
    core_->components.End(core_->one.core.setup().name);
  } else {
    Finish();
  }
}

bool ArrivingComponent::HasPublisherHere(std::string_view channel) const {
  return core_->components.HasPublisherBeside(core_->one, channel);
}

void ArrivingComponent::Restore(const MovingState& moving) {
  core_->from = moving.from;
  if (!moving.static_edges.empty()) (void)core_->one.core.transforms().Get().ToStaticTF(moving.static_edges);
  if (moving.state) core_->one.Restore(*moving.state);
  for (const MovingLatched& one : moving.latched)
    core_->latched[one.channel].push_back({one.data, one.publish_time_ns});
  for (const InputPosition& position : moving.positions) {
    for (Core::Input& input : core_->inputs) {
      if (input.gate->node() == position.input) {
        const MessageInfo info = MessageAt(position);
        Core::Stream& stream = input.streams[SenderOf(info.id)];
        stream.there.Note(info);
        stream.handled.Note(info);
        input.gate->NotePosition(info);
      }
    }
  }
}

void ArrivingComponent::Begin() {
  OneComponent& one = core_->one;
  SessionParts parts(core_->components.session());
  for (const std::string& channel : core_->components.OwnOutputs(one))
    parts.KeepLatched(channel, core_->latched[channel], core_->from);
  try {
    one.core.transforms().Release();
    one.Activate();
    parts.TakeServicesFrom(core_->from);
    one.core.JoinServices();
    if (core_->components.options().offer_params) one.Offer(core_->components.session());
    one.core.StartTimers();
  } catch (...) {
    throw CurrentError(one.core.setup());
  }
  one.core.SetState(ComponentState::kRunning);
  one.arrives = false;
  core_->begun = true;
  for (const Core::Input& input : core_->inputs) input.gate->Hold(core_->wake, InputGate::Full::kWaits);
  (void)Work();
}

bool ArrivingComponent::Work() {
  if (!core_->begun) return false;
  bool more = false;
  for (Core::Input& input : core_->inputs) {
    // A lossless queue is as long here as it is elsewhere.
    for (int i = 0; input.early < input.gate->most() && input.gate->has_room(); ++i) {
      more = more || i == kMostAtOnce;
      if (i == kMostAtOnce) break;  // Under load, more come all the time.
      auto waiting = input.gate->Next();
      if (!waiting) break;
      core_->TakeOwn(input, std::move(*waiting));
    }
  }
  return more;
}

void ArrivingComponent::Hand(const MovingMessage& message) {
  const auto found = std::ranges::find_if(
      core_->inputs, [&](const Core::Input& input) { return input.gate->node() == message.input; });
  if (found == core_->inputs.end()) {
    return core_->one.core.log().Write(
        LogLevel::kError, "A message of " + message.input + " was lost in the move: there is no such node here.");
  }
  Core::Input& input = *found;
  const TypeInfo& type = input.gate->type();
  InputGate::Waiting waiting{nullptr, message.info};
  if (IsAnyType(type)) {
    waiting.message = std::make_shared<const RawMessage>(message.message);
  } else if (IsRunTimeType(type)) {
    waiting.message = std::make_shared<const RawMessage>(RawMessage{type.run_time->schema, message.message.data});
  } else {
    waiting.message = type.decode(message.message.data);
  }
  if (waiting.message == nullptr) {
    return core_->one.core.log().Write(
        LogLevel::kError, "A message of " + message.input + " was lost in the move: it is no " + type.name + ".");
  }
  if (message.info.number == 0) return core_->LetPass(input, std::move(waiting));
  Core::Stream& stream = input.streams[SenderOf(message.info.id)];
  if (!message.info.remote) stream.UseNumbers();
  // The other place has handled none of those that it hands over, so those up to its position were overtaken there.
  if (stream.handled.Ahead(message.info) > 0 || stream.there.Ahead(message.info) <= 0 ||
      Core::IsLate(input, stream, message.info)) {
    core_->HandleBefore(input, stream, message.info);
    stream.handled.Note(message.info);
    core_->LetPass(input, std::move(waiting));
  }
  stream.complete = stream.complete || (stream.own && stream.own->Ahead(message.info) >= 0);
  core_->TakeEarly(input, stream);
}

std::vector<InputPosition> ArrivingComponent::FirstOwn() { return std::exchange(core_->own, {}); }

void ArrivingComponent::Finish() {
  core_->finished = true;
  for (Core::Input& input : core_->inputs) {
    for (auto& [sender, stream] : input.streams) core_->TakeEarly(input, stream);
    input.gate->Pass([&](InputGate::Waiting waiting) { core_->TakeOwn(input, std::move(waiting)); }, true);
  }
}

}  // namespace hgros
