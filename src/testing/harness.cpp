#include "hgros/testing/harness.hpp"

#include <algorithm>
#include <mutex>
#include <utility>

#include "hgros/base/error.hpp"
#include "hgros/base/names.hpp"
#include "hgros/clock/derived_clocks.hpp"
#include "hgros/params/param_server.hpp"
#include "hgros/session/session_parts.hpp"

namespace hgros::testing {
namespace {

const std::string kName = "component";

template <class Things>
void Require(std::string_view name, const Things& things, std::string_view what) {
  std::vector<std::string> names;
  for (const auto& one : things) names.push_back(one.name);
  if (std::ranges::find(names, name) != names.end()) return;
  const std::string nearest = NearestName(name, names);
  std::string mend = "It has none.";
  if (!nearest.empty()) {
    mend = "Did you mean \"" + nearest + "\"?";
  } else if (!names.empty()) {
    mend = "It has:";
    for (const std::string& one : names) mend += (one == names.front() ? " " : ", ") + one;
    mend += ".";
  }
  throw Error("The component " + std::string(what) + " \"" + std::string(name) + "\".", {}, mend);
}

}  // namespace

class AnyHarness::Core {
 public:
  Core(const ComponentType& type, const HarnessOptions& options)
      : clock_(SimulatedClock::Paused(options.start)),
        session_(Config::Parse("discovery: {domain: none, local: false}\ncontrol: off\n"),
                 {.name = "harness",
                  .log = [this](LogLevel, std::string_view text) { Keep(text); },
                  .clock = clock_,
                  .wall = [clock = clock_] { return clock->Now(); }}),
        components_(session_, {.log = [this](std::string_view, LogLevel, std::string_view text) { Keep(text); },
                               .on_change = {},
                               .all_inline = true,
                               .offer_params = false}) {
    ComponentSetup setup{.name = kName, .type = {}, .state = options.state};
    if (!options.params.empty()) setup.params.overrides = {{"", options.params, "HarnessOptions::params"}};
    components_.Add(type, setup);
    for (const ComponentChannel& output : description().outputs) Record(output.channel);
    components_.Join();
    components_.Start();
  }

  void Step(Duration time) {
    const Time end = clock_->Now() + time;
    for (Time due = SessionParts(session_).SettleTimers(); due <= end;) {
      clock_->Step(due - clock_->Now());
      const Time next = SessionParts(session_).SettleTimers();
      if (next <= due) break;
      due = next;
    }
    clock_->Step(end - clock_->Now());
  }

  [[nodiscard]] std::vector<AnyMessage> Take(std::string_view channel, const TypeInfo& type) {
    Require(channel, description().outputs, "does not advertise");
    std::vector<RawMessage> recorded;
    {
      const std::scoped_lock lock(mutex_);
      recorded.swap(recorded_.find(channel)->second);
    }
    std::vector<AnyMessage> taken;
    for (const RawMessage& one : recorded) {
      if (const std::string misfit = MisfitOf(*one.schema, type); !misfit.empty()) {
        throw TypeMismatch("The messages on \"" + std::string(channel) + "\" cannot be taken as " + type.name + ": " +
                           misfit);
      }
      taken.push_back(type.decode(one.data));
    }
    return taken;
  }

  [[nodiscard]] const ComponentDescription& description() const { return components_.description(kName); }
  [[nodiscard]] std::vector<std::string> lines() const {
    const std::scoped_lock lock(mutex_);
    return lines_;
  }
  [[nodiscard]] const SimulatedClock& clock() const noexcept { return *clock_; }
  [[nodiscard]] Session& session() noexcept { return session_; }
  [[nodiscard]] Components& components() noexcept { return components_; }

 private:
  void Record(const std::string& channel) {
    auto [at, added] = recorded_.try_emplace(channel);
    if (!added) return;
    recorders_.push_back(session_.FromAnyRaw(
        channel, Invoke::kSerial,
        [this, &into = at->second](const RawMessage& message) {
          const std::scoped_lock lock(mutex_);
          into.push_back(message);
        },
        {.name = "harness/" + channel, .queue = Queue::KeepAll(1U << 20U), .executor = Executor::Inline()}));
  }
  void Keep(std::string_view text) {
    const std::scoped_lock lock(mutex_);
    lines_.emplace_back(text);
  }

  mutable std::mutex mutex_;  // Timers run on a thread of the session.
  std::vector<std::string> lines_;
  std::map<std::string, std::vector<RawMessage>, std::less<>> recorded_;  // Entries stay.
  const std::shared_ptr<SimulatedClock> clock_;
  Session session_;
  std::vector<Subscription> recorders_;
  Components components_;
};

AnyHarness::AnyHarness(const ComponentType& type, const HarnessOptions& options)
    : core_(std::make_unique<Core>(type, options)) {}
AnyHarness::~AnyHarness() = default;

void AnyHarness::Step(Duration time) { core_->Step(time); }
Time AnyHarness::now() const { return core_->clock().Now(); }
ComponentStatus AnyHarness::status() const { return core_->components().statuses().front(); }
const ComponentDescription& AnyHarness::description() const { return core_->description(); }
std::vector<std::string> AnyHarness::lines() const { return core_->lines(); }
ParamServer& AnyHarness::params() const { return core_->components().params(kName); }
std::shared_ptr<const RawMessage> AnyHarness::Save() { return core_->components().Save(kName); }

Session& AnyHarness::session() const { return core_->session(); }
void* AnyHarness::FindObject(const std::type_info& type) const { return core_->components().FindObject(kName, type); }
void AnyHarness::RequireInput(std::string_view channel) const {
  Require(channel, core_->description().inputs, "does not subscribe to");
}
void AnyHarness::RequireOk(PublishStatus status) {
  if (status != PublishStatus::kOk) throw Error("The message cannot be fed: " + std::string(ToString(status)) + ".");
}
void AnyHarness::RequireService(std::string_view service) const {
  Require(service, core_->description().services, "does not serve");
}
std::vector<AnyMessage> AnyHarness::TakeAny(std::string_view channel, const TypeInfo& type) {
  return core_->Take(channel, type);
}

}  // namespace hgros::testing
