#include "hgros/params/param_service.hpp"

#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <utility>

#include <hgros/Params.pb.h>

#include "hgros/base/error.hpp"
#include "hgros/base/ids.hpp"
#include "params/param_wire.hpp"

namespace hgros {
namespace {

// Of questions that nobody has come to answer yet.
constexpr std::size_t kQuestions = 256;
// Those who ask may hear of the answers a little late, and ask once more.
constexpr std::size_t kAnswers = 64;

}  // namespace

// Invariant: states are published in the order of their versions, under mutex_.
class ParamService::Core {
 public:
  Core(Session& session, ParamServer& server, const std::string& name, LogSink log)
      : server_(server),
        name_(name),
        log_(std::move(log)),
        channels_(name),
        say_(session.Advertise<ParamsState>(channels_.state, {.latched = 1})),
        answer_(session.Advertise<ParamsAnswer>(channels_.answer, {.latched = kAnswers})) {
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
    auto last = std::make_unique<ParamsState>();
    last->set_life(life_);
    last->set_version(version_ + 1);
    last->set_ended(true);
    (void)say_(std::move(last));
  }

 private:
  // Says the state, if it is another one than before; its version.
  std::uint64_t Say() {
    const std::scoped_lock lock(mutex_);
    const ParamView root = server_.Snapshot();
    const std::vector<ParamDeclaration> declarations = server_.Declarations();
    if (version_ != 0 && root.node() == said_ && declarations.size() == declared_) return version_;
    said_ = root.node();
    declared_ = declarations.size();  // Declarations are never taken back.
    auto state = std::make_unique<ParamsState>();
    state->set_life(life_);
    state->set_version(++version_);
    param_wire::WriteValues(root, *state);
    param_wire::WriteDeclarations(declarations, *state);
    (void)say_(std::move(state));
    return version_;
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
        answer->set_refusal(server_.Change(param_wire::ReadChanges(question)).refusal);
      } catch (const Error& e) {
        answer->set_refusal(e.what());
      }
    }
    answer->set_version(Say());
    given_.push_back(answer);
    if (given_.size() > kAnswers) given_.pop_front();
    (void)answer_(given_.back());
  }

  void OnState(const ParamsState& state, const MessageInfo& info) {
    if (state.life() == life_ || state.ended()) return;
    log_.WriteLimited(LogLevel::kError, "another",
                      "Session " + SessionId{info.id.publisher}.ToString() + " offers parameters under the name \"" +
                          name_ + "\" as this one does, so both are asked. Give one of them another name.");
  }

  ParamServer& server_;
  const std::string name_;
  Log log_;
  const param_wire::Channels channels_;
  const std::uint64_t life_ = RandomId();
  const Publisher<ParamsState> say_;
  const Publisher<ParamsAnswer> answer_;

  std::mutex mutex_;
  std::uint64_t version_ = 0;  // guarded by mutex_, as the next two
  ParamNodePtr said_;
  std::size_t declared_ = 0;
  std::deque<std::shared_ptr<const ParamsAnswer>> given_;  // The latest; of the node that answers alone.
  Listening changes_;
  Subscription others_;
  Subscription questions_;
};

ParamService::ParamService(Session& session, ParamServer& server, std::string name, LogSink log)
    : core_(std::make_unique<Core>(session, server, name.empty() ? session.name() : name, std::move(log))) {}
ParamService::~ParamService() = default;

}  // namespace hgros
