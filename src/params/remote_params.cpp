#include "hgros/params/remote_params.hpp"

#include <algorithm>
#include <exception>
#include <utility>

#include "hgros/base/names.hpp"
#include "hgros/clock/time.hpp"
#include "params/param_tree.hpp"
#include "params/param_wire.hpp"
#include "params/remote_mirror.hpp"

namespace hgros {
namespace {

constexpr std::size_t kWaitingAnswers = 256;
constexpr auto kLookForEnd = std::chrono::milliseconds(100);  // How often a wait looks whether somebody offers them.
constexpr auto kLastState = std::chrono::milliseconds(300);   // For the last state of a session that ends.
constexpr auto kFirstPause = std::chrono::milliseconds(100);  // Before the first repetition of a question.

// True if `path` is `top` or is below it.
bool IsBelow(const ParamPath& path, const ParamPath& top) {
  return path.steps().size() >= top.steps().size() && path.Overlaps(top);
}

// For a watch of a path that does not exist.
std::string NothingAt(const ParamPath& path, const ParamNodePtr& root, const std::string& name) {
  std::vector<std::string> existing;
  for (const std::string& value : param_tree::ListBelow(ParamView(root))) {
    std::vector<ParamPath::Step> steps = ParamPath::Parse(value).steps();
    for (; !steps.empty(); steps.pop_back()) existing.push_back(ParamPath(steps).ToString());
  }
  const std::string nearest = NearestName(path.ToString(), existing);
  return "A watch waits for the parameter " + path.ToString() + ", which the session \"" + name +
         "\" does not have so far." + (nearest.empty() ? std::string() : " Did you mean " + nearest + "?");
}

std::string CauseOf(PublishStatus status) {
  switch (status) {
    case PublishStatus::kClosed: return "this session is shutting down";
    case PublishStatus::kNoMemory: return "there is no memory to write the question";
    case PublishStatus::kTooLarge: return "the question is larger than 1 GiB";
    default: return std::string(ToString(status));
  }
}

}  // namespace

class RemoteParams::Core {
 public:
  Core(Session& session, std::string_view name, std::chrono::nanoseconds timeout, LogSink log)
      : session_(session),
        log_(std::make_shared<Log>(std::move(log))),
        name_(name),
        timeout_(timeout),
        channels_(name),
        mirror_(std::make_shared<RemoteMirror>(name_)),
        ask_(session.Advertise<ParamsQuestion>(channels_.ask)),
        states_(session.FromAny<ParamsState>(channels_.state, Invoke::kSerial,
                                             [mirror = mirror_](const ParamsState& state) { mirror->OnState(state); },
                                             {{}, {}, Executor::Inline()})),
        answers_(
            session.FromAny<ParamsAnswer>(channels_.answer, Invoke::kSerial,
                                          [mirror = mirror_](const ParamsAnswer& answer) { mirror->OnAnswer(answer); },
                                          {{}, Queue::KeepLast(kWaitingAnswers), Executor::Inline()})) {}

  RemoteMirror::Outcome Ask(const std::vector<ParamChange>& changes, IfMissing if_missing = IfMissing::kRefuse) {
    const auto deadline = DeadlineIn(timeout_);
    if (!AwaitOffer(deadline)) return mirror_->ended() ? mirror_->Ended() : RemoteMirror::Outcome{{}, NobodyThere()};
    ParamsQuestion question = mirror_->NextQuestion();
    param_wire::WriteChanges(changes, question);
    question.set_create(if_missing == IfMissing::kCreate);
    RemoteMirror::Outcome outcome;
    if (const PublishStatus status = Say(question, deadline); status == PublishStatus::kOk) {
      outcome = Wait(question, deadline);
    } else {
      outcome.refusal = "The session \"" + name_ + "\" could not be asked: " + CauseOf(status) + ".";
    }
    mirror_->Forget(question);
    return outcome;
  }

  Subscription Watch(ParamPath path, ParamListener listener) {
    return session_.FromAny<ParamsState>(
        channels_.state, Invoke::kSerial,
        [name = name_, log = log_, path = std::move(path), listener = std::move(listener),
         before = param_tree::EmptyRoot(), first = true](const ParamsState& state) mutable {
          if (state.ended()) return;
          const ParamNodePtr after = param_wire::ReadValues(state, "parameters of " + name);
          if (std::exchange(first, false) && param_tree::Find(after, path) == nullptr) {
            log->Write(LogLevel::kWarning, NothingAt(path, after, name));
          }
          ParamEvent event{ParamView(before), ParamView(after), {}};
          for (param_tree::Difference& difference : param_tree::Differences(before, after)) {
            event.paths.push_back(std::move(difference.path));
          }
          before = after;
          if (!event.paths.empty() && event.Touches(path)) listener(event);
        },
        {{}, Queue::Latest(), {}});
  }

  void EndWaits() noexcept { mirror_->EndWaits(); }

 private:
  // Repeats the question until there is an answer, because the offering session may be starting or ending. A repeated
  // question is carried out only once. Returns kOk, or why the question cannot be published.
  PublishStatus Say(const ParamsQuestion& question, std::chrono::steady_clock::time_point deadline) {
    for (std::chrono::nanoseconds pause = kFirstPause;; pause *= 2) {
      const PublishStatus status = ask_(question);
      if (status != PublishStatus::kOk && status != PublishStatus::kFull) return status;
      const auto until = DeadlineIn(pause);
      if (until >= deadline || mirror_->AwaitAnswer(question, until)) return PublishStatus::kOk;
    }
  }
  // A session may end after its answer, and before its state arrives.
  RemoteMirror::Outcome Wait(const ParamsQuestion& question, std::chrono::steady_clock::time_point deadline) const {
    for (;;) {
      const auto now = std::chrono::steady_clock::now();
      if (auto outcome = mirror_->Wait(question, std::min(deadline, now + kLookForEnd))) return *std::move(outcome);
      if (std::chrono::steady_clock::now() >= deadline) return mirror_->Late(question);
      if (!mirror_->AwaitAnswer(question, now)) continue;  // It may be starting again.
      if (session_.WaitForSubscribers(channels_.ask, 1, std::chrono::nanoseconds(0))) continue;
      if (auto outcome = mirror_->Wait(question, DeadlineIn(kLastState))) return *std::move(outcome);
      return {{}, "The session \"" + name_ + "\" has ended after its answer, and its parameters have not arrived."};
    }
  }
  bool AwaitOffer(std::chrono::steady_clock::time_point deadline) const {
    for (auto now = std::chrono::steady_clock::now(); !mirror_->ended();) {
      const auto until = std::min(deadline, now + kLookForEnd);
      if (session_.WaitForSubscribers(channels_.ask, 1, until - now)) return true;
      now = std::chrono::steady_clock::now();
      if (now >= deadline || now < until) return false;  // Nobody, or the session ends.
    }
    return false;
  }
  std::string NobodyThere() const {
    std::vector<std::string> names;
    for (const PeerInfo& peer : session_.Peers()) names.push_back(peer.process);
    const std::string nearest = NearestName(name_, names);
    return "No session \"" + name_ + "\" offers parameters." +
           (nearest.empty() || nearest == name_ ? std::string() : " Did you mean \"" + nearest + "\"?");
  }

  Session& session_;
  const std::shared_ptr<Log> log_;  // A watch may outlive this object.
  const std::string name_;
  const std::chrono::nanoseconds timeout_;
  const param_wire::Channels channels_;
  const std::shared_ptr<RemoteMirror> mirror_;
  const Publisher<ParamsQuestion> ask_;
  const Subscription states_;
  const Subscription answers_;
};

RemoteParams::RemoteParams(Session& session, std::string_view name, std::chrono::nanoseconds timeout, LogSink log)
    : core_(std::make_unique<Core>(session, name, timeout, std::move(log))) {}
RemoteParams::~RemoteParams() = default;

RemoteParam<ParamView> RemoteParams::Snapshot() {
  RemoteMirror::Outcome outcome = core_->Ask({});
  if (!outcome.state) return {{}, std::move(outcome.refusal)};
  return {ParamView(std::move(outcome.state->root)), {}};
}

RemoteParam<std::vector<std::string>> RemoteParams::List(std::string_view path) {
  RemoteParam<ParamView> all = Snapshot();
  if (!all.ok()) return {{}, std::move(all.refusal)};
  try {
    return {param_tree::ListBelow(all->At(path)), {}};
  } catch (const ParamError& e) {
    return {{}, e.what()};
  }
}

RemoteParam<std::vector<ParamDeclaration>> RemoteParams::Describe(std::string_view path) {
  RemoteMirror::Outcome outcome = core_->Ask({});
  if (!outcome.state) return {{}, std::move(outcome.refusal)};
  try {
    const ParamPath top = ParamPath::Parse(path);
    std::vector<ParamDeclaration> declarations = std::move(outcome.state->declarations);
    std::erase_if(declarations, [&](const ParamDeclaration& declaration) {
      return !IsBelow(ParamPath::Parse(declaration.path), top);
    });
    return {std::move(declarations), {}};
  } catch (const ParamError& e) {
    return {{}, e.what()};
  }
}

ParamResult RemoteParams::Change(const std::vector<ParamChange>& changes, IfMissing if_missing) {
  if (changes.empty()) return {};
  return {core_->Ask(changes, if_missing).refusal};
}

void RemoteParams::EndWaits() noexcept { core_->EndWaits(); }

Subscription RemoteParams::Watch(std::string_view path, ParamListener listener) {
  return core_->Watch(ParamPath::Parse(path), std::move(listener));
}

}  // namespace hgros
