#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>

#include <array>
#include <cstdlib>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <foxglove/Log.pb.h>

#include "hgros/command_run.hpp"
#include "hgros/help_examples.hpp"
#include "hgros/proto_folder.hpp"
#include "hgros/session/session_control.hpp"
#include "hgros/transport/curve_key_pair.hpp"
#include "support/path.hpp"

namespace hgros::cli {
namespace {

using foxglove::Log;
using testing::AllOf;
using testing::EndsWith;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

bool IsClosed(RobotForCommands& robot, const std::string& channel) {
  for (const ChannelSnapshot& one : robot.session().Snapshot().graph.channels) {
    if (one.name == channel) return one.closed;
  }
  return false;
}

TEST(HgrosControl, ClosesAndOpensAChannelWhereItIsUsed) {
  RobotForCommands robot("talker");
  RobotForCommands other("other", robot.domain());
  const auto scan = robot.session().Advertise<Log>("scan");
  const auto map = other.session().Advertise<Log>("map");
  other.AwaitAnnounced();
  EXPECT_THAT(robot.Run({"control", "close", "scan", "--timeout", "40"}),
              Prints(0, AllOf(StartsWith("SESSION"), HasSubstr("talker:"), HasSubstr("Channel \"scan\" is closed"),
                              Not(HasSubstr("other:")))));
  EXPECT_TRUE(IsClosed(robot, "scan"));
  EXPECT_THAT(robot.Run({"control", "open", "scan", "--timeout", "40", "--json"}).out,
              AllOf(StartsWith("{\"process\":\"talker\",\"pid\":"), HasSubstr("\"done\":true"),
                    HasSubstr("\"answer\":\"Channel \\\"scan\\\" is open")));
  EXPECT_FALSE(IsClosed(robot, "scan"));
  EXPECT_THAT(robot.Run({"control", "close", "scna"}),
              Ends(1, EndsWith("hgros: No session uses scna. Did you mean scan?\n")));

  RobotForCommands off("off", robot.domain(), "control: off\n");  // It does not take orders.
  const auto offered = off.session().Advertise<Log>("scan");
  off.AwaitAnnounced();
  EXPECT_THAT(robot.Run({"control", "close", "scan", "--timeout", "40"}),
              Prints(1, AllOf(HasSubstr("is closed"), HasSubstr("its configuration says `control: off`"))));
}

// A component that moves asks each subscriber whether it has what was published, and waits 200 ms for an answer.
TEST(HgrosControl, ACommandThatReceivesAnswersToo) {
  RobotForCommands robot("talker");
  const auto scan = robot.session().Advertise<Log>("scan");
  robot.AwaitAnnounced();
  const CommandRun echo({"echo", "scan"}, robot.environment());
  std::vector<SessionId> sessions;
  ASSERT_TRUE(test::Await([&] {
    for (const KnownChannel& channel : robot.session().Channels()) {
      if (channel.name != "scan" || channel.subscribers.empty()) continue;
      sessions.push_back(channel.subscribers.front().session);
    }
    return !sessions.empty();
  }));
  const auto answers = AskSessions(robot.session(), sessions, {ControlAction::kDescribe, "scan", {}}, test::kPatience);
  EXPECT_TRUE(answers.at(0).answered);
}

TEST(HgrosControl, AsksAllSessionsThatAPatternMatchesAsInItsExamples) {
  RobotForCommands left("left_arm");
  RobotForCommands right("right_arm", left.domain());
  RobotForCommands base("base", left.domain());
  std::vector<Publisher<Log>> publishers;
  for (RobotForCommands* robot : {&left, &right, &base}) {
    publishers.push_back(robot->session().Advertise<Log>("status"));
    robot->AwaitAnnounced();
  }
  const auto run = [&](const std::vector<std::string>& words) { return RunToEnd(words, left.environment()); };
  EXPECT_THAT(run({"control", "forbid", "status", "--timeout", "40", "--session", "*_arm", "--json"}),
              Prints(0, AllOf(testing::ResultOf(LinesOf, testing::SizeIs(2)), Not(HasSubstr("base")))));
  EXPECT_THAT(run({"control", "allow", "status", "--timeout", "40", "--session", base.session().id().ToString()}).out,
              AllOf(HasSubstr("base:"), Not(HasSubstr("_arm:"))));
  EXPECT_THAT(LinesOf(run({"control", "log", "error", "--json", "--timeout", "40"}).out), testing::SizeIs(3));
  EXPECT_THAT(run({"control", "log", "error", "--session", "bsae"}),
              Ends(1, EndsWith("hgros: No session is called bsae. Did you mean base?\n")));

  RobotForCommands talker("talker");
  const auto scan = talker.session().Advertise<Log>("scan");
  talker.AwaitAnnounced();  // Not while a channel is forbidden, which is not announced.
  for (const char* command : {"control close", "control open", "control forbid", "control allow", "control log"}) {
    for (const std::vector<std::string>& example : ExamplesOf(command)) {
      EXPECT_THAT(RunToEnd(Patiently(example), talker.environment()), Prints(0, HasSubstr("talker:")))
          << testing::PrintToString(example);
    }
  }
}

// As between hosts: endpoints and keys, without discovery.
TEST(HgrosControl, ReachesSessionsWithAnAllowedKeyThroughTheEndpointsOfAFile) {
  const CurveKeyPair robots = GenerateCurveKeyPair();
  const CurveKeyPair desks = GenerateCurveKeyPair();
  const ProtoFolder folder{};
  const auto yaml = [&](const std::string& own, const CurveKeyPair& own_key, const std::string& other,
                        const CurveKeyPair& other_key) {
    const auto at = [&](const std::string& name) { return "'ipc://" + folder.path() + "/" + name + ".ipc'"; };
    return "network:\n  publisher: {ip: " + at(own) + "}\n  subscribers: [{ip: " + at(other) + "}]\n  security:\n" +
           "    public_key: '" + own_key.public_key + "'\n    secret_key: '" + own_key.secret_key + "'\n" +
           "    allowed_clients: ['" + other_key.public_key + "']\n    servers: {" + at(other) + ": '" +
           other_key.public_key + "'}\ndiscovery: {local: false}\n";
  };
  const std::string file = folder.Write("desk.yaml", yaml("desk", desks, "robot", robots));
  Session robot(Config::Parse(yaml("robot", robots, "desk", desks)),
                {.name = "talker", .log = [](LogLevel, std::string_view) {}});
  const auto scan = robot.Advertise<Log>("scan");
  EXPECT_THAT(RunToEnd({"control", "close", "scan", "--config", file, "--timeout", "40"}),
              Prints(0, HasSubstr("Channel \"scan\" is closed")));
}

// A robot that lets in one key, and the file with the keys of a desk that has no endpoint.
struct RobotAndDeskWithKeys {
  const CurveKeyPair robots = GenerateCurveKeyPair();
  const CurveKeyPair desks = GenerateCurveKeyPair();
  const ProtoFolder folder{};
  const std::string robot = "network:\n  publisher: {ip: 'tcp://127.0.0.1:*'}\n  security: {public_key: '" +
                            robots.public_key + "', secret_key: '" + robots.secret_key + "', allowed_clients: ['" +
                            desks.public_key + "']}\ndiscovery: {local: false}\n";

  // The words of a command that connects to the endpoint.
  [[nodiscard]] std::vector<std::string> Command(std::vector<std::string> words, const std::string& endpoint) const {
    const std::string desk = "network:\n  security: {public_key: '" + desks.public_key + "', secret_key: '" +
                             desks.secret_key + "', servers: {'" + endpoint + "': '" + robots.public_key + "'}}\n";
    words.insert(words.end(), {"--config", folder.Write("desk.yaml", desk), "--connect", endpoint, "--timeout", "40"});
    return words;
  }
};

TEST(HgrosControl, SteersThroughConnectAloneWithAnAllowedKey) {
  const RobotAndDeskWithKeys keys;
  Session robot(Config::Parse(keys.robot), {.name = "talker", .log = [](LogLevel, std::string_view) {}});
  const auto scan = robot.Advertise<Log>("scan");
  const std::string endpoint = robot.PublisherEndpoints().at(0);
  const std::map<std::string, std::string> own = OwnDomain();
  for (const auto& [action, state] :
       {std::pair("close", "closed"), {"open", "open"}, {"forbid", "forbidden"}, {"allow", "allowed"}}) {
    EXPECT_THAT(RunToEnd(keys.Command({"control", action, "scan"}, endpoint), own),
                Prints(0, AllOf(HasSubstr("talker:"), HasSubstr("Channel \"scan\" is " + std::string(state)))));
  }
  EXPECT_THAT(RunToEnd(keys.Command({"control", "log", "error"}, endpoint), own),
              Prints(0, HasSubstr("below the level error")));
  EXPECT_EQ(robot.Snapshot().refused_orders, 0U);
}

TEST(HgrosControl, IsRefusedThroughConnectWithoutKeys) {
  const ProtoFolder folder{};
  const std::string endpoint = "ipc://" + folder.path() + "/robot.ipc";
  Session robot(Config::Parse("network: {publisher: {ip: '" + endpoint + "'}}\ndiscovery: {local: false}\n"),
                {.name = "talker", .log = [](LogLevel, std::string_view) {}});
  const auto scan = robot.Advertise<Log>("scan");
  EXPECT_THAT(RunToEnd(Patiently({"control", "close", "scan", "--connect", endpoint}), OwnDomain()),
              Prints(1, HasSubstr("those whose CURVE key is in network.security.allowed_clients")));
}

TEST(HgrosControl, RefusesWrongArguments) {
  EXPECT_THAT(RunToEnd({"control", "stop"}), Ends(2, HasSubstr("--session '*'")));
  EXPECT_EQ(RunToEnd({"control", "log"}).status, 2);
  EXPECT_THAT(RunToEnd({"control", "log", "wraning"}).err, HasSubstr("warning"));
  EXPECT_EQ(RunToEnd({"control", "close", "a b"}).status, 2);
  const RobotForCommands idle;  // It uses no channel.
  EXPECT_THAT(RunToEnd({"control", "log", "info"}, idle.environment()),
              Ends(1, HasSubstr("hgros: No sessions in domain " + idle.domain() + ".")));
}

// The example publisher as a process, which handles SIGTERM.
class ExamplePublisher {
 public:
  explicit ExamplePublisher(const std::string& domain, std::string config = {}) {
    std::string program = test::Path("example_publisher");
    std::string setting = "HGROS_DOMAIN=" + domain;
    std::array<char*, 3> words{program.data(), config.empty() ? nullptr : config.data(), nullptr};
    std::array<char*, 2> settings{setting.data(), nullptr};
    if (posix_spawn(&pid_, program.c_str(), nullptr, nullptr, words.data(), settings.data()) != 0) pid_ = -1;
  }
  ExamplePublisher(const ExamplePublisher&) = delete;
  ExamplePublisher& operator=(const ExamplePublisher&) = delete;
  ~ExamplePublisher() {
    if (pid_ <= 0 || status_) return;
    (void)kill(pid_, SIGCONT);
    (void)kill(pid_, SIGKILL);
    (void)waitpid(pid_, nullptr, 0);
  }
  void Signal(int number) const { (void)kill(pid_, number); }
  // The exit status, once it has ended.
  [[nodiscard]] std::optional<int> Status() {
    int status = 0;
    if (!status_ && waitpid(pid_, &status, WNOHANG) == pid_) status_ = status;
    return status_;
  }

 private:
  pid_t pid_ = -1;
  std::optional<int> status_;
};

class HgrosControlProcess : public testing::Test {
 protected:
  HgrosControlProcess() {
    publisher.emplace(domain);
    RunUntil({"list", "--json"}, environment, Prints(HasSubstr("greetings")));
  }

  const std::map<std::string, std::string> environment = OwnDomain();
  const std::string domain = environment.at("HGROS_DOMAIN");
  std::optional<ExamplePublisher> publisher;
};

TEST_F(HgrosControlProcess, IsStoppedAsByTheSystem) {
  EXPECT_THAT(RunToEnd(Patiently({"control", "stop", "--session", "pub*"}), environment),
              Prints(0, HasSubstr("gets SIGTERM")));
  ASSERT_TRUE(test::Await([&] { return publisher->Status().has_value(); }));
  EXPECT_TRUE(WIFEXITED(*publisher->Status()));
  EXPECT_EQ(WEXITSTATUS(*publisher->Status()), 0);
}

TEST(HgrosControl, StopsThroughConnectAloneWithAnAllowedKey) {
  const RobotAndDeskWithKeys keys;
  const std::string endpoint = "ipc://" + keys.folder.path() + "/robot.ipc";
  std::string yaml = keys.robot;
  yaml.replace(yaml.find("tcp://127.0.0.1:*"), std::string("tcp://127.0.0.1:*").size(), endpoint);
  ExamplePublisher publisher("none", keys.folder.Write("robot.yaml", yaml));
  EXPECT_THAT(RunToEnd(keys.Command({"control", "stop", "--session", "pub*"}, endpoint), OwnDomain()),
              Prints(0, HasSubstr("gets SIGTERM")));
  ASSERT_TRUE(test::Await([&] { return publisher.Status().has_value(); }));
  EXPECT_TRUE(WIFEXITED(*publisher.Status()));
}

TEST_F(HgrosControlProcess, ThatHangsIsWaitedForUntilTheTimeoutAndDoesNotHoldUpOthers) {
  publisher->Signal(SIGSTOP);
  CommandRun channel({"control", "close", "greetings"}, environment);  // It has announced the channel.
  CommandRun stop({"control", "stop", "--session", "publisher", "--timeout", "3"}, environment);
  EXPECT_THAT(RunToEnd({"control", "log", "error", "--session", "publisher", "--timeout", "0.5"}, environment),
              Ends(3));
  EXPECT_EQ(channel.Wait(), 1) << channel.err();
  EXPECT_THAT(channel.out(), AllOf(HasSubstr("publisher:"), HasSubstr("It does not answer: it hangs")));

  RobotForCommands robot("talker", domain);
  const auto scan = robot.session().Advertise<Log>("greetings");
  // On a busy machine, who does not hang may be late, too.
  robot.RunUntil({"control", "log", "error", "--session", "*"},
                 Prints(1, AllOf(HasSubstr("Log lines below the level error"), HasSubstr("It does not answer"))));
  EXPECT_EQ(stop.Wait(), 3);

  CommandRun run({"control", "log", "error", "--session", "publisher", "--timeout", "3"}, environment);
  test::Linger(std::chrono::milliseconds(300));
  publisher->Signal(SIGKILL);
  EXPECT_THAT(run.Wait(), testing::AnyOf(1, 3));
  EXPECT_THAT(run.out() + run.err(), HasSubstr("ublisher"));
}

TEST_F(HgrosControlProcess, TakesNoOrdersFromAnotherUser) {
  const std::string as_nobody = "setpriv --reuid=65534 --regid=65534 --clear-groups $HGROS ";
  if (RunInShell(as_nobody + "--version").status != 0) GTEST_SKIP() << "The command cannot be run as another user.";
  const std::string runtime = std::getenv("XDG_RUNTIME_DIR") == nullptr ? "" : std::getenv("XDG_RUNTIME_DIR");
  for (const std::string& folder : {std::string("-u XDG_RUNTIME_DIR "), "XDG_RUNTIME_DIR=" + runtime + " "}) {
    EXPECT_THAT(RunInShell("env " + folder + as_nobody + "control stop --session '*'", environment), Ends(1));
  }
  test::Linger(std::chrono::milliseconds(300));
  EXPECT_FALSE(publisher->Status());
}

}  // namespace
}  // namespace hgros::cli
