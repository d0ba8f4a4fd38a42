#include <gmock/gmock.h>
#include <sys/stat.h>

#include "config/config_fixture.hpp"
#include "hgros/config/check.hpp"
#include "hgros/yaml/document.hpp"
#include "support/error_of.hpp"

namespace hgros {
namespace {

using test::ExpectConfigError;
using test::ExpectFault;
using test::ScratchFolder;
using testing::ElementsAre;
using testing::HasSubstr;

// https://rfc.zeromq.org/spec/26/ has pairs such as this one.
constexpr const char* kKey = "Yne@$w-vo<fVvi]a<NY6T1ed:M$fCG*[IaLV{hID";
constexpr const char* kSecret = "D:)Q[IlAW!ahhC2ac:9*A}h:p?([4%wOTJ%JR%cs";

void ExpectPublisherFault(const std::string& ip, const std::vector<std::string>& parts) {
  ExpectFault("network:\n  publisher:\n    ip: '" + ip + "'\n", "3:9", parts);
}

void ExpectSubscriberFault(const std::string& ip, const std::vector<std::string>& parts) {
  ExpectFault("network:\n  subscribers:\n    - ip: '" + ip + "'\n", "3:11", parts);
}

TEST(ConfigKeys, UnknownKeyErrorNamesTheNearestAndAllKnownKeys) {
  ExpectFault("netwrok:\n", "1:1",
              {"Unknown key \"netwrok\" at the top level.", "Did you mean \"network\"?",
               "Known keys: channels, control, data_graph, discovery, network, shared_memory, time."});
  ExpectFault("network:\n  publishers:\n", "2:3", {"Unknown key \"publishers\" in network.", "\"publisher\"?"});
  ExpectFault(
      "network:\n  publisher: {ip: x, chanels: []}\n", "2:22",
      {"Unknown key \"chanels\" in network.publisher.", "Did you mean \"channels\"?", "Known keys: channels, ip."});
  ExpectFault("network: {subscribers: [{ip: x}, {ipp: x}]}", "1:35", {"in network.subscribers[1]."});
  ExpectFault("data_graph: {thread: 1}", "1:14", {"\"threads\"?", "Known keys: close_channels, nodes, threads."});
  ExpectFault("data_graph: {nodes: {slam: {queu: latest}}}", "1:29", {"in data_graph.nodes.slam.", "\"queue\"?"});
  ExpectFault("channels: {scan: {latch: 1}}", "1:19", {"in channels.scan.", "\"latched\"?"});
  ExpectFault("network: {security: {secret: a}}", "1:22", {"Known keys: allowed_clients, public_key, secret_key,"});
  ExpectFault("params: {}", "1:1", {"Unknown key \"params\""});
  ExpectFault("domain: 3", "1:1", {"Unknown key \"domain\""});
}

TEST(ConfigHost, ErrorsInDiscoveryAndSharedMemoryNameTheProblem) {
  ExpectFault("discovery: {domain: a/b}", "1:21", {"discovery.domain is \"a/b\", which cannot name a domain"});
  ExpectFault("discovery: {local: maybe}", "1:20", {"discovery.local"});
  ExpectFault("discovery: {lokal: true}", "1:13", {"Did you mean \"local\"?"});
  ExpectFault("discovery: {local: []}", "1:20", {"discovery.local lists no process", "Write false"});
  ExpectFault("discovery: {local: [a, a]}", "1:24", {"local[1] is \"a\"", "robot.yaml:1:21"});
  ExpectFault("discovery: {local: {}}", "1:20", {"must be true, false or a list of process names, but is a map."});
  ExpectFault("discovery: {lan: maybe}", "1:18", {"discovery.lan must be true or false"});
  ExpectFault("discovery: {lan: {interface: [eth0]}}", "1:19", {"Did you mean \"interfaces\"?"});
  ExpectFault("discovery: {lan: {interfaces: []}}", "1:18", {"lists no interface"});
  ExpectFault("discovery: {lan: {interfaces: [a-name-of-16-byt]}}", "1:32", {"cannot be a network interface name"});
  ExpectFault(std::string("discovery: {lan: true}\nnetwork: {security: {public_key: '") + kKey + "', secret_key: '" +
                  kSecret + "'}}",
              "1:18", {"encrypted, as network.security at robot.yaml:2:", "a beacon does not carry keys"});
  ExpectFault("shared_memory: {wait: nap}", "1:23", {"shared_memory.wait", "sleep"});
  ExpectFault("shared_memory: {limit_bytes: -1}", "1:30", {"shared_memory.limit_bytes"});
  ExpectFault("shared_memory: {spin_us: 20}", "1:26",
              {"applies only with wait: spin, but shared_memory.wait is not set.", "Write wait: spin"});
  ExpectFault("shared_memory: {wait: busy, spin_us: 20}", "1:38",
              {"shared_memory.wait at robot.yaml:1:23 has another value"});
}

TEST(ConfigKeys, KeyBelowListDashesGetsAnIndentationHint) {
  ExpectFault("network:\n  subscribers:\n  - ip: x\n  channels: [a]\n", "4:3",
              {"Unknown key \"channels\" in network.", "indent it as far as the text after the dash"});
}

TEST(ConfigKeys, ErrorsNameBothPositionsOfARepeatedKeyAndAMissingKey) {
  ExpectFault("network:\n  publisher: {ip: x}\nnetwork: {}\n", "3:1", {"\"network\" appears twice", "robot.yaml:1:1"});
  ExpectFault("data_graph: {threads: 1, threads: 1}", "1:26", {"\"threads\" appears twice", "robot.yaml:1:14"});
  ExpectFault("channels: {a: {}, 'a': {}}", "1:19", {"\"a\" appears twice"});
  ExpectFault("network:\n  publisher:\n    channels: []\n", "3:5", {"network.publisher has no \"ip\"."});
  ExpectFault("data_graph: {nodes: {a: {executor: {cpus: [1]}}}}", "1:36", {"executor has no \"kind\"."});
  ExpectFault("channels: {a: {queue: {keep_all: {bytes: 1}}}}", "1:34", {"keep_all has no \"messages\"."});
}

TEST(ConfigTypes, ErrorNamesTheWantedAndTheActualType) {
  ExpectFault("network:\n  publisher:\n    ip: x\n    channels: scan\n", "4:15",
              {"network.publisher.channels must be a list of names, but is the text \"scan\"."});
  ExpectFault("network: {publisher: {ip: x, channels: }}", "1:40", {"must be a list of names, but is empty."});
  ExpectFault("network: {publisher: {ip: [x]}}", "1:27", {"must be an endpoint as a text, but is a list."});
  ExpectFault("network: 5", "1:10", {"network must be a map, but is the number 5."});
  ExpectFault("network: {subscribers: {ip: x}}", "1:24", {"must be a list of endpoints", "but is a map."});
  ExpectFault("network: {subscribers: [x]}", "1:25", {"network.subscribers[0] must be a map with ip and channels"});
  ExpectFault("data_graph: {threads: many}", "1:23", {"must be an integer from 0 to 1024, but is the text \"many\"."});
  ExpectFault("data_graph: {threads: true}", "1:23", {"but is true."});
  ExpectFault("data_graph: {threads: '2'}", "1:23", {"but is the text \"2\" in quotes.", "without quotes"});
  ExpectFault("data_graph: {threads: 010}", "1:23", {"leading zeros"});
  ExpectFault("data_graph: {threads: 1.5}", "1:23", {"but is the number 1.5."});
  ExpectFault("data_graph: {close_channels: [[a]]}", "1:31",
              {"close_channels[0] must be a channel name, but is a list."});
  ExpectFault("control: offf", "1:10", {"off"});
  ExpectFault("channels: {a: {lossless: yes}}", "1:26", {"must be true or false, but is the text \"yes\"."});
  ExpectFault("- network", "1:1",
              {"The file must be a map with network, discovery, shared_memory, time, control, data_graph and channels, "
               "but is a list."});
  ExpectFault("network:x", "1:1", {"The file must be a map", "Put a space after the colon"});
}

TEST(ConfigTypes, IntegersAndSizesHaveBounds) {
  ExpectFault("data_graph: {threads: 1025}", "1:23", {"from 0 to 1024, but is the number 1025."});
  ExpectFault("data_graph: {threads: -1}", "1:23", {"but is the number -1."});
  ExpectFault("data_graph: {threads: 99999999999999999999999}", "1:23", {"from 0 to 1024"});
  ExpectFault("data_graph: {threads: -9223372036854775808}", "1:23", {"from 0 to 1024"});
  ExpectFault("network: {heartbeat_ms: 0}", "1:25", {"from 1 to 3600000"});
  ExpectFault("network: {peer_queue_bytes: 0}", "1:29", {"a size from 1 to"});
  ExpectFault("network: {peer_queue_bytes: 64Mb}", "1:29",
              {"but is the text \"64Mb\".", "KiB, MiB, GiB, kB, MB or GB"});
  ExpectFault("network: {peer_queue_bytes: 1.5GiB}", "1:29", {"KiB, MiB, GiB, kB, MB or GB"});
  ExpectFault("network: {peer_queue_bytes: 18446744073709551615GiB}", "1:29", {"a size from 1 to"});
  ExpectFault("channels: {a: {queue: {keep_last: 0}}}", "1:35", {"from 1 to 1000000"});
  ExpectFault("network: {heartbeat_ms: 5000}", "1:25", {"peer_timeout_ms is 5000", "heartbeat_ms, which is 5000"});
  ExpectFault("network: {heartbeat_ms: 50, peer_timeout_ms: 20}", "1:46", {"every peer would be declared gone"});
}

TEST(ConfigEndpointFaults, ErrorNamesTheProblemAndTheFix) {
  ExpectPublisherFault("", {"network.publisher.ip is empty.", "\"tcp://*:5553\", or \"x\" to switch it off."});
  ExpectPublisherFault("tcp://*", {"which has no port"});
  ExpectPublisherFault("off", {"which has no port", "\"x\" to switch it off"});
  ExpectPublisherFault("tcp://*:", {"which has no port"});
  ExpectPublisherFault("tcp://:5553", {"which has no host"});
  ExpectPublisherFault("tcp://*:65536", {"whose port \"65536\" is not valid", "from 1 to 65535"});
  ExpectPublisherFault("tcp://*:5553/", {"whose port \"5553/\" is not valid"});
  ExpectPublisherFault("tcp://*:-1", {"whose port \"-1\" is not valid"});
  ExpectPublisherFault("tcpp://*:5553", {"no scheme \"tcpp\"", "Did you mean \"tcp\"? Known schemes: ipc, tcp."});
  ExpectPublisherFault("websocket://*:5553", {"no scheme \"websocket\". Known schemes: ipc, tcp."});
  ExpectPublisherFault("tcp://1.2.3.400:5553", {"\"1.2.3.400\" is not an IPv4 address"});
  ExpectPublisherFault("tcp://::1:5553", {"more than one colon", "\"tcp://[::1]:5553\""});
  ExpectPublisherFault("tcp://[::1:5553", {"bracket is not closed"});
  ExpectPublisherFault("tcp://[::1]5553", {"which has no port"});
  ExpectPublisherFault("tcp://[::1]x:5553", {"no port follows the bracket"});
  ExpectPublisherFault("tcp://[::g]:5553", {"\"::g\" is not an IPv6 address"});
  ExpectPublisherFault("tcp:/*:5553", {"more than one colon"});
  ExpectPublisherFault("tcp//*:5553", {"\"tcp//*\" is not a host name"});
  ExpectPublisherFault("tcp://* :5553", {"a space or control character"});
  ExpectPublisherFault("ipc://bus", {"is not an absolute path of a file", "\"ipc:///run/robot/bus\""});
  ExpectPublisherFault("ipc:///run/", {"is not an absolute path of a file"});
  ExpectPublisherFault("ipc://@", {"is not an absolute path of a file"});
  ExpectPublisherFault("ipc:///" + std::string(107, 'a'), {"whose path has 108 bytes", "107 bytes at most"});
}

TEST(ConfigEndpointFaults, SubscriberNeedsOneHostAndOnePort) {
  ExpectSubscriberFault("tcp://*:5553", {"cannot connect to every address", "Name the publisher's host"});
  ExpectSubscriberFault("0.0.0.0:5553", {"cannot connect to every address"});
  ExpectSubscriberFault("tcp://[::]:5553", {"cannot connect to every address"});
  ExpectSubscriberFault("tcp://robot2:0", {"whose port is a wildcard"});
  ExpectSubscriberFault("tcp://robot2:*", {"whose port is a wildcard"});
}

TEST(ConfigEndpointFaults, RepeatedOnesNameBothPositions) {
  ExpectFault("network:\n  publisher:\n    - ip: '*:5553'\n    - ip: '127.0.0.1:5553'\n", "4:11",
              {"network.publisher[1].ip is \"tcp://127.0.0.1:5553\"",
               "port 5553 belongs to \"tcp://*:5553\" at robot.yaml:3:11"});
  ExpectFault("network:\n  subscribers:\n    - ip: 'h:5553'\n    - ip: 'tcp://H:05553'\n", "4:11",
              {"\"tcp://h:5553\" appears twice", "robot.yaml:3:11"});
}

TEST(ConfigChannelNames, ErrorHasThePositionOfTheName) {
  ExpectFault("data_graph: {close_channels: [a, 'b c']}", "1:34", {"\"b c\" cannot be used", "byte 2 is a space"});
  ExpectFault("data_graph: {close_channels: ['']}", "1:31", {"it is empty"});
  ExpectFault("channels: {'a b': {}}", "1:12", {"\"a b\" cannot be used"});
  ExpectFault("data_graph: {close_channels: [a, b, a]}", "1:37", {"close_channels[2] is \"a\"", "robot.yaml:1:31"});
  ExpectFault("network: {publisher: {ip: x, channels: [a, a]}}", "1:44", {"channels[1] is \"a\""});
  ExpectFault("data_graph: {nodes: {'': {}}}", "1:22", {"name of the node is empty"});
}

TEST(ConfigForms, InvalidOnesOfQueuesTransportsAndExecutorsAreRefused) {
  ExpectFault("channels: {a: {queue: latst}}", "1:23",
              {"must be a queue, but is the text \"latst\".", "Did you mean \"latest\"?"});
  ExpectFault("channels: {a: {queue: 16}}", "1:23", {"but is the number 16.", "{keep_last: 16}"});
  ExpectFault("channels: {a: {queue: {}}}", "1:23", {"must have either keep_last or keep_all"});
  ExpectFault("channels: {a: {queue: {keep_last: 1, keep_all: 1}}}", "1:23",
              {"must have either keep_last or keep_all"});
  ExpectFault("channels: {a: {queue: {keeplast: 1}}}", "1:24", {"Did you mean \"keep_last\"?"});
  ExpectFault("channels: {a: {queue: latest, lossless: true}}", "1:41", {"contradicts the queue at robot.yaml:1:23"});
  ExpectFault("channels: {a: {queue: {keep_all: 5}, lossless: false}}", "1:48", {"contradicts the queue"});

  ExpectFault("channels: {a: {transports: shared_memry}}", "1:28",
              {"must be one of shared_memory, zmq", "Did you mean \"shared_memory\"?"});
  ExpectFault("channels: {a: {transports: [zmq, tcp]}}", "1:34", {"must be one of shared_memory, zmq"});
  ExpectFault("channels: {a: {transports: [zmq, zmq]}}", "1:34", {"which the list already has"});
  ExpectFault("channels: {a: {transports: []}}", "1:28", {"lists no transport", "ToGraph"});
  ExpectFault("channels: {a: {transport: zmq}}", "1:16", {"Did you mean \"transports\"?"});
  ExpectFault("channels: {a: {carriers: zmq}}", "1:16", {"`carriers` is called `transports` now"});

  const auto expect = [](const std::string& form, const std::string& at, const std::vector<std::string>& parts) {
    ExpectFault("data_graph: {nodes: {a: {executor: " + form + "}}}", at, parts);
  };
  expect("inlined", "1:36",
         {"must be one of tbb, inline, dedicated, but is the text \"inlined\".", "Did you mean \"inline\"?"});
  expect("[tbb]", "1:36", {"must be tbb, inline, dedicated or a map with kind, but is a list."});
  expect("{kind: inline, cpus: [1]}", "1:57", {"applies only to a dedicated executor"});
  expect("{kind: tbb, priority: 1}", "1:58", {"applies only to a dedicated executor"});
  expect("{kind: dedicated, cpus: [1024]}", "1:61", {"from 0 to 1023"});
  expect("{kind: dedicated, cpus: [1, 1]}", "1:64", {"robot.yaml:1:61"});
  expect("{kind: dedicated, priority: 100}", "1:64", {"from 0 to 99"});
}

TEST(ConfigSecurity, InvalidKeysAreRefusedAndNeverShown) {
  const std::string shorter(39, 'k');
  ExpectFault("network: {security: {public_key: " + shorter + "}}", "1:34", {"has 39 characters, but a key has 40"});
  const std::string strange = std::string(20, 's') + "~" + std::string(19, 's');
  const std::string what =
      test::ErrorOf([&] { (void)Config::Parse("network: {security: {secret_key: '" + strange + "'}}"); });
  EXPECT_NE(what.find("character 21 is not in the Z85 alphabet"), std::string::npos) << what;
  EXPECT_EQ(what.find("ssss"), std::string::npos) << what;
  const std::string of_file =
      test::ErrorOf([] { (void)Config::Parse(std::string("network: {security: {secret_key_file: '") + kKey + "'}}"); });
  EXPECT_NE(of_file, "");
  EXPECT_EQ(of_file.find("Yne@$"), std::string::npos) << of_file;
}

TEST(ConfigSecurity, IncompleteSettingsAreRefused) {
  const std::string key = std::string("'") + kKey + "'";
  ExpectFault("network: {security: {public_key: " + key + "}}", "1:34", {"no secret key", "secret_key_file"});
  ExpectFault("network: {security: {allowed_clients: [" + key + "]}}", "1:40", {"no secret key"});
  ExpectFault("network: {security: {servers: {'h:1': " + key + "}}}", "1:39", {"no secret key"});
  ExpectFault("network: {security: {secret_key: " + key + "}}", "1:34", {"no public key"});
  ExpectFault(std::string("network:\n  subscribers: [{ip: 'robot2:1'}]\n  security:\n    secret_key: '") + kSecret +
                  "'\n    public_key: " + key + "\n    servers: {'robot3:1': " + key + "}\n",
              "2:22", {"no key for \"tcp://robot2:1\"", "nearest endpoint there is \"tcp://robot3:1\""});
  ExpectFault("network:\n  security:\n    secret_key: " + key + "\n    secret_key_file: k\n", "4:22",
              {"stands beside secret_key at robot.yaml:3:17"});
  ExpectFault("network: {security: {servers: {'h:1': " + key + ", 'tcp://H:1': " + key + "}}}", "1:96",
              {"already has a key at robot.yaml:1:32"});
  const std::string other = "'rq:rM>}U?@Lns47E1%kR.o@n%FcmmsL/@{H8]yf7'";
  ExpectFault("network: {security: {public_key: " + other + ", secret_key: '" + kSecret + "'}}", "1:34",
              {"does not belong to the secret key", std::string("The public key of that secret key is ") + kKey});
}

TEST(ConfigSecurity, KeyFilePathIsRelativeToTheConfigurationAndMustBePrivate) {
  const ScratchFolder folder;
  const auto key_file = folder.Write("secret", std::string(kSecret) + "\n");
  const auto file = folder.Write(
      "robot.yaml", std::string("network: {security: {secret_key_file: secret, public_key: '") + kKey + "'}}");
  const auto load = [&] { return Config::Load(file); };
  const std::string where = file.string() + ":1:39";

  ASSERT_EQ(chmod(key_file.c_str(), 0640), 0);
  ExpectConfigError(load, where, {"others than the owner may read", "chmod 600 " + key_file.string()});
  ASSERT_EQ(chmod(key_file.c_str(), 0600), 0);
  EXPECT_EQ(load().security.secret_key, kSecret);

  folder.Write("secret", "short\n");
  ExpectConfigError(load, where, {"names a file that has 5 characters"});
  folder.Write("secret", std::string(kKey) + kKey);
  ExpectConfigError(load, where, {"more than one key"});
  std::filesystem::remove(key_file);
  ExpectConfigError(load, where, {"cannot be read: No such file or directory"});
  ASSERT_EQ(mkfifo(key_file.c_str(), 0600), 0);
  ExpectConfigError(load, where, {"which is not a regular file"});
}

TEST(ConfigFiles, ErrorNamesTheFileThatCannotBeRead) {
  const ScratchFolder folder;
  const auto missing = folder.path() / "missing.yaml";
  ExpectConfigError([&] { return Config::Load(missing); }, missing.string(),
                    {"cannot be read: No such file or directory"});
  ExpectConfigError([&] { return Config::Load(folder.path()); }, folder.path().string(), {"a folder"});
  ExpectConfigError([&] { return Config::Load(std::filesystem::path()); }, "",
                    {"name of a configuration file is empty"});
  const auto huge = folder.Write("huge.yaml", std::string(1024 * 1024 + 1, '#'));
  ExpectConfigError([&] { return Config::Load(huge); }, huge.string(), {"more than 1 MiB"});
}

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
