// Every command in situations that no command is made for.
#include <gmock/gmock.h>
#include <google/protobuf/descriptor.pb.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <iterator>
#include <map>
#include <memory>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include <foxglove/Log.pb.h>

#include "commands/commands.hpp"
#include "hgros/command_run.hpp"
#include "hgros/every/everything.hpp"
#include "hgros/help_examples.hpp"
#include "hgros/run_time_types.hpp"
#include "support/path.hpp"
#include "terminal/visible_text.hpp"

namespace hgros::cli {
namespace {

using foxglove::Log;
using Words = std::vector<std::string>;

// At least one run of each command, for a robot with Everything: channel "status", service "ask", parameters of "robot"
// with "speed", frames "map" and "base".
constexpr const char* kRuns =
    "list; list sessions; list nodes; list services; list params; list frames; list --all; info status; "
    "info robot; info hearing; info ask; echo status --once; echo status --once --csv; hz status --once; "
    "hz status --once --receive; bw status --once; bw status --once --receive; delay status --once; "
    "delay status --once --receive; delay status other --once --match 1; schema foxglove.Log; schema status; graph; "
    "graph --svg; graph --dot; "
    "graph --around hearing --depth 3; top --once; top nodes --once; top channels --once; tf tree; "
    "tf echo map base --once; tf watch; tf svg; tf static left right 1 2 3 0 0 0; doctor; doctor --verbose; path "
    "timer/tick status; "
    "trace --seconds 1; pub status '{message: hello}' --type foxglove.Log; "
    "call ask '{message: hello}' --type foxglove.Log; param list; param get robot speed; "
    "param describe robot speed; param watch robot; param set robot speed 2; param save robot; "
    "param load robot /dev/null; control close status; control open status; control forbid other; "
    "control allow other; control log info; control stop --session nobody; check /dev/null; check --schema; "
    "check --schema --robot-file; new /dev/null; run /dev/null; ps; logs; restart mapper; move mapper --to front; "
    "stop; wait; "
    "wait --service ask; "
    "bag info /dev/null; bag check /dev/null; bag recover /dev/null; "
    "export systemd robot.yaml; export compose robot.yaml; export kubernetes robot.yaml; components; help list; "
    "completion bash; __complete -- echo ''; __complete -- param get ''; __man; __hosted";

bool HasOption(const CommandEntry& entry, const std::string& name) {
  Arguments arguments;
  const auto command = entry.make();
  command->Declare(arguments);
  return std::ranges::any_of(arguments.all(), [&](const Argument& one) { return one.names == name; });
}

// Those of kRuns, each in all its forms. Those that would run forever have a --timeout.
std::vector<Words> RunsOfEveryCommand(const std::string& timeout = "3", bool with_json = true) {
  std::set<std::string_view> missing;
  for (const CommandEntry& entry : Commands()) {
    if (!entry.family()) missing.insert(entry.name);
  }
  std::vector<Words> runs;
  std::istringstream lines(kRuns);
  for (std::string line; std::getline(lines, line, ';');) {
    Words run = ShellWords(line);
    Words rest = run;
    const CommandEntry& entry = TakeCommand(rest);
    missing.erase(entry.name);
    if (HasOption(entry, "--timeout")) {
      run.insert(run.end() - static_cast<std::ptrdiff_t>(rest.size()), {"--timeout", timeout});
    }
    runs.push_back(run);
    const auto has = [&](const char* word) { return std::ranges::find(run, word) != run.end(); };
    if (!with_json || !HasOption(entry, "--json") || has("--svg") || has("--dot") || has("--csv")) continue;
    run.emplace_back("--json");
    runs.push_back(run);
  }
  EXPECT_THAT(missing, testing::IsEmpty()) << "Give this test lines for new commands.";
  return runs;
}

struct FinishedRun {
  Words words;
  int status = -1;  // As CommandRun::Wait().
  std::string out;
  std::string err;
};

// All of them at the same time.
std::vector<std::unique_ptr<CommandRun>> Start(const std::vector<Words>& runs,
                                               const std::map<std::string, std::string>& environment) {
  std::vector<std::unique_ptr<CommandRun>> started;
  for (const Words& words : runs) started.push_back(std::make_unique<CommandRun>(words, environment));
  return started;
}

std::vector<FinishedRun> Finish(const std::vector<Words>& runs, std::vector<std::unique_ptr<CommandRun>> started) {
  std::vector<FinishedRun> finished;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const int status = started[i]->Wait();
    finished.push_back({runs[i], status, started[i]->out(), started[i]->err()});
  }
  return finished;
}

// Both, with a few at once.
std::vector<FinishedRun> RunAll(const std::vector<Words>& runs, const std::map<std::string, std::string>& environment) {
  constexpr std::size_t kAtOnce = 8;
  std::vector<FinishedRun> finished;
  for (std::size_t begin = 0; begin < runs.size(); begin += kAtOnce) {
    const auto from = runs.begin() + static_cast<std::ptrdiff_t>(begin);
    const std::vector<Words> part(from, from + static_cast<std::ptrdiff_t>(std::min(kAtOnce, runs.size() - begin)));
    std::ranges::move(Finish(part, Start(part, environment)), std::back_inserter(finished));
  }
  return finished;
}

// Expects that it has ended by itself, and has said why if it was in vain.
void ExpectGoodEnd(const FinishedRun& run) {
  const std::string line = testing::PrintToString(run.words);
  EXPECT_THAT(run.status, testing::AnyOf(0, 1, 2, 3)) << line << " does not end by itself: " << run.out << run.err;
  // The doctor's findings are its output, and a shell that completes words wants no sentences.
  const bool says_why = !run.err.empty() || run.words.front() == "doctor" || run.words.front() == "__complete" ||
                        (run.status == 3 && !run.out.empty());
  EXPECT_TRUE(run.status == 0 || says_why) << line << " ends with " << run.status << " without a word.";
  for (const std::string& sentence : LinesOf(run.err)) {
    EXPECT_THAT(sentence, testing::StartsWith("hgros: ")) << line;
    EXPECT_THAT(sentence, testing::AnyOf(testing::EndsWith("."), testing::EndsWith("?"))) << line;
  }
}

TEST(EveryCommand, EndsWithASentenceWhenNothingRuns) {
  for (const FinishedRun& run : RunAll(RunsOfEveryCommand(), OwnDomain())) ExpectGoodEnd(run);
}

TEST(EveryCommand, EndsWithASentenceWhenTheSessionDiesWhileItIsAsked) {
  // Each takes an inotify instance. All at once would take those that other tests need: a user often has 128.
  constexpr std::size_t kAtOnce = 24;
  const auto all = RunsOfEveryCommand();
  for (std::size_t begin = 0; begin < all.size(); begin += kAtOnce) {
    const auto from = all.begin() + static_cast<std::ptrdiff_t>(begin);
    const std::vector<Words> runs(from, from + static_cast<std::ptrdiff_t>(std::min(kAtOnce, all.size() - begin)));
    const std::map<std::string, std::string> environment = OwnDomain();
    const CommandRun victim({}, environment, -1, test::Path("everything"));
    for (const char* what : {"channels", "services", "params"}) {
      ASSERT_TRUE(test::Await([&] { return !RunToEnd({"list", what}, environment).out.empty(); })) << victim.err();
    }
    victim.Signal(SIGSTOP);
    auto started = Start(runs, environment);
    test::Linger(std::chrono::milliseconds(500));
    victim.Signal(SIGKILL);
    for (const FinishedRun& run : Finish(runs, std::move(started))) ExpectGoodEnd(run);
  }
}

TEST(EveryCommand, ShowsNothingRawThatARobotHasChosen) {
  const std::string escapes = "\x1b]0;owned\x07\x1b[31m\xC2\x9B\x7F\xE2\x80\xAE\r\n";
  RobotForCommands robot("robot");
  const Everything everything(robot.session(), escapes);
  const auto grip = std::make_shared<const std::string>(GripBytes(1, "a\xFF" + escapes));
  const NodeTimer timer = robot.session().CreateTimer("grip", std::chrono::milliseconds(20), [&](const Tick&) {
    (void)robot.session().ToAnyRaw("grip", GripSchema(), {AsBytes(*grip), grip});
  });
  robot.AwaitAnnounced();
  auto runs = RunsOfEveryCommand();
  runs.push_back({"echo", "--timeout", "3", "--once", "grip"});
  std::size_t shown = 0;
  for (const FinishedRun& run : RunAll(runs, robot.environment())) {
    ExpectGoodEnd(run);
    if (run.words.front() == "__hosted") continue;  // Its output is for programs.
    const std::string all = run.out + run.err;
    const auto [raw, shown_as] = std::ranges::mismatch(all, VisibleLines(all));
    EXPECT_EQ(raw, all.end()) << testing::PrintToString(run.words) << " writes byte " << int(*raw) << " raw.";
    if (run.out.find("owned") != std::string::npos) ++shown;
  }
  EXPECT_GT(shown, 8U) << "The names were there to be shown.";
}

TEST(EveryCommand, NamesASessionAlikeInJson) {
  RobotForCommands robot("robot");
  const Everything everything(robot.session(), "");
  robot.AwaitAnnounced();
  const std::regex alike(R"re("process":"\w+","pid":\d+,"host":")re");
  std::vector<Words> runs{{"list", "sessions", "--json"},
                          {"list", "nodes", "--json"},
                          {"info", "status", "--json"},
                          {"info", "hearing", "--json"},
                          {"delay", "status", "--once", "--json"},
                          {"graph", "--json"},
                          {"top", "--once", "--json"},
                          {"top", "nodes", "--once", "--json"},
                          {"control", "open", "status", "--json"}};
  for (Words& words : runs) words = Patiently(words);
  for (const FinishedRun& run : RunAll(runs, robot.environment())) {
    EXPECT_NE(run.out.find("\"process\":\"robot\""), std::string::npos) << run.out << run.err;
    const std::string others = std::regex_replace(run.out, alike, "");
    EXPECT_EQ(others.find("\"process\":"), std::string::npos) << testing::PrintToString(run.words) << others;
  }
}

// 7,500 fields with long names in types that are nested: almost 1 MiB, which is the most that a schema may have.
MessageSchema HugeSchema() {
  using google::protobuf::FieldDescriptorProto;
  google::protobuf::FileDescriptorSet set;
  auto& file = *set.add_file();
  file.set_name("huge.proto");
  file.set_package("huge");
  file.set_syntax("proto3");
  constexpr int kTypes = 50;
  constexpr int kFields = 150;
  for (int i = 0; i < kTypes; ++i) {
    auto& type = *file.add_message_type();
    type.set_name("Type" + std::to_string(i));
    for (int j = 1; j <= kFields; ++j) {
      auto& field = *type.add_field();
      field.set_name("field" + std::to_string(j) + "_" + std::string(90, 'x'));
      field.set_number(j);
      field.set_label(FieldDescriptorProto::LABEL_OPTIONAL);
      field.set_type(j == kFields ? FieldDescriptorProto::TYPE_MESSAGE : FieldDescriptorProto::TYPE_STRING);
      if (j == kFields) field.set_type_name(".huge.Type" + std::to_string((i + 1) % kTypes));
    }
  }
  return {"huge.Type0", Encoding::kProtobuf, 0, set.SerializeAsString()};
}

// Its messages have 4 MB, and come as fast as they can.
TEST(EveryCommand, EndsInTimeBesideAHugeTypeAndEndlessMessages) {
  RobotForCommands robot("robot");
  const Everything everything(robot.session(), "");
  const auto bytes = std::make_shared<std::string>("\x0A\x80\x80\x80\x02");  // Field 1, 4 MiB.
  bytes->append(4 << 20, 'm');
  const RawPublisher publish = robot.session().AdvertiseRaw("huge", HugeSchema());
  const NodeTimer timer = robot.session().CreateTimer("huge", std::chrono::milliseconds(1), [&](const Tick&) {
    (void)publish({AsBytes(*bytes), bytes});
  });
  ASSERT_TRUE(test::Await([&] { return robot.Run({"list"}).out.find("huge.Type0") != std::string::npos; }));
  const std::vector<Words> runs{
      {"list"},
      {"info", "huge"},
      {"echo", "huge", "--once"},
      {"echo", "huge", "--once", "--json", "--field", "field2_" + std::string(90, 'x')},
      {"echo", "huge", "--timeout", "1", "--filter", "field1_" + std::string(90, 'x') + " == \"no\""},
      {"echo", "huge", "--once", "--csv"},
      {"echo", "huge", "-n", "3", "--raw"},
      {"hz", "huge", "--once", "--receive"},
      {"schema", "huge"},
      {"schema", "huge.Type0", "--json"},
      {"pub", "huge", "{field2_" + std::string(90, 'x') + ": hello}"},
      {"pub", "huge", "{nothing: 1}"},
      {"top", "channels", "--once"},
      {"graph"},
      {"doctor"}};
  for (const FinishedRun& run : RunAll(runs, robot.environment())) ExpectGoodEnd(run);
}

TEST(EveryCommand, EndsInTimeBesideTenThousandChannels) {
  RobotForCommands robot("robot");
  const Everything everything(robot.session(), "");
  std::vector<Publisher<Log>> publishers;
  for (int i = 0; i < 10'000; ++i) {
    publishers.push_back(robot.session().Advertise<Log>("part/of/a/large/robot" + std::to_string(i)));
  }
  ASSERT_TRUE(test::Await([&] {
    return LinesOf(RunToEnd({"list", "--timeout", "5"}, robot.environment()).out).size() > 10'000;
  }));
  const auto runs = RunsOfEveryCommand("5", false);
  for (const FinishedRun& run : RunAll(runs, robot.environment())) ExpectGoodEnd(run);
}

}  // namespace
}  // namespace hgros::cli
