#include "tracing/chrome_trace.hpp"

#include <algorithm>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include "robot/overview.hpp"
#include "terminal/json.hpp"

namespace hgros::cli {
namespace {

constexpr double kNsPerUs = 1e3;
constexpr double kPublishUs = 1;  // How long a publish outside callbacks is shown: an arrow must begin in a span.

class Writer {
 public:
  explicit Writer(const Traced& traced) : traced_(traced) {
    begin_ns_ = std::numeric_limits<std::int64_t>::max();
    for (const Traced::Publish& one : traced.publishes) begin_ns_ = std::min(begin_ns_, one.at_ns);
    for (const Traced::Run& one : traced.runs) begin_ns_ = std::min(begin_ns_, one.start_ns);
    for (const Traced::Session& session : traced.sessions) {
      const auto process = std::pair(session.host, session.pid);
      processes_.push_back(pids_.try_emplace(process, static_cast<std::int64_t>(pids_.size()) + 1).first->second);
    }
  }

  std::string Write() {
    json_.BeginObject().Key("traceEvents").BeginList();
    WriteProcesses();
    for (const Traced::Run& run : traced_.runs) WriteRun(run);
    WritePublishes();
    json_.EndList().Member("displayTimeUnit", "ms").Key("otherData");
    WriteClocks();
    json_.EndObject();
    return std::string(json_.text()) + "\n";
  }

 private:
  void Begin(const char* phase, std::size_t session, std::uint32_t thread, std::int64_t at_ns) {
    json_.BeginObject().Member("ph", phase).Member("pid", processes_[session]);
    json_.Member("tid", std::int64_t{thread})
        .Member("ts", static_cast<double>(Difference(at_ns, begin_ns_)) / kNsPerUs);
  }

  void WriteProcesses() {
    for (std::size_t i = 0; i < traced_.sessions.size(); ++i) {
      const Traced::Session& session = traced_.sessions[i];
      json_.BeginObject().Member("ph", "M").Member("name", "process_name").Member("pid", processes_[i]);
      json_.Key("args").BeginObject();
      json_.Member("name", ShortName(session.process, session.pid, session.host));
      json_.EndObject().EndObject();
    }
  }

  void WriteRun(const Traced::Run& run) {
    Begin("X", run.session, run.thread, run.start_ns);
    json_.Member("dur",
                 static_cast<double>(std::max<std::int64_t>(Difference(run.end_ns, run.start_ns), 0)) / kNsPerUs);
    json_.Member("name", run.node).Member("cat", "callback").Key("args").BeginObject().Member("channel", run.channel);
    json_.Member("message", SessionId{run.message}.ToString());
    json_.Member("wait_us", static_cast<double>(Difference(run.start_ns, run.received_ns)) / kNsPerUs)
        .EndObject()
        .EndObject();
  }

  void WriteArrow(const char* phase, const std::string& id, std::size_t session, std::uint32_t thread,
                  std::int64_t at_ns, const std::string& channel) {
    Begin(phase, session, thread, at_ns);
    json_.Member("id", id).Member("name", channel).Member("cat", "message");
    if (*phase == 'f') json_.Member("bp", "e");
    json_.EndObject();
  }

  void WritePublishes() {
    std::map<std::uint64_t, const Traced::Publish*> publishes;  // Ordered: peers choose the keys.
    for (const Traced::Publish& publish : traced_.publishes) {
      publishes.emplace(publish.message, &publish);
      if (!publish.node.empty()) continue;
      Begin("X", publish.session, publish.thread, publish.at_ns);
      json_.Member("dur", kPublishUs).Member("name", "publish " + publish.channel).Member("cat", "publish");
      json_.EndObject();
    }
    std::size_t number = 0;
    for (const Traced::Run& run : traced_.runs) {  // An arrow has one end.
      const auto found = publishes.find(run.message);
      if (found == publishes.end()) continue;
      const Traced::Publish& publish = *found->second;
      const std::string id = SessionId{run.message}.ToString() + "." + std::to_string(number++);
      WriteArrow("s", id, publish.session, publish.thread, publish.at_ns, publish.channel);
      WriteArrow("f", id, run.session, run.thread, run.start_ns, publish.channel);
    }
  }

  void WriteClocks() {
    json_.BeginObject().Member("begin_ns", traced_.publishes.empty() && traced_.runs.empty() ? 0 : begin_ns_);
    json_.Member("lost_events", traced_.lost).Key("clocks").BeginList();
    for (const Traced::Session& session : traced_.sessions) {
      json_.BeginObject().Member("session", session.id.ToString()).Member("host", session.host);
      if (session.clock) {
        json_.Member("offset_ns", std::int64_t{session.clock->offset.count()});
        json_.Member("uncertainty_ns", std::int64_t{session.clock->uncertainty.count()});
      } else {
        json_.Key("offset_ns").Null();
      }
      json_.EndObject();
    }
    json_.EndList().EndObject();
  }

  const Traced& traced_;
  std::int64_t begin_ns_ = 0;
  std::map<std::pair<std::string, std::int64_t>, std::int64_t> pids_;
  std::vector<std::int64_t> processes_;  // By session.
  Json json_;
};

}  // namespace

std::string ChromeTraceOf(const Traced& traced) { return Writer(traced).Write(); }

}  // namespace hgros::cli
