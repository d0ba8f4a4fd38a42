#include "hgros/config/config.hpp"

#include <cstdlib>

#include "config/config_fixture.hpp"

namespace hgros {
namespace {

using test::ExpectConfigError;
using test::ExpectFault;
using test::FixtureFile;
using test::ScratchFolder;
using Names = std::vector<std::string>;

std::string PublisherOf(const std::string& ip) {
  const Config config = Config::Parse("network: {publisher: {ip: '" + ip + "', channels: []}}");
  return config.publishers.empty() ? "off" : config.publishers.at(0).endpoint;
}

std::string SubscriberOf(const std::string& ip) {
  const Config config = Config::Parse("network: {subscribers: [{ip: '" + ip + "', channels: []}]}");
  return config.subscribers.empty() ? "off" : config.subscribers.at(0).endpoint;
}

TEST(ConfigOfThePaper, FilesLoadUnchanged) {
  const Config in_braces = Config::Parse(R"(network: {publisher: {ip: "tcp://*:5553", channels: [pre_channel]}, )"
                                         R"(subscribers: [{ip: "x", channels: [next_channel]}]})");
  const std::pair<Config, Names> loaded[] = {
      {Config::Load(FixtureFile("paper_network_setting.yaml")), {"pre_channel"}},
      {in_braces, {"pre_channel"}},
      {Config::Load(FixtureFile("paper_data_graph.yaml")), {"next_channel", "pre_channel"}},
      {Config::Load(FixtureFile("paper_visualization.yaml")), {"lidar_visual_channel", "re_optimized_poses"}}};
  for (const auto& [config, channels] : loaded) {
    EXPECT_EQ(config.publishers, (std::vector<EndpointConfig>{{"tcp://*:5553", channels, false}}));
    EXPECT_TRUE(config.subscribers.empty());
  }
  EXPECT_EQ(Config::Load(FixtureFile("paper_close_channels.yaml")).closed_channels, Names{"A"});
}

TEST(ConfigOfThePaper, FilesOfOneRobotMergeIntoOnePublisher) {
  const Config config =
      Config::Load({FixtureFile("paper_network_setting.yaml"), FixtureFile("paper_visualization.yaml"),
                    FixtureFile("paper_close_channels.yaml")});
  ASSERT_EQ(config.publishers.size(), 1U);
  EXPECT_EQ(config.publishers[0].channels, (Names{"lidar_visual_channel", "pre_channel", "re_optimized_poses"}));
  EXPECT_EQ(
      config.publishers,
      Config::Load({FixtureFile("paper_visualization.yaml"), FixtureFile("paper_network_setting.yaml")}).publishers)
      << "in any order";
  EXPECT_EQ(config.closed_channels, Names{"A"});
}

TEST(ConfigOfThePaper, ListingAsPrintedIsRefusedWithAnExplanation) {
  const auto file = FixtureFile("paper_network_setting_as_printed.yaml");
  ExpectConfigError([&] { return Config::Load(file); }, file.string() + ":8:9",
                    {"in the column of a list's dashes", "indent it as far as the text after the dash"});
}

TEST(Config, EmptyFileIsAnEmptyConfiguration) {
  for (const char* yaml : {"", "\n\n", "# nothing\n", "---\n", "{}", "network:\ndata_graph:\nchannels:\n",
                           "network: {subscribers: , security: }\ndata_graph: {close_channels: , nodes: }"}) {
    const Config config = Config::Parse(yaml);
    EXPECT_TRUE(config.publishers.empty() && config.subscribers.empty() && config.nodes.empty()) << yaml;
    EXPECT_FALSE(config.security.enabled());
    EXPECT_EQ(config.peer_queue_bytes, 64U * 1024 * 1024);
    EXPECT_EQ(config.heartbeat_ms, 1000);
    EXPECT_EQ(config.peer_timeout_ms, 5000);
    EXPECT_EQ(config.threads, 0);
  }
}

TEST(Config, ReadsEveryKey) {
  const Config config = Config::Load(FixtureFile("everything.yaml"));
  EXPECT_EQ(config.publishers, (std::vector<EndpointConfig>{{"ipc:///run/robot/bus", {}, true},
                                                            {"tcp://*:5553", {"pose", "scan"}, false}}));
  EXPECT_EQ(config.subscribers, (std::vector<EndpointConfig>{{"tcp://[fe80::1%eth0]:5555", {}, true},
                                                             {"tcp://robot2:5554", {"next_channel"}, false}}));
  EXPECT_TRUE(config.security.enabled());
  EXPECT_EQ(config.security.public_key, "Yne@$w-vo<fVvi]a<NY6T1ed:M$fCG*[IaLV{hID");
  EXPECT_EQ(config.security.secret_key, "D:)Q[IlAW!ahhC2ac:9*A}h:p?([4%wOTJ%JR%cs");
  EXPECT_EQ(config.security.allowed_clients, Names{"rq:rM>}U?@Lns47E1%kR.o@n%FcmmsL/@{H8]yf7"});
  EXPECT_EQ(config.security.servers.at("tcp://robot2:5554"), "rq:rM>}U?@Lns47E1%kR.o@n%FcmmsL/@{H8]yf7");
  EXPECT_EQ(config.peer_queue_bytes, 8U * 1024 * 1024);
  EXPECT_EQ(config.heartbeat_ms, 200);
  EXPECT_EQ(config.peer_timeout_ms, 1500);
  EXPECT_EQ(config.closed_channels, Names{"pre_channel"});
  EXPECT_EQ(config.threads, 3);
  EXPECT_EQ(config.nodes.at("localization").executor, Executor::Dedicated({2, 3}, 20));
  EXPECT_EQ(config.nodes.at("localization").queue, Queue::Latest());
  EXPECT_EQ(config.nodes.at("planner").executor, Executor::Inline());
  EXPECT_EQ(config.nodes.at("planner").queue, Queue::KeepAll(10, 64U << 20U));
  EXPECT_EQ(config.channels.at("scan"), (ChannelConfig{Queue::KeepLast(4), std::nullopt}));
  EXPECT_EQ(config.channels.at("map"), (ChannelConfig{Queue::KeepAll(1000, 256U << 20U), 1}));
}

TEST(Config, OverviewInTheDocumentationLoads) {
  std::ifstream file(FixtureFile("../../../docs/configuration.md"));
  const std::string page{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  const std::size_t begin = page.find("```yaml\n") + 8;
  ASSERT_LT(begin, page.size());
  const Config config = Config::Parse(std::string_view(page).substr(begin, page.find("```", begin) - begin));
  EXPECT_EQ(config.publishers, (std::vector<EndpointConfig>{{"tcp://*:5553", {"pose", "scan"}, false}}));
  EXPECT_EQ(config.nodes.at("localization").executor, Executor::Dedicated({2, 3}, 20));
}

TEST(ConfigEndpoint, EqualEndpointsGetOneSpelling) {
  EXPECT_EQ(PublisherOf("tcp://*:5553"), "tcp://*:5553");
  EXPECT_EQ(PublisherOf("*:5556"), "tcp://*:5556");
  EXPECT_EQ(PublisherOf("TCP://0.0.0.0:05553"), "tcp://*:5553");
  EXPECT_EQ(PublisherOf("1.2.3.4:5556"), "tcp://1.2.3.4:5556");
  EXPECT_EQ(PublisherOf("tcp://localhost:5553"), "tcp://127.0.0.1:5553");  // ZeroMQ cannot bind to names
  EXPECT_EQ(PublisherOf("tcp://eth0:5553"), "tcp://eth0:5553");
  EXPECT_EQ(PublisherOf("tcp://[0:0::1]:5553"), "tcp://[::1]:5553");
  EXPECT_EQ(PublisherOf("[::]:5553"), "tcp://[::]:5553");
  EXPECT_EQ(PublisherOf("ipc:///run//robot/./bus"), "ipc:///run/robot/bus");
  EXPECT_EQ(PublisherOf("ipc://@robot"), "ipc://@robot");
  EXPECT_EQ(SubscriberOf("tcp://Robot-2.local:5553"), "tcp://robot-2.local:5553");
  EXPECT_EQ(SubscriberOf("robot2:5553"), "tcp://robot2:5553");
  EXPECT_EQ(SubscriberOf("localhost:5553"), "tcp://localhost:5553");
  EXPECT_EQ(SubscriberOf("ipc:///run/robot/bus"), "ipc:///run/robot/bus");
  EXPECT_EQ(SubscriberOf("tcp://[FE80::1%eth0]:5553"), "tcp://[fe80::1%eth0]:5553");
}

TEST(ConfigEndpoint, MayLeaveThePortToTheSystemOrBeSwitchedOff) {
  EXPECT_EQ(PublisherOf("tcp://*:0"), "tcp://*:*");
  EXPECT_EQ(PublisherOf("tcp://127.0.0.1:*"), "tcp://127.0.0.1:*");
  EXPECT_NO_THROW((void)Config::Parse("network: {publisher: [{ip: 'tcp://*:0'}, {ip: 'tcp://127.0.0.1:0'}]}"));
  EXPECT_EQ(PublisherOf("x"), "off");
  EXPECT_EQ(SubscriberOf("x"), "off");
  EXPECT_NO_THROW((void)Config::Parse("network: {subscribers: [{ip: x}, {ip: x}]}"));
}

TEST(ConfigEndpoint, ChannelsMayBeAbsentOrEmptyAndAreMergedIfAPublisherIsRepeated) {
  const Config config =
      Config::Parse("network: {publisher: [{ip: '*:1', channels: [b, a]}, {ip: 'tcp://0.0.0.0:1', channels: [c, a]}]}");
  EXPECT_EQ(config.publishers, (std::vector<EndpointConfig>{{"tcp://*:1", {"a", "b", "c"}, false}}));
  const Config two = Config::Parse("network: {publisher: [{ip: '*:1'}, {ip: '*:2', channels: []}]}");
  EXPECT_EQ(two.publishers, (std::vector<EndpointConfig>{{"tcp://*:1", {}, true}, {"tcp://*:2", {}, false}}));
  const Config open = Config::Parse("network: {publisher: [{ip: '*:1', channels: [b, a]}, {ip: '*:1'}]}");
  EXPECT_EQ(open.publishers, (std::vector<EndpointConfig>{{"tcp://*:1", {}, true}}));
}

TEST(ConfigForms, AreAllRead) {
  const auto channel = [](const std::string& settings) {
    return Config::Parse("channels: {scan: {" + settings + "}}").channels.at("scan");
  };
  const auto queue = [&](const std::string& form) { return channel("queue: " + form).queue; };
  EXPECT_EQ(queue("latest"), Queue::Latest());
  EXPECT_EQ(queue("{keep_last: 16}"), Queue::KeepLast(16));
  EXPECT_EQ(queue("{keep_all: 1000}"), Queue::KeepAll(1000));
  EXPECT_EQ(queue("{keep_all: {messages: 5}}"), Queue::KeepAll(5));
  EXPECT_EQ(queue("{keep_all: {messages: 1000, bytes: 64MiB}}"), Queue::KeepAll(1000, 64U << 20U));
  EXPECT_EQ(queue("{keep_all: {messages: 1, bytes: 2 GiB}}"), Queue::KeepAll(1, std::size_t{2} << 30U));
  EXPECT_EQ(queue("{keep_all: {messages: 1, bytes: 4096}}"), Queue::KeepAll(1, 4096));
  EXPECT_EQ(channel("lossless: true, queue: {keep_all: 7}").queue, Queue::KeepAll(7));
  EXPECT_EQ(channel("lossless: false").queue, std::nullopt);

  const auto transports = [&](const std::string& form) { return channel("transports: " + form).transports; };
  EXPECT_EQ(transports("shared_memory"), (Names{"shared_memory"}));
  EXPECT_EQ(transports("[zmq]"), (Names{"zmq"}));
  EXPECT_EQ(transports("[zmq, shared_memory]"), (Names{"shared_memory", "zmq"}));

  const auto discovery = [](const std::string& form) { return Config::Parse("discovery: {" + form + "}").discovery; };
  EXPECT_EQ(discovery(""), DiscoveryConfig());
  EXPECT_FALSE(discovery("local: false").local);
  EXPECT_EQ(discovery("local: [slam, camera]"), (DiscoveryConfig{.local = true, .only = {"camera", "slam"}}));
  EXPECT_TRUE(discovery("lan: true").lan);
  EXPECT_EQ(discovery("lan: {interfaces: [eth1, eth0]}").lan_interfaces, (Names{"eth0", "eth1"}));

  const auto executor = [](const std::string& form) {
    return Config::Parse("data_graph: {nodes: {slam: {executor: " + form + "}}}").nodes.at("slam").executor;
  };
  EXPECT_EQ(executor("tbb"), Executor::Tbb());
  EXPECT_EQ(executor("inline"), Executor::Inline());
  EXPECT_EQ(executor("dedicated"), Executor::Dedicated());
  EXPECT_EQ(executor("{kind: inline}"), Executor::Inline());
  EXPECT_EQ(executor("{kind: dedicated, cpus: [0, 1], priority: 20}"), Executor::Dedicated({0, 1}, 20));

  EXPECT_TRUE(Config().control);
  EXPECT_TRUE(Config::Parse("control: on").control);
  EXPECT_FALSE(Config::Parse("control: off").control);
}

TEST(ConfigMerge, LaterFilesAddMissingSettings) {
  const ScratchFolder folder;
  const Config config = Config::Load(
      {folder.Write("a.yaml",
                    "network: {subscribers: [{ip: 'h:1', channels: [a]}]}\n"
                    "data_graph: {threads: 2, nodes: {slam: {queue: latest}}}\nchannels: {m: {latched: 1}}"),
       folder.Write("b.yaml",
                    "network: {subscribers: [{ip: 'tcp://h:1', channels: [b]}], heartbeat_ms: 5}\n"
                    "data_graph: {threads: 2, nodes: {slam: {executor: inline}}, close_channels: [z]}\n"
                    "channels: {m: {lossless: true}}"),
       folder.Write("c.yaml", "data_graph: {close_channels: [z, y]}")});
  EXPECT_EQ(config.subscribers, (std::vector<EndpointConfig>{{"tcp://h:1", {"a", "b"}, false}}));
  EXPECT_EQ(config.heartbeat_ms, 5);
  EXPECT_EQ(config.threads, 2);
  EXPECT_EQ(config.closed_channels, (Names{"y", "z"}));
  EXPECT_EQ(config.nodes.at("slam").queue, Queue::Latest());
  EXPECT_EQ(config.nodes.at("slam").executor, Executor::Inline());
  EXPECT_EQ(config.channels.at("m"), (ChannelConfig{Queue::KeepAll(1000, 256U << 20U), 1}));
}

TEST(ConfigMerge, ContradictionErrorNamesBothFiles) {
  const ScratchFolder folder;
  const auto expect = [&](const std::string& a, const std::string& b, const std::string& at_a,
                          const std::string& at_b) {
    const auto file_a = folder.Write("a.yaml", a);
    const auto file_b = folder.Write("b.yaml", b);
    const std::vector<std::filesystem::path> files = {file_a, file_b};
    ExpectConfigError([&] { return Config::Load(files); }, file_b.string() + ":" + at_b,
                      {file_a.string() + ":" + at_a});
  };
  expect("data_graph: {threads: 2}", "data_graph:\n  threads: 3", "1:23", "2:12");
  expect("network: {heartbeat_ms: 2}", "network:\n  heartbeat_ms: 3", "1:25", "2:17");
  expect("data_graph: {nodes: {slam: {queue: latest}}}", "data_graph: {nodes: {slam: {queue: {keep_last: 2}}}}", "1:36",
         "1:36");
  expect("channels: {m: {latched: 2}}", "channels: {m: {latched: 0}}", "1:25", "1:25");
  expect("network: {publisher: {ip: '*:5553'}}", "network: {publisher: {ip: '127.0.0.1:5553'}}", "1:27", "1:27");
}

TEST(ConfigYaml, HasAliasesNamesAsWrittenAByteOrderMarkAndWindowsLineBreaks) {
  const Config aliased = Config::Parse(
      "network:\n  publisher: {ip: '*:1', channels: &list [a, b]}\n  subscribers: [{ip: 'h:1', channels: *list}]\n");
  EXPECT_EQ(aliased.subscribers, (std::vector<EndpointConfig>{{"tcp://h:1", {"a", "b"}, false}}));
  const auto closed = [](std::string_view yaml) { return Config::Parse(yaml).closed_channels; };
  EXPECT_EQ(closed("data_graph: {close_channels: [1, yes, !!str true, robot1/scan, 雷达]}"),
            (Names{"1", "robot1/scan", "true", "yes", "雷达"}));
  EXPECT_EQ(closed("\xEF\xBB\xBF# robot\r\ndata_graph:\r\n  close_channels:\r\n    - a\r\n"), Names{"a"});
}

TEST(ConfigOfEnvironment, IsYamlOrTheDefault) {
  EXPECT_EQ(Config::OfEnvironment().publishers, Config().publishers);
  ASSERT_EQ(setenv("HGROS_CONFIG", "network: {publisher: {ip: '*:5553'}}", 1), 0);
  EXPECT_EQ(Config::OfEnvironment().publishers, (std::vector<EndpointConfig>{{"tcp://*:5553", {}, true}}));
  ASSERT_EQ(setenv("HGROS_CONFIG", "netwrk: {}", 1), 0);
  ExpectConfigError([] { return Config::OfEnvironment(); }, "HGROS_CONFIG:1:1",
                    {"HGROS_CONFIG:1:1: Unknown key \"netwrk\""});
  ASSERT_EQ(setenv("HGROS_CONFIG", "", 1), 0);
  EXPECT_EQ(Config::OfEnvironment().publishers, Config().publishers);
  ASSERT_EQ(unsetenv("HGROS_CONFIG"), 0);
}

}  // namespace
}  // namespace hgros
