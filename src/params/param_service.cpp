#include "hgros/params/param_service.hpp"

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include <hgros/Params.pb.h>

#include "hgros/base/error.hpp"
#include "hgros/base/fork_guard.hpp"
#include "hgros/base/ids.hpp"
#include "hgros/base/system_limits.hpp"
#include "hgros/clock/time.hpp"
#include "params/param_wire.hpp"

namespace hgros {
namespace {

// Number of questions that may wait for an answer.
constexpr std::size_t kQuestions = 256;
// Number of answers that are kept: an asker may subscribe to the answers late, or repeat its question.
constexpr std::size_t kLatchedAnswers = 64;
// How long a state waits for room before a newer one replaces it. The final state waits this long, too.
constexpr auto kPatience = std::chrono::milliseconds(100);

}  // namespace

// Invariants: states are published in the order of their versions. That happens under mutex_, or, while a lossless
// subscriber has no room (owed_), on the thread pays_ only, which publishes the newest state.
class ParamService::Core {
 public:
  const ForkGuard fork;  // A child has none of the threads.
  Core(Session& session, ParamServer& server, const std::string& name, LogSink log)
      : server_(server),
        session_(session),
        name_(name),
        log_(std::move(log)),
        channels_(name),
        say_(session.Advertise<ParamsState>(channels_.state, {.latched = 1})),
        answer_(session.Advertise<ParamsAnswer>(channels_.answer, {.latched = kLatchedAnswers})) {
    others_ = session.FromAny<ParamsState>(
        channels_.state, Invoke::kSerial,
        [this](const ParamsState& state, const MessageInfo& info) { OnState(state, info); },
        {channels_.state + "#service", {}, Executor::Inline()});
    questions_ = session.FromAny<ParamsQuestion>(
        channels_.ask, Invoke::kSerial, [this](const ParamsQuestion& question) { OnQuestion(question); },
        {channels_.ask + "#service", Queue::KeepAll(kQuestions), Executor::Dedicated()});
    changes_ = server_.OnChange("", [this](const ParamEvent&) { (void)Say(); });
    (void)Say();
  }
  Core(const Core&) = delete;
  Core& operator=(const Core&) = delete;
  ~Core() {
    (void)questions_.Join();
    changes_.Reset();
    (void)others_.Join();
    if (pays_.joinable()) {
      pays_.request_stop();
      pays_.join();
    }
    auto last = std::make_unique<ParamsState>();
    last->set_life(life_);
    last->set_version(version_ + 1);
    last->set_ended(true);
    (void)say_.Wait(std::move(last), std::chrono::steady_clock::now() + kPatience);
  }

 private:
  // Publishes the state if it has changed. Returns its version.
  std::uint64_t Say() {
    const std::scoped_lock lock(mutex_);
    const bool changed = Look();
    const bool paying = owed_ && pays_.joinable();
    if (paying || (!changed && !owed_)) return version_;
    owed_ = say_(State()) == PublishStatus::kFull;
    if (owed_) PayLater();
    return version_;
  }

  void PayLater() {
    try {
      if (!pays_.joinable()) {
        pays_ = StartThread<std::jthread>("the thread that publishes parameters again",
                                          [this](const std::stop_token& stop) { Pay(stop); });
      }
      owes_.notify_one();
    } catch (const Error& e) {  // The next call of Say() tries again.
      log_.WriteLimited(LogLevel::kError, "pay", std::string("A subscriber misses new parameters. ") + e.what());
    }
  }

  // True if there is a newer state, which it then stores. Call it under mutex_, like State().
  bool Look() {
    ParamNodePtr root = server_.Snapshot().node();
    std::vector<ParamDeclaration> declared = server_.Declarations();
    // Declarations are never removed, so their number shows a change.
    if (version_ != 0 && root == said_ && declared.size() == declared_.size()) return false;
    said_ = std::move(root);
    declared_ = std::move(declared);
    ++version_;
    return true;
  }

  [[nodiscard]] std::unique_ptr<ParamsState> State() const {
    auto state = std::make_unique<ParamsState>();
    state->set_life(life_);
    state->set_version(version_);
    param_wire::WriteValues(ParamView(said_), *state);
    param_wire::WriteDeclarations(declared_, *state);
    return state;
  }

  void Pay(const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    while (owes_.wait(lock, stop, [this] { return owed_; }) && !stop.stop_requested()) {
      auto state = State();
      const std::uint64_t version = version_;
      lock.unlock();
      const PublishStatus status = say_.Wait(std::move(state), std::chrono::steady_clock::now() + kPatience, stop);
      lock.lock();
      owed_ = status == PublishStatus::kTimedOut || version != version_;
    }
  }

  void OnQuestion(const ParamsQuestion& question) {
    for (const auto& given : given_) {
      if (given->asker() != question.asker() || given->number() != question.number()) continue;
      (void)answer_(given);
      return;
    }
    auto answer = std::make_shared<ParamsAnswer>();
    answer->set_asker(question.asker());
    answer->set_number(question.number());
    answer->set_life(life_);
    if (!question.changes().empty()) {
      try {
        const IfMissing if_missing = question.create() ? IfMissing::kCreate : IfMissing::kRefuse;
        answer->set_refusal(server_.Change(param_wire::ReadChanges(question), if_missing).refusal);
      } catch (const Error& e) {
        answer->set_refusal(e.what());
      }
    }
    answer->set_version(Say());
    given_.push_back(answer);
    if (given_.size() > kLatchedAnswers) given_.pop_front();
    (void)answer_(given_.back());
  }

  void OnState(const ParamsState& state, const MessageInfo& info) {
    if (state.life() == life_ || state.ended()) return;
    // What offered them earlier hears of this one, and says so itself, unless it ends at this moment.
    if (info.publish_monotonic_ns < began_ns_) return;
    const SessionId other{info.id.publisher};
    log_.WriteLimited(LogLevel::kError, "another",
                      other == session_.id()
                          ? "This session offers parameters under the name \"" + name_ +
                                "\" more than once, so all of these are asked. Offer them once, or under other names."
                          : session_.NameOf(other) + " also offers parameters as \"" + name_ +
                                "\". Rename one, or give each robot its own HGROS_DOMAIN.");
  }

  ParamServer& server_;
  Session& session_;
  const std::string name_;
  Log log_;
  const param_wire::Channels channels_;
  const std::uint64_t life_ = RandomId();
  const std::int64_t began_ns_ = MonotonicNow();
  const Publisher<ParamsState> say_;
  const Publisher<ParamsAnswer> answer_;

  std::mutex mutex_;
  std::condition_variable_any owes_;
  std::uint64_t version_ = 0;  // guarded by mutex_, as the next three
  ParamNodePtr said_;
  std::vector<ParamDeclaration> declared_;
  bool owed_ = false;
  std::deque<std::shared_ptr<const ParamsAnswer>> given_;  // The latest answers; used only by the node that answers.
  Listening changes_;
  Subscription others_;
  Subscription questions_;
  std::jthread pays_;  // Started when a subscriber has no room for the first time.
};

ParamService::ParamService(Session& session, ParamServer& server, std::string name, LogSink log)
    : core_(std::make_unique<Core>(session, server, name.empty() ? session.name() : name, std::move(log))) {}
ParamService::~ParamService() {
  if (core_->fork.IsChild()) LeaveToParent(std::shared_ptr<const Core>(std::move(core_)));
}

}  // namespace hgros
