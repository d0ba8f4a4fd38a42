#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <map>
#include <regex>
#include <string>
#include <vector>

#include "hgros/check/documented_files.hpp"
#include "hgros/command_run.hpp"
#include "hgros/help_examples.hpp"
#include "hgros/proto_folder.hpp"
#include "hgros/transport/curve_key_pair.hpp"

namespace hgros::cli {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class HgrosCheck : public testing::Test {
 protected:
  // A file of the test.
  void Add(const std::string& name, const std::string& yaml) { (void)folder_.Write(name, yaml); }
  // Runs `hgros check` with the arguments; those that end in .yaml are names of Add().
  [[nodiscard]] CommandEnd Run(std::vector<std::string> arguments) const {
    for (std::string& one : arguments) {
      if (one.ends_with(".yaml")) one = prefix_ + std::regex_replace(one, std::regex("\\+"), "+" + prefix_);
    }
    arguments.insert(arguments.begin(), "check");
    CommandEnd end = RunToEnd(arguments);
    for (std::string* text : {&end.out, &end.err}) *text = std::regex_replace(*text, std::regex(prefix_), "");
    return end;
  }
  // Its lines; the status tells whether there are any.
  [[nodiscard]] std::vector<std::string> Findings(std::vector<std::string> arguments) const {
    const CommandEnd end = Run(std::move(arguments));
    EXPECT_EQ(end.err, "");
    EXPECT_EQ(end.status, end.out.empty() ? 0 : 1);
    return LinesOf(end.out);
  }

 private:
  const ProtoFolder folder_{};
  const std::string prefix_ = folder_.path() + "/";
};

TEST_F(HgrosCheck, TellsAllFaultsOfAFileWithTheirPlaces) {
  Add("bad.yaml", "network:\n  publisher: {ip: 'tcp://*', chanels: [a]}\n  heartbeat_ms: 0\nslam: {}\n");
  EXPECT_THAT(Findings({"bad.yaml"}),
              ElementsAre("bad.yaml:2:30: fault: Unknown key \"chanels\" in network.publisher. Did you mean "
                          "\"channels\"? Known keys: channels, ip.",
                          HasSubstr("bad.yaml:2:19: fault: network.publisher.ip is \"tcp://*\", which has no port."),
                          HasSubstr("bad.yaml:3:17: fault: network.heartbeat_ms must be an integer")));
  EXPECT_THAT(Findings({"bad.yaml", "--section", "grip"}), testing::Contains(HasSubstr("bad.yaml:4:1: fault:")));
}

TEST_F(HgrosCheck, RefusesARobotFileWithAMisspelledKey) {
  Add("robot.yaml", "component:\n  camera: {type: demo/Camera}\n");
  EXPECT_THAT(Findings({"robot.yaml"}),
              ElementsAre(HasSubstr("robot.yaml:1:1: fault: Unknown key \"component\" at the top level. Did you mean "
                                    "\"components\"?")));
  EXPECT_THAT(Findings({"robot.yaml", "--section", "component"}), IsEmpty()) << "The section of a program.";
}

TEST_F(HgrosCheck, TellsAFaultOnceThatSeveralFilesInclude) {
  Add("parts.yaml", "components:\n  drive: {type: teleop/Drive, colour: red}\n");
  Add("desk.yaml", "include: parts.yaml\n");
  Add("robot.yaml", "include: parts.yaml\n");
  EXPECT_THAT(Findings({"parts.yaml", "desk.yaml", "robot.yaml"}),
              ElementsAre(HasSubstr("parts.yaml:2:31: fault: Unknown key \"colour\"")));
}

TEST_F(HgrosCheck, TellsWhichListLacksAChannel) {
  Add("robot1.yaml", "network:\n  publisher: {ip: 'tcp://*:5553', channels: [pose, scan]}\n");
  Add("desk.yaml", "network:\n  subscribers:\n    - ip: 'tcp://robot1:5553'\n      channels: [pose]\n");
  EXPECT_THAT(Findings({"robot1.yaml", "desk.yaml"}),
              ElementsAre("desk.yaml:4:17: warning: scan leaves robot1.yaml at tcp://robot1:5553, but desk.yaml does "
                          "not let it enter. Add it at desk.yaml:4."));
  EXPECT_THAT(Findings({"robot1.yaml"}), IsEmpty());
  EXPECT_THAT(Findings({"desk.yaml"}), IsEmpty());

  Add("viewer.yaml", "network: {subscribers: [{ip: 'robot1:5553', channels: [scan]}]}");
  EXPECT_THAT(Findings({"robot1.yaml", "desk.yaml", "viewer.yaml"}), IsEmpty());

  Add("desk.yaml",
      "network: {subscribers: [{ip: 'robot1:5553', channels: [pose]}]}\nchannels: {scan: {queue: latest}}\n");
  EXPECT_THAT(Findings({"robot1.yaml", "desk.yaml", "viewer.yaml"}),
              ElementsAre(HasSubstr("fault: scan leaves robot1.yaml at tcp://robot1:5553, but desk.yaml, which uses "
                                    "it, does not let it enter.")));
}

TEST_F(HgrosCheck, DoesNotTakeAPublisherForASubscriber) {
  Add("robot1.yaml", "network: {publisher: {ip: '*:1', channels: [a, scan]}}");
  Add("viewer.yaml", "network: {subscribers: [{ip: 'robot1:1', channels: [a, scan]}]}");
  Add("desk.yaml",
      "network: {publisher: {ip: '*:2', channels: [scan]}, subscribers: [{ip: 'robot1:1', channels: [a]}]}\n"
      "channels: {scan: {queue: latest}}\n");
  EXPECT_THAT(Findings({"robot1.yaml", "viewer.yaml", "desk.yaml"}), IsEmpty());
  Add("desk.yaml", "network: {subscribers: [{ip: 'robot1:1', channels: [a]}]}\nchannels: {scan: {latched: 1}}\n");
  EXPECT_THAT(Findings({"robot1.yaml", "viewer.yaml", "desk.yaml"}), IsEmpty());
}

TEST_F(HgrosCheck, TellsWhatMayEnterButDoesNotLeave) {
  Add("robot.yaml", "network: {publisher: {ip: 'tcp://*:5553', channels: [pose, scan]}}");
  Add("desk.yaml", "network: {subscribers: [{ip: 'tcp://10.0.0.7:5553', channels: [pose, scna]}]}");
  EXPECT_THAT(Findings({"robot.yaml", "desk.yaml"}),
              ElementsAre("desk.yaml:1:70: fault: scna may enter desk.yaml from tcp://10.0.0.7:5553, but robot.yaml "
                          "does not let it leave there. Did you mean scan?"));
  Add("desk.yaml", "network: {subscribers: [{ip: 'tcp://10.0.0.7:5553', channels: [pose, scan, goal]}]}");
  EXPECT_THAT(Findings({"robot.yaml", "desk.yaml"}),
              ElementsAre(HasSubstr("Add it at robot.yaml:1, or remove it here.")));
}

TEST_F(HgrosCheck, TakesNoKeyWithSpacesForASectionOfTheProgram) {
  for (const char* const yaml : {"network:\r  heartbeat_ms: 5\r", "\u00a0network: {heartbeat_ms: 5}\n",
                                 "\u2003network_of_mine: {}\n", "my section: {}\n"}) {
    Add("robot.yaml", yaml);
    EXPECT_THAT(Findings({"robot.yaml"}), ElementsAre(HasSubstr("fault: Unknown key"))) << yaml;
  }
  Add("robot.yaml", "größe: {}\n");
  EXPECT_THAT(Findings({"robot.yaml"}), IsEmpty());
}

// Names that begin with `prefix`, and one more.
std::string ManyNames(const std::string& prefix, const std::string& last) {
  std::string names;
  for (std::size_t i = 0; i < 2000; ++i) names += prefix + std::to_string(1'000'000 + i) + ", ";
  return names + last;
}

// Comparing all names with all others would take minutes.
TEST_F(HgrosCheck, EndsSoonForLongListsThatHaveNothingInCommonAndTellsAMisspellingOnce) {
  const auto findings = [this](const std::string& leave, const std::string& enter) {
    Add("robot.yaml", "network: {publisher: {ip: 'tcp://*:5553', channels: [" + leave + "]}}");
    Add("desk.yaml", "network: {subscribers: [{ip: 'tcp://10.0.0.7:5553', channels: [" + enter + "]}]}");
    return Findings({"robot.yaml", "desk.yaml"});
  };
  EXPECT_GE(findings(ManyNames(std::string(100, 'a'), "scana"), ManyNames(std::string(100, 'b'), "scanb")).size(),
            4000U);
  const auto tells = [](const std::string& finding) { return finding.find("aaa_sc") != std::string::npos; };
  EXPECT_EQ(std::ranges::count_if(findings(ManyNames("p", "aaa_scan"), ManyNames("s", "aaa_scna")), tells), 1);
}

TEST_F(HgrosCheck, EndsSoonForManyChannelsInFilesThatIncludeEachOther) {
  const auto channels = [](int first) {
    std::string text = "channels:\n";
    for (int i = first; i < first + 20'000; ++i) text += "  number" + std::to_string(i) + ": {latched: 1}\n";
    return text;
  };
  Add("below.yaml", channels(0));
  Add("robot.yaml", "include: below.yaml\n" + channels(10'000));
  EXPECT_THAT(Findings({"robot.yaml"}), IsEmpty());
}

TEST_F(HgrosCheck, TellsHostsApartByTheNamesOfTheirFiles) {
  Add("robot1.yaml", "network: {publisher: {ip: '*:5553', channels: [a]}}");
  Add("robot2.yaml", "network: {publisher: {ip: '*:5553', channels: [b]}}");
  Add("desk.yaml", "network: {subscribers: [{ip: 'robot1:5553', channels: [a]}, {ip: 'robot2:5553', channels: [b]}]}");
  EXPECT_THAT(Findings({"robot1.yaml", "robot2.yaml", "desk.yaml"}), IsEmpty());
  Add("desk.yaml", "network: {subscribers: [{ip: 'robot1:5553', channels: [b]}, {ip: 'robot2:5553', channels: [b]}]}");
  EXPECT_THAT(Findings({"robot1.yaml", "robot2.yaml", "desk.yaml"}),
              ElementsAre(HasSubstr("but robot1.yaml does not let it leave"), HasSubstr("a leaves robot1.yaml")));
}

TEST_F(HgrosCheck, TellsEndpointsThatAreBoundTwiceOnOneHost) {
  Add("a.yaml", "network: {publisher: {ip: 'tcp://*:5601', channels: [a]}}");
  Add("b.yaml", "network: {publisher: {ip: 'tcp://*:5601', channels: [a]}}");
  EXPECT_THAT(Findings({"a.yaml", "b.yaml"}), IsEmpty());  // They can be for two hosts.
  EXPECT_THAT(Run({"-v", "a.yaml", "b.yaml"}).out, HasSubstr("note: a.yaml and b.yaml both bind tcp://*:5601"));
  EXPECT_THAT(Findings({"-v", "a.yaml+b.yaml"}), IsEmpty());
  Add("a.yaml", "network: {publisher: [{ip: 'tcp://10.0.0.1:5601', channels: []}]}");
  Add("b.yaml", "network: {publisher: [{ip: 'tcp://10.0.0.1:5601', channels: []}]}");
  EXPECT_THAT(
      Findings({"a.yaml", "b.yaml"}),
      ElementsAre(HasSubstr("b.yaml:1:28: fault: a.yaml and b.yaml both bind tcp://10.0.0.1:5601 on one host")));
  Add("a.yaml", "network: {publisher: [{ip: 'tcp://*:5601', channels: []}, {ip: 'ipc://@a', channels: []}]}");
  Add("b.yaml", "network: {publisher: {ip: 'tcp://127.0.0.1:5601', channels: []}, subscribers: [{ip: 'ipc://@a'}]}");
  EXPECT_THAT(Findings({"a.yaml", "b.yaml"}),
              ElementsAre(HasSubstr("both bind tcp://127.0.0.1:5601 (one as tcp://*:5601) on one host")));
}

TEST_F(HgrosCheck, TellsEndpointsThatLeadNowhere) {
  Add("robot.yaml", "network: {publisher: {ip: 'tcp://127.0.0.1:5601', channels: [map]}}");
  Add("desk.yaml", "network: {subscribers: [{ip: 'tcp://robot:5601', channels: [map]}]}");
  EXPECT_THAT(Findings({"robot.yaml", "desk.yaml"}),
              ElementsAre(HasSubstr("robot.yaml:1:27: warning: desk.yaml connects to tcp://robot:5601, but robot.yaml "
                                    "offers this port only to its own host, at tcp://127.0.0.1:5601. Write "
                                    "tcp://*:5601.")));
  Add("robot.yaml", "network: {publisher: {ip: 'tcp://*:5602', channels: [map]}}");
  EXPECT_THAT(Findings({"robot.yaml", "desk.yaml"}),
              ElementsAre(HasSubstr("desk.yaml:1:30: warning: desk.yaml connects to tcp://robot:5601 for map")));
  Add("robot.yaml", "network: {publisher: {ip: 'tcp://*:5602', channels: [other]}}");
  EXPECT_THAT(Findings({"robot.yaml", "desk.yaml"}), IsEmpty());
}

TEST_F(HgrosCheck, TellsKeysThatDoNotMatch) {
  const CurveKeyPair robot = GenerateCurveKeyPair();
  const CurveKeyPair desk = GenerateCurveKeyPair();
  const auto keys = [](const CurveKeyPair& own, const std::string& more) {
    return "  security:\n    public_key: '" + own.public_key + "'\n    secret_key: '" + own.secret_key + "'\n" + more;
  };
  const auto robot_file = [&](const CurveKeyPair& own, const std::string& client) {
    Add("robot.yaml", "network:\n  publisher: {ip: 'tcp://*:5601', channels: [a]}\n" +
                          keys(own, "    allowed_clients: ['" + client + "']\n"));
  };
  const auto desk_file = [&](const std::string& server) {
    Add("desk.yaml", "network:\n  subscribers: [{ip: 'robot:5601', channels: [a]}]\n" +
                         keys(desk, "    servers: {'robot:5601': '" + server + "'}\n"));
  };
  robot_file(robot, desk.public_key);
  desk_file(robot.public_key);
  EXPECT_THAT(Findings({"robot.yaml", "desk.yaml"}), IsEmpty());
  desk_file(desk.public_key);
  EXPECT_THAT(Findings({"robot.yaml", "desk.yaml"}),
              ElementsAre(HasSubstr("desk.yaml:6:14: fault: desk.yaml connects to robot.yaml at tcp://robot:5601, but "
                                    "the key under servers is not the public key of robot.yaml.")));
  desk_file(robot.public_key);
  robot_file(robot, robot.public_key);
  EXPECT_THAT(Findings({"robot.yaml", "desk.yaml"}),
              ElementsAre(HasSubstr("robot.yaml:6:22: fault: desk.yaml connects to robot.yaml at tcp://robot:5601, but "
                                    "the public key of desk.yaml is not under allowed_clients. Add it.")));
  robot_file({robot.public_key, desk.secret_key}, desk.public_key);
  EXPECT_THAT(Findings({"robot.yaml", "desk.yaml"}),
              testing::Contains(HasSubstr("robot.yaml:4:17: fault: The public key does not belong to the secret "
                                          "key.")));
  Add("robot.yaml", "network:\n  publisher: {ip: 'tcp://*:5601', channels: [a]}\n");
  EXPECT_THAT(Run({"robot.yaml", "desk.yaml"}).out, AllOf(HasSubstr("but robot.yaml has no keys, and desk.yaml has."),
                                                          testing::Not(HasSubstr(desk.public_key))));
}

TEST_F(HgrosCheck, TellsSettingsThatDoNotFit) {
  Add("robot.yaml",
      "network: {publisher: {ip: 'tcp://*:5601', channels: [a]}, heartbeat_ms: 4000}\n"
      "discovery: {domain: robot_left}\n");
  Add("desk.yaml",
      "network:\n  subscribers: [{ip: 'robot:5601', channels: [a]}]\n  heartbeat_ms: 500\n"
      "  peer_timeout_ms: 2000\ndiscovery: {domain: robot_letf}\n");
  EXPECT_THAT(Findings({"robot.yaml", "desk.yaml"}),
              ElementsAre(HasSubstr("robot.yaml:1:73: fault: robot.yaml sends a heartbeat every 4000 ms, but desk.yaml "
                                    "declares it gone after 2000 ms."),
                          HasSubstr("desk.yaml:5:21: warning: desk.yaml is in the domain robot_letf and robot.yaml in "
                                    "robot_left")));
  Add("desk.yaml",
      "time: simulated\ndiscovery: {local: false}\n"
      "network: {subscribers: [{ip: 'robot:5601', channels: [a]}]}\n");
  EXPECT_THAT(Findings({"desk.yaml"}),
              ElementsAre("desk.yaml:1:7: fault: desk.yaml follows simulated time, but the channel clock can enter "
                          "nowhere. Add clock at desk.yaml:3."));
  Add("robot.yaml",
      "network: {publisher: {ip: 'tcp://*:5601', channels: [a]}}\n"
      "channels: {a: {transports: shared_memory}}\n");
  EXPECT_THAT(Findings({"robot.yaml"}),
              ElementsAre(HasSubstr("robot.yaml:1:54: fault: a is listed at tcp://*:5601, but channels.a.transports "
                                    "does not allow zmq.")));
}

TEST_F(HgrosCheck, TellsServicesThatPassInOneDirection) {
  Add("robot.yaml",
      "network:\n  publisher: {ip: 'tcp://*:5601', channels: [hgros/call/stop]}\n"
      "  subscribers: [{ip: 'desk:5610', channels: [goal]}]\n");
  Add("desk.yaml",
      "network:\n  publisher: {ip: 'tcp://*:5610', channels: [goal, hgros/call/stop]}\n"
      "  subscribers: [{ip: 'robot:5601', channels: [hgros/call/stop]}]\n");
  EXPECT_THAT(Findings({"robot.yaml", "desk.yaml"}),
              ElementsAre(HasSubstr(
                  "robot.yaml:2:46: warning: hgros/call/stop leaves robot.yaml, but cannot enter it: a service ")));
}

TEST_F(HgrosCheck, TellsParametersThatCannotBeAskedFor) {
  Add("robot.yaml", "network:\n  publisher: {ip: 'tcp://*:5601', channels: [params/slam/answer, params/slam/state]}\n");
  Add("desk.yaml",
      "network:\n  publisher: {ip: 'tcp://*:5610', channels: [params/slam/ask]}\n"
      "  subscribers: [{ip: 'robot:5601', channels: [params/slam/answer, params/slam/state]}]\n");
  EXPECT_THAT(Findings({"robot.yaml", "desk.yaml"}),
              ElementsAre(HasSubstr("params/slam/answer leaves robot.yaml, but params/slam/ask cannot enter it")));
}

TEST_F(HgrosCheck, TellsSettingsOfAMisspelledChannel) {
  Add("robot.yaml", "network: {publisher: {ip: 'tcp://*:5601', channels: [scan]}}\nchannels:\n  /scan: {latched: 1}\n");
  EXPECT_THAT(
      Findings({"robot.yaml"}),
      ElementsAre("robot.yaml:3:10: warning: No list of channels has /scan, but one has scan. Did you mean scan?"));
}

TEST_F(HgrosCheck, IgnoresWhatACommentIgnores) {
  Add("desk.yaml", "network: {subscribers: [{ip: 'robot:5553', channels: [a]}]}\n");
  const auto robot = [&](const std::string& above, const std::string& behind) {
    Add("robot.yaml", "network:\n" + above + "  publisher: {ip: 'tcp://*:5553', channels: [a, b]}" + behind + "\n");
    return Findings({"robot.yaml", "desk.yaml"}).size();
  };
  EXPECT_EQ(robot("", ""), 1U);
  EXPECT_EQ(robot("", "  # hgros check: ignore b"), 0U);
  EXPECT_EQ(robot("", "  # hgros check: ignore"), 0U);
  EXPECT_EQ(robot("", "  # hgros check: ignore a, bb"), 1U);
  EXPECT_EQ(robot("  # For the viewer. hgros check: ignore a, b\n", ""), 0U);
  EXPECT_EQ(robot("  heartbeat_ms: 900  # hgros check: ignore\n", ""), 1U);
}

// Each group of files that belong together is right.
TEST_F(HgrosCheck, IsSilentAboutDocumentedFiles) {
  for (const char* page : {"docs/how-to.md", "docs/deployment.md", "docs/configuration.md"}) {
    std::vector<std::string> names;
    std::map<std::string, int> count;
    const auto files = FilesOfPage(page);
    for (const DocumentedFile& file : files) {
      const std::string name = file.name.empty() ? "file.yaml" : file.name;
      names.push_back(count[name]++ == 0 ? name : std::to_string(count[name]) + name);
      Add(names.back(), file.yaml);
    }
    TwoAtATime(names.size(), [&](std::size_t i) { EXPECT_THAT(Findings({names[i]}), IsEmpty()) << files[i].where; });
    if (page == std::string("docs/how-to.md")) {
      EXPECT_THAT(Findings({"cart.yaml", "desk.yaml"}), IsEmpty());
    }
    if (page != std::string("docs/deployment.md")) continue;
    EXPECT_THAT(names, ElementsAre("common.yaml", "lidar.yaml", "slam.yaml", "planner.yaml", "robot1.yaml",
                                   "monitor.yaml", "2lidar.yaml", "2robot1.yaml"));
    EXPECT_THAT(Findings({"common.yaml+lidar.yaml", "common.yaml+slam.yaml", "common.yaml+planner.yaml", "robot1.yaml",
                          "robot1.yaml+monitor.yaml"}),
                IsEmpty());
    EXPECT_THAT(Findings({"lidar.yaml+2lidar.yaml", "robot1.yaml+2robot1.yaml"}), IsEmpty());
  }
  std::vector<std::string> examples{"check"};
  for (const DocumentedFile& file : DocumentedFiles()) {
    if (file.where.starts_with("/")) examples.push_back(file.where);
  }
  examples.push_back((RepositoryFolder() / "examples/slam2d/config/viewer.yaml").string());
  EXPECT_GE(examples.size(), 4U);
  EXPECT_THAT(RunToEnd(examples), Writes(""));
}

TEST_F(HgrosCheck, WritesJson) {
  Add("robot.yaml", "time: simulation\n");
  EXPECT_THAT(Findings({"--json", "robot.yaml"}),
              ElementsAre("{\"severity\":\"fault\",\"check\":\"file\",\"file\":\"robot.yaml\",\"line\":1,\"column\":7,"
                          "\"what\":\"time must be one of system, simulated, but is the text \\\"simulation\\\".\","
                          "\"fix\":\"Did you mean \\\"simulated\\\"?\"}"));
}

TEST_F(HgrosCheck, DrawsWhatPasses) {
  Add("robot.yaml", "network: {publisher: {ip: 'tcp://*:5553', channels: [pose, scan]}}");
  Add("desk.yaml", "network: {subscribers: [{ip: 'tcp://robot:5553', channels: [pose, odom]}]}");
  EXPECT_THAT(Run({"--svg", "robot.yaml", "desk.yaml"}),
              Prints(0, AllOf(HasSubstr("<svg "), HasSubstr(">robot.yaml  on robot<"), HasSubstr(">desk.yaml<"),
                              HasSubstr("<title>pose over ZeroMQ</title>"), HasSubstr(">scan<"), HasSubstr(">odom<"),
                              testing::Not(HasSubstr("scan over")))));
  Add("desk.yaml", "network: 5");
  EXPECT_EQ(Run({"--svg", "robot.yaml", "desk.yaml"}).status, 1);
}

TEST_F(HgrosCheck, PrintsTheSchema) {
  EXPECT_THAT(RunToEnd({"check", "--schema"}),
              Writes(HasSubstr("\"$schema\": \"http://json-schema.org/draft-07/schema#\"")));
  EXPECT_THAT(RunToEnd({"check", "--schema", "--section", "gripper"}).out, HasSubstr("\"gripper\": {"));
}

TEST_F(HgrosCheck, RefusesWrongUseAndWhatCanBeReadOnlyOnce) {
  EXPECT_EQ(RunToEnd({"check"}).status, 2);
  EXPECT_EQ(RunToEnd({"check", "--schema", "--json"}).status, 2);
  EXPECT_THAT(RunToEnd({"check", "/no/such.yaml"}), Ends(2, "hgros: There is no file \"/no/such.yaml\".\n"));
  const ProtoFolder folder{};
  const std::string pipe = folder.path() + "/pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  for (const std::string& file : {pipe, std::string("/dev/null")}) {
    EXPECT_THAT(RunToEnd({"check", file}), Ends(2, "hgros: \"" + file +
                                                       "\" is a pipe or a device. Save its text as a file and name "
                                                       "that.\n"));
  }
}

TEST_F(HgrosCheck, ItsExamplesWork) {
  for (const char* name : {"cart.yaml", "desk.yaml", "common.yaml", "lidar.yaml"}) Add(name, "");
  for (std::vector<std::string> words : ExamplesOf("check")) {
    if (std::ranges::find(words, "-o") != words.end()) words.resize(words.size() - 2);  // Leaves no file behind.
    words.erase(words.begin());
    EXPECT_EQ(Run(words).status, 0) << testing::PrintToString(words);
  }
}

}  // namespace
}  // namespace hgros::cli
