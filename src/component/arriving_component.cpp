// The new place of a component that moves.
#include <algorithm>
#include <deque>
#include <exception>
#include <limits>
#include <map>
#include <utility>

#include "component/components_core.hpp"
#include "hgros/base/error.hpp"
#include "hgros/clock/time.hpp"
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
    std::uint64_t sequence = 0;  // Of the last message that was handled, in either place.
    std::uint64_t number = 0;
    bool by_number = false;  // One of the places is in the publisher's process: only numbers are the same in both.
    bool complete = false;   // Everything behind the last one comes by itself.

    // How many messages this one is behind the last one that was handled; 0 or less: it was handled.
    [[nodiscard]] std::int64_t Ahead(const MessageInfo& info) const {
      return by_number ? static_cast<std::int64_t>(info.number - number)
                       : static_cast<std::int64_t>(info.id.sequence - sequence);
    }
    void Note(const MessageInfo& info) {
      if (info.remote) sequence = std::max(sequence, info.id.sequence);
      number = std::max(number, info.number);
    }
  };
  struct Input {
    std::shared_ptr<InputGate> gate;
    std::map<MessageSender, Stream> streams{};
    std::deque<InputGate::Waiting> early{};  // Came by themselves; the other place may still have some before them.
  };

  Core(Components::Core& its_components, OneComponent& its_one) : components(its_components), one(its_one) {}

  void Handle(Input& input, const InputGate::Waiting& waiting) {
    try {
      input.gate->Handle(waiting);
    } catch (const std::exception& error) {
      one.core.log().Write(LogLevel::kError, "A callback of " + input.gate->node() + " threw: " + error.what());
    } catch (...) {
      one.core.log().Write(LogLevel::kError, "A callback of " + input.gate->node() + " threw.");
    }
  }
  void Complete(Input& input, MessageSender sender, Stream& stream) {
    if (std::exchange(stream.complete, true)) return;
    completed.push_back({input.gate->node(), {sender.id, sender.incarnation, stream.sequence}, stream.number, true});
  }
  static Stream& StreamOf(Input& input, const MessageInfo& info) {
    Stream& stream = input.streams[SenderOf(info.id)];
    if (!info.remote) stream.by_number = true;
    return stream;
  }
  // A message that came by itself. False: it is too early.
  bool TakeOwn(Input& input, const InputGate::Waiting& waiting) {
    if (waiting.info.number == 0) {
      if (finished) Handle(input, waiting);  // Until then the other place hands it over.
      return true;
    }
    const MessageSender sender = SenderOf(waiting.info.id);
    Stream& stream = StreamOf(input, waiting.info);
    const std::int64_t ahead = stream.Ahead(waiting.info);
    if (ahead > 1 && !stream.complete && !finished) return false;
    if (ahead > 0) {
      stream.Note(waiting.info);
      Handle(input, waiting);
    }
    if (waiting.info.publish_monotonic_ns > settled_ns) Complete(input, sender, stream);
    return true;
  }
  void TakeEarly(Input& input, MessageSender sender) {
    const auto first = std::ranges::find_if(
        input.early, [&](const InputGate::Waiting& waiting) { return SenderOf(waiting.info.id) == sender; });
    if (first == input.early.end() || input.streams[sender].Ahead(first->info) > 1) return;
    std::deque<InputGate::Waiting> still;
    std::deque<InputGate::Waiting> before = std::exchange(input.early, {});
    for (InputGate::Waiting& one_early : before) {
      if (SenderOf(one_early.info.id) != sender || !TakeOwn(input, one_early)) still.push_back(std::move(one_early));
    }
    input.early = std::move(still);
  }
  // Those of a publisher that the other place has skipped.
  void HandleBefore(Input& input, MessageSender sender, Stream& stream, const MessageInfo& handed) {
    while (true) {
      const auto next = std::ranges::find_if(input.early, [&](const InputGate::Waiting& waiting) {
        return SenderOf(waiting.info.id) == sender && stream.Ahead(waiting.info) < stream.Ahead(handed);
      });
      if (next == input.early.end()) return;
      const InputGate::Waiting waiting = std::move(*next);
      input.early.erase(next);
      if (stream.Ahead(waiting.info) <= 0) continue;
      stream.Note(waiting.info);
      Handle(input, waiting);
    }
  }

  Components::Core& components;
  OneComponent& one;
  std::vector<Input> inputs;
  std::vector<InputPosition> completed;
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
  OneComponent& one = components.core_->Add(nullptr, blank);
  one.arrives = true;
  core_ = std::make_unique<Core>(*components.core_, one);
  for (const auto& gate : one.core.gates()) {
    gate->Hold(wake);
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
    core_->components.End(core_->one.core.setup().name);
  } else {
    Finish();
  }
}

void ArrivingComponent::Restore(const MovingState& moving) {
  core_->from = moving.from;
  if (moving.state) core_->one.Restore(*moving.state);
  for (const InputPosition& position : moving.positions) {
    for (Core::Input& input : core_->inputs) {
      if (input.gate->node() == position.input) {
        MessageInfo info;
        info.id = position.last;
        info.number = position.number;
        info.remote = position.remote;
        Core::StreamOf(input, info).Note(info);
        input.gate->NotePosition(info);
      }
    }
  }
}

void ArrivingComponent::Begin() {
  OneComponent& one = core_->one;
  try {
    one.Activate();
    SessionParts(core_->components.session()).TakeServicesFrom(core_->from);
    one.core.JoinServices();
    if (core_->components.options().offer_params) one.Offer(core_->components.session());
    one.core.StartTimers();
  } catch (...) {
    throw CurrentError(one.core.setup());
  }
  one.core.SetState(ComponentState::kRunning);
  one.arrives = false;
  core_->begun = true;
  (void)Work();
}

bool ArrivingComponent::Work() {
  if (!core_->begun) return false;
  bool more = false;
  for (Core::Input& input : core_->inputs) {
    for (int i = 0; true; ++i) {
      more = more || i == kMostAtOnce;
      if (i == kMostAtOnce) break;  // Under load, more come all the time.
      auto waiting = input.gate->Next();
      if (!waiting) break;
      if (!core_->TakeOwn(input, *waiting)) input.early.push_back(std::move(*waiting));
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
  } else {
    waiting.message = type.decode(message.message.data);
  }
  if (waiting.message == nullptr) {
    return core_->one.core.log().Write(
        LogLevel::kError, "A message of " + message.input + " was lost in the move: it is no " + type.name + ".");
  }
  if (message.info.number == 0) return core_->Handle(input, waiting);
  const MessageSender sender = SenderOf(message.info.id);
  Core::Stream& stream = Core::StreamOf(input, message.info);
  if (stream.Ahead(message.info) > 0) {
    core_->HandleBefore(input, sender, stream, message.info);
    stream.Note(message.info);
    core_->Handle(input, waiting);
  }
  core_->TakeEarly(input, sender);
}

std::vector<InputPosition> ArrivingComponent::Complete() { return std::exchange(core_->completed, {}); }

void ArrivingComponent::Finish() {
  core_->finished = true;
  for (Core::Input& input : core_->inputs) {
    do {
      for (const InputGate::Waiting& waiting : std::exchange(input.early, {})) (void)core_->TakeOwn(input, waiting);
      while (const auto waiting = input.gate->Next()) (void)core_->TakeOwn(input, *waiting);
    } while (!input.gate->PassIfEmpty(true));
  }
}

}  // namespace hgros
