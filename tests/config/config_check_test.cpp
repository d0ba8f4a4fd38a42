#include <gmock/gmock.h>

#include "config/config_fixture.hpp"
#include "config/fixture_file.hpp"
#include "hgros/config/check.hpp"
#include "hgros/yaml/document.hpp"

namespace hgros {
namespace {

using test::ScratchFolder;
using testing::ElementsAre;
using testing::HasSubstr;

// "LINE:COLUMN: what" of each fault of one file.
std::vector<std::string> FaultsOf(std::string_view yaml, const ConfigCheckOptions& options = {}) {
  const ScratchFolder folder;
  const std::filesystem::path file = folder.Write("robot.yaml", yaml);
  std::vector<std::string> faults;
  for (const ConfigError& fault : CheckConfig(std::span(&file, 1), options).faults) {
    faults.push_back(std::string(fault.what()).substr(file.string().size() + 1));
  }
  return faults;
}

TEST(ConfigCheck, TellsAllFaultsOfAFile) {
  EXPECT_THAT(
      FaultsOf("netwrok: {}\n"
               "network:\n"
               "  publisher: {ip: 'tcp://*', chanels: [a], channels: [a, a, 'b c']}\n"
               "  subscribers: [{ip: 'tcp://*:1'}, {channels: [d]}, x]\n"
               "  heartbeat_ms: 0\n"
               "channels: {a: {queue: 3, latched: many}, b: {transport: zmq}}\n"
               "data_graph: {threads: '2', nodes: {n: {executor: tbbb}}}\n"),
      ElementsAre(HasSubstr("1:1: Unknown key \"netwrok\""), HasSubstr("3:30: Unknown key \"chanels\""),
                  HasSubstr("3:19: network.publisher.ip is"), HasSubstr("3:58: network.publisher.channels[1]"),
                  HasSubstr("3:61: The channel name"), HasSubstr("4:22: network.subscribers[0].ip"),
                  HasSubstr("4:36: network.subscribers[1] has no \"ip\""),
                  HasSubstr("4:53: network.subscribers[2] must be a map"),
                  HasSubstr("5:17: network.heartbeat_ms must be"), HasSubstr("7:23: data_graph.threads must be"),
                  HasSubstr("7:50: data_graph.nodes.n.executor must be"), HasSubstr("6:23: channels.a.queue"),
                  HasSubstr("6:35: channels.a.latched"), HasSubstr("6:46: Unknown key \"transport\"")));
}

TEST(ConfigCheck, TellsAllContradictions) {
  EXPECT_THAT(FaultsOf("network: {heartbeat_ms: 9000}\nshared_memory: {spin_us: 5}\n"),
              ElementsAre(HasSubstr("2:26: shared_memory.spin_us applies only"),
                          HasSubstr("1:25: network.peer_timeout_ms is 5000")));
  const std::string key = "'rq:rM>}U?@Lns47E1%kR.o@n%FcmmsL/@{H8]yf7'";
  EXPECT_THAT(FaultsOf("network: {subscribers: [{ip: 'a:1'}, {ip: 'b:1'}], security: {secret_key: " + key + "}}"),
              ElementsAre(HasSubstr("no public key"), HasSubstr("no key for \"tcp://a:1\""),
                          HasSubstr("no key for \"tcp://b:1\"")));
}

TEST(ConfigCheck, TellsAKeyThatCannotBeReadOnce) {
  const std::string yaml =
      "network: {security: {public_key: 'rq:rM>}U?@Lns47E1%kR.o@n%FcmmsL/@{H8]yf7', secret_key_file: missing.key}}";
  EXPECT_THAT(FaultsOf(yaml), ElementsAre(HasSubstr("missing.key\", which cannot be read")));
  EXPECT_THAT(FaultsOf(yaml, {.read_key_files = false}), ElementsAre());
  EXPECT_THAT(
      FaultsOf("network: {security: {public_key: short, secret_key_file: missing.key}}", {.read_key_files = false}),
      ElementsAre(HasSubstr("has 5 characters")));
  EXPECT_THAT(FaultsOf("network: {subscribers: [{ip: 'a:1'}], security: {secret_key_file: k, servers: {'a:1': short}, "
                       "public_key: 'rq:rM>}U?@Lns47E1%kR.o@n%FcmmsL/@{H8]yf7'}}",
                       {.read_key_files = false}),
              ElementsAre(HasSubstr("has 5 characters")));
}

TEST(ConfigCheck, GoesOnAfterAFileThatCannotBeRead) {
  const ScratchFolder folder;
  const std::vector<std::filesystem::path> files = {folder.path() / "missing.yaml", folder.Write("broken.yaml", "a: ["),
                                                    folder.Write("robot.yaml", "time: simulated\ndomain: a\n")};
  const CheckedConfig checked = CheckConfig(files);
  ASSERT_EQ(checked.faults.size(), 3U);
  EXPECT_EQ(checked.faults[0].where(), files[0].string());
  EXPECT_THAT(checked.faults[1].where(), HasSubstr("broken.yaml:1:"));
  EXPECT_THAT(checked.faults[2].where(), HasSubstr("robot.yaml:2:1"));
  EXPECT_TRUE(checked.config.simulated_time);
}

TEST(YamlDocument, KeepsItsNodesWhenAVectorGrows) {
  std::vector<yaml::Document> documents;
  for (int i = 0; i < 20; ++i) {
    documents.push_back(yaml::Document::Parse("key: value" + std::to_string(i), "robot.yaml"));
  }
  for (int i = 0; i < 20; ++i) {
    const auto& root = documents[static_cast<std::size_t>(i)].root();
    ASSERT_EQ(root.entries.size(), 1U);
    EXPECT_EQ(root.entries[0].value->text, "value" + std::to_string(i));
  }
}

TEST(ConfigCheck, AcceptsWhatLoadAccepts) {
  const std::filesystem::path file = test::FixtureFile("everything.yaml");
  const CheckedConfig checked = CheckConfig(std::span(&file, 1));
  EXPECT_TRUE(checked.faults.empty());
  EXPECT_EQ(checked.config.channels, Config::Load(file).channels);
}

}  // namespace
}  // namespace hgros
