// The old place of a component that moves.
#include <algorithm>
#include <chrono>
#include <exception>
#include <map>
#include <utility>

#include "component/components_core.hpp"
#include "component/stream_position.hpp"
#include "hgros/base/error.hpp"
#include "hgros/clock/time.hpp"
#include "hgros/component/component_move.hpp"
#include "hgros/session/session_parts.hpp"

namespace hgros {

namespace {

// How long messages that later ones have overtaken may still be on the way to the input.
constexpr std::chrono::milliseconds kOvertakenPatience{100};
// Some subscribers confirm messages with their heartbeat, usually once a second.
constexpr std::chrono::milliseconds kReceivedPatience{1500};

}  // namespace

class LeavingComponent::Core {
 public:
  enum class Stage { kRuns, kHeld, kLeft };
  struct Stream {
    StreamPosition last;                  // Handled here, or handed over.
    std::optional<StreamPosition> own{};  // From here on the messages come to the other place by themselves.
    // A thread that publishes in the process of the other place may not know its subscription yet, although others do.
    bool own_may_miss = false;
    // Since when all before that was handed over, or never came.
    std::optional<std::chrono::steady_clock::time_point> passed{};

    [[nodiscard]] bool IsOwn(const MessageInfo& info) const { return own && own->Ahead(info) >= 0; }
    void Pass() {
      if (!passed) passed = std::chrono::steady_clock::now();
    }
    [[nodiscard]] bool settled() const {
      return passed && std::chrono::steady_clock::now() - *passed >= kOvertakenPatience;
    }
    // There is nothing more to hand over.
    [[nodiscard]] bool ended() const { return passed && (settled() || (!last.misses_any() && !own_may_miss)); }
  };

  Core(Session& its_session, Components::Core& its_components, OneComponent& its_one, std::function<void()> its_wake)
      : session(its_session), components(its_components), one(its_one), wake(std::move(its_wake)) {}

  Session& session;
  Components::Core& components;
  OneComponent& one;
  const std::function<void()> wake;
  Stage stage = Stage::kRuns;
  std::vector<std::shared_ptr<InputGate>> gates;
  std::map<std::string, std::map<MessageSender, Stream>> streams;  // By input.
  std::map<const InputGate*, std::shared_ptr<const MessageSchema>> schemas;
  std::uint64_t lost = 0;

  std::optional<RawMessage> Write(const InputGate& gate, const AnyMessage& message) {
    if (IsAnyType(gate.type())) return *static_cast<const RawMessage*>(message.get());
    auto& schema = schemas[&gate];
    if (!schema) schema = std::make_shared<const MessageSchema>(SchemaOf(gate.type()));
    try {
      Payload data = gate.type().encode(message);
      if (data.owner != nullptr) return RawMessage{schema, std::move(data)};
    } catch (const std::bad_alloc&) {  // NOLINT(bugprone-empty-catch): counted below.
    }
    ++lost;
    return std::nullopt;
  }
};

LeavingComponent::LeavingComponent(Components& components, std::string name, std::function<void()> wake)
    : core_(std::make_unique<Core>(components.core_->session(), *components.core_, components.core_->Get(name),
                                   std::move(wake))) {
  if (core_->one.type.state == nullptr) {
    throw Error(Named(core_->one.core.setup()) + "it cannot move, because its class cannot be saved.", {},
                "Give it Save() and Restore().");
  }
}

LeavingComponent::~LeavingComponent() {
  if (core_->stage == Core::Stage::kLeft) {
    core_->components.End(core_->one.core.setup().name);
  } else {
    Resume();
  }
}

bool LeavingComponent::HasPublisherHere(Components& components, const std::string& name, std::string_view channel) {
  return components.core_->HasPublisherBeside(components.core_->Get(name), channel);
}

MovingState LeavingComponent::Hold(std::chrono::nanoseconds patience, SessionId to) {
  OneComponent& one = core_->one;
  core_->gates = one.core.gates();
  MovingState moving;
  moving.from = core_->session.id();
  moving.state = one.Save(patience, [&] {
    for (const auto& gate : core_->gates) gate->Hold(core_->wake, InputGate::Full::kWaits);
    one.core.SetPlace(ContextCore::Place::kHeld);
    core_->stage = Core::Stage::kHeld;
  });
  for (const auto& gate : core_->gates) {
    for (const auto& [last, gaps] : gate->Positions()) {
      moving.positions.push_back({gate->node(), last.id, last.number, last.remote});
      StreamPosition& position = core_->streams[gate->node()][SenderOf(last.id)].last;
      position.Note(last);
      position.NoteGaps(gaps);
    }
  }
  std::vector<std::string> outputs;
  for (const ComponentChannel& output : one.core.description().outputs) outputs.push_back(output.channel);
  if (one.core.transforms().Withhold()) outputs.emplace_back(kStaticTransformsChannel);
  SessionParts parts(core_->session);
  if (!parts.AwaitReceived(outputs, DeadlineIn(kReceivedPatience))) {
    Resume();
    throw Error(
        Named(one.core.setup()) + "it cannot move now: its subscribers let messages wait that it has published.", {},
        "Try again later, or look for a subscriber that takes too long.");
  }
  one.offered.reset();
  one.Deactivate();
  moving.static_edges = one.core.transforms().Withheld();
  for (const std::string& channel : core_->components.OwnOutputs(one)) {
    for (auto& latched : parts.LatchedOn(channel)) {
      moving.latched.push_back({channel, latched.publish_time_ns, std::move(latched.data)});
    }
  }
  if (to.value != 0) parts.TakeServicesFrom(to);
  return moving;
}

void LeavingComponent::Resume() {
  if (core_->stage != Core::Stage::kHeld) return;
  core_->stage = Core::Stage::kRuns;
  OneComponent& one = core_->one;
  try {
    if (core_->components.options().offer_params && !one.offered) one.Offer(core_->session);
  } catch (const std::exception& error) {
    one.core.log().Write(LogLevel::kError, std::string("Others cannot reach its parameters any more. ") + error.what());
  }
  one.core.transforms().Release();
  if (!one.active.Has(one)) (void)one.TryActivate();
  one.core.SetPlace(ContextCore::Place::kHere);
  one.LetWaitingPass();
}

void LeavingComponent::Leave() {
  core_->stage = Core::Stage::kLeft;
  OneComponent& one = core_->one;
  one.core.SetPlace(ContextCore::Place::kElsewhere);
  one.core.EndTimers();
  one.core.EndServices();
  for (const std::string& channel : core_->components.OwnOutputs(one)) {
    SessionParts(core_->session).ForgetLatched(channel);
  }
}

std::optional<MovingMessage> LeavingComponent::Next() {
  for (const auto& gate : core_->gates) {
    while (auto waiting = gate->Next()) {
      if (waiting->info.number != 0) {
        Core::Stream& stream = core_->streams[gate->node()][SenderOf(waiting->info.id)];
        const bool own = stream.IsOwn(waiting->info);
        if (own && stream.passed && (stream.settled() || !stream.own_may_miss)) continue;
        // Also the first one that comes by itself: it shows that there is nothing more before it, except for those that
        // it has overtaken.
        stream.last.Note(waiting->info);
        if (own) stream.Pass();
      }
      std::optional<RawMessage> message = core_->Write(*gate, waiting->message);
      if (message) return MovingMessage{gate->node(), waiting->info, std::move(*message)};
    }
  }
  return std::nullopt;
}

bool LeavingComponent::has_more() const {
  return std::ranges::any_of(core_->gates, [](const auto& gate) { return gate->has_more(); });
}

void LeavingComponent::Passed(const InputPosition& position) {
  Core::Stream& stream = core_->streams[position.input][SenderOf(position.last)];
  const MessageInfo first = MessageAt(position);
  stream.own.emplace().Note(first);
  stream.own_may_miss = !first.remote;
  if (stream.last.Ahead(first) <= 0) stream.Pass();
}

bool LeavingComponent::all_passed() const {
  return std::ranges::all_of(core_->streams, [](const auto& input) {
    return std::ranges::all_of(input.second, [](const auto& stream) { return stream.second.ended(); });
  });
}

std::uint64_t LeavingComponent::lost() const noexcept { return core_->lost; }

}  // namespace hgros
