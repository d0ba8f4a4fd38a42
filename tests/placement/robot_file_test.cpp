#include "hgros/placement/robot_file.hpp"

#include "config/config_fixture.hpp"
#include "hgros/params/param_view.hpp"

namespace hgros {
namespace {

using test::ScratchFolder;

constexpr std::string_view kRobot = R"(
discovery: {domain: test}
channels: {scan: {queue: {keep_last: 4}}}
components:
  laser:
    type: demo/Laser
    params: {rate_hz: 40, frame: laser}
    remap: {scan: front/scan}
  mapper:
    type: demo/Mapper
    params: {cell_size_m: 0.05}
    nodes: {scan: {queue: latest, executor: dedicated}}
    essential: true
    restart: on-exception
    checkpoint: 500ms
    deadline: 50ms
  watch: {type: demo/Watch}
processes:
  front:
    components: [laser]
    cpus: [1, 0]
    nice: -5
    priority: 20
    memory: 200MB
    env: {LEVEL: 3}
    restart: on-failure
    data_graph: {threads: 2}
    channels: {scan: {queue: {keep_last: 9}}}
programs:
  screen: {command: [python3, screen.py], restart: always, essential: true, publishes: [wanted, lights],
           subscribes: [map], serves: [show], calls: [plan]}
)";

std::optional<std::string> NoVariables(const std::string&) { return std::nullopt; }

// The faults of a text, each without its folder.
std::vector<std::string> FaultsOf(std::string_view text, std::vector<ParamOverride> overrides = {}) {
  const ScratchFolder folder;
  const auto file = folder.Write("robot.yaml", text);
  const std::string prefix = folder.path().string() + "/";
  std::vector<std::string> faults;
  for (const ConfigError& fault : RobotFile::Check(file, {NoVariables, std::move(overrides)}).faults) {
    std::string line = fault.what();
    for (std::size_t at = 0; (at = line.find(prefix)) != std::string::npos;) line.erase(at, prefix.size());
    faults.push_back(std::move(line));
  }
  return faults;
}

void ExpectFault(std::string_view text, std::string_view part, std::vector<ParamOverride> overrides = {}) {
  const std::vector<std::string> faults = FaultsOf(text, std::move(overrides));
  ASSERT_EQ(faults.size(), 1U) << text << "\nfirst: " << (faults.empty() ? "none" : faults[0]);
  EXPECT_NE(faults[0].find(part), std::string::npos) << faults[0] << "\nlacks: " << part;
}

// The fault of `more` below a good component.
void ExpectBelow(const std::string& more, std::string_view part) {
  ExpectFault("components: {a: {type: x}}\n" + more, part);
}

RobotFile Read(std::string_view text, std::vector<ParamOverride> overrides = {}) {
  const ScratchFolder folder;
  return RobotFile::Load(folder.Write("robot.yaml", text), {NoVariables, std::move(overrides)});
}

TEST(RobotFileTest, ReadsComponents) {
  const RobotFile robot = Read(kRobot);
  ASSERT_EQ(robot.components.size(), 3U);
  const RobotComponent& laser = robot.components[0];
  EXPECT_EQ(laser.setup.name, "laser");
  EXPECT_EQ(laser.setup.type, "demo/Laser");
  EXPECT_EQ(laser.setup.remap.at("scan"), "front/scan");
  EXPECT_EQ(ParamView(laser.setup.params.section).Get<int>("rate_hz"), 40);
  EXPECT_NE(laser.setup.params.section->Find("rate_hz")->origin.ToString().find("robot.yaml:7:23"), std::string::npos);
  EXPECT_FALSE(laser.essential);
  const RobotComponent& mapper = robot.components[1];
  EXPECT_TRUE(mapper.essential);
  EXPECT_EQ(laser.restart, ComponentRestart::kNever);
  EXPECT_EQ(laser.checkpoint, Duration{0});
  EXPECT_EQ(mapper.restart, ComponentRestart::kOnException);
  EXPECT_EQ(mapper.checkpoint, std::chrono::milliseconds(500));
  EXPECT_EQ(mapper.setup.deadline, std::chrono::milliseconds(50));
  EXPECT_EQ(mapper.setup.nodes.at("scan").queue, Queue::Latest());
  EXPECT_EQ(mapper.setup.nodes.at("scan").executor, Executor::Dedicated());
}

TEST(RobotFileTest, ReadsProcessesAndPrograms) {
  const RobotFile robot = Read(kRobot);
  ASSERT_EQ(robot.processes.size(), 2U);
  const RobotProcess& front = robot.processes[0];
  EXPECT_EQ(front.name, "front");
  EXPECT_EQ(front.components, std::vector<std::string>{"laser"});
  EXPECT_EQ(front.cpus, (std::vector<int>{0, 1}));
  EXPECT_EQ(front.nice, -5);
  EXPECT_EQ(front.priority, 20);
  EXPECT_EQ(front.memory_bytes, 200'000'000U);
  EXPECT_EQ(front.env.at("LEVEL"), "3");
  EXPECT_EQ(front.restart, RestartPolicy::kOnFailure);
  ASSERT_EQ(robot.programs.size(), 1U);
  EXPECT_EQ(robot.programs[0].command, (std::vector<std::string>{"python3", "screen.py"}));
  EXPECT_EQ(robot.programs[0].publishes, (std::vector<std::string>{"wanted", "lights"}));
  EXPECT_EQ(robot.programs[0].subscribes, (std::vector<std::string>{"map"}));
  EXPECT_EQ(robot.programs[0].serves, (std::vector<std::string>{"show"}));
  EXPECT_EQ(robot.programs[0].calls, (std::vector<std::string>{"plan"}));
  EXPECT_TRUE(robot.programs[0].declares());
  EXPECT_EQ(robot.programs[0].restart, RestartPolicy::kAlways);
  EXPECT_TRUE(robot.programs[0].essential);
}

TEST(RobotFileTest, ComponentsWithoutAProcessRunInMain) {
  const RobotFile robot = Read(kRobot);
  EXPECT_EQ(robot.processes[1].name, "main");
  EXPECT_EQ(robot.processes[1].components, (std::vector<std::string>{"mapper", "watch"}));
  EXPECT_EQ(robot.FindComponent("mapper")->process, "main");
  const RobotFile alone = Read("components: {a: {type: x/A}, b: {type: x/A}}");
  ASSERT_EQ(alone.processes.size(), 1U);
  EXPECT_EQ(alone.processes[0].components, (std::vector<std::string>{"a", "b"}));
}

TEST(RobotFileTest, PlacesAComponentElsewhere) {
  RobotFile robot = Read(
      "components: {a: {type: t}, b: {type: t}}\n"
      "processes: {one: {components: [a, b]}, two: {}}\n");
  robot.Place("a", "two");
  EXPECT_EQ(robot.FindComponent("a")->process, "two");
  EXPECT_EQ(robot.FindProcess("one")->components, std::vector<std::string>{"b"});
  EXPECT_EQ(robot.FindProcess("two")->components, std::vector<std::string>{"a"});
}

TEST(RobotFileTest, SectionsOfAProcessAreOnTopOfTheRobots) {
  const RobotFile robot = Read(kRobot);
  EXPECT_EQ(robot.processes[0].config.discovery.domain, "test");
  EXPECT_EQ(robot.processes[0].config.threads, 2);
  EXPECT_EQ(robot.processes[0].config.channels.at("scan").queue, Queue::KeepLast(9));
  EXPECT_EQ(robot.processes[1].config.discovery.domain, "test");
  EXPECT_EQ(robot.processes[1].config.threads, 0);
  EXPECT_EQ(robot.processes[1].config.channels.at("scan").queue, Queue::KeepLast(4));
}

TEST(RobotFileTest, OverridesBeginWithAComponentOrASection) {
  const RobotFile robot = Read(kRobot, {{"mapper.params.cell_size_m", "0.1", "--set mapper.params.cell_size_m"},
                                        {"laser.remap.scan", "rear/scan", "--set laser.remap.scan"},
                                        {"processes.front.nice", "3", "--set processes.front.nice"},
                                        {"discovery.domain", "other", "--set discovery.domain"},
                                        {"mapper.params.color", "#ff0000", "--set mapper.params.color"}});
  EXPECT_EQ(ParamView(robot.components[1].setup.params.section).Get<double>("cell_size_m"), 0.1);
  EXPECT_EQ(robot.components[1].setup.params.section->Find("cell_size_m")->origin.ToString(),
            "--set mapper.params.cell_size_m");
  EXPECT_EQ(robot.components[0].setup.remap.at("scan"), "rear/scan");
  EXPECT_EQ(robot.processes[0].nice, 3);
  EXPECT_EQ(robot.processes[1].config.discovery.domain, "other");
}

TEST(RobotFileTest, OverridesThatFitNothingAreFaults) {
  ExpectFault(kRobot, "--set maper.params.x: There is no component and no section \"maper\". Did you mean \"mapper\"?",
              {{"maper.params.x", "1", "--set maper.params.x"}});
  ExpectFault(kRobot, "--set mapper.parms.x: Unknown key \"parms\" in components.mapper. Did you mean \"params\"?",
              {{"mapper.parms.x", "1", "--set mapper.parms.x"}});
  ExpectFault(kRobot, "--set processes.front.nice: processes.front.nice must be an integer from -20 to 19",
              {{"processes.front.nice", "fast", "--set processes.front.nice"}});
  ExpectFault(kRobot, "processes.front.memory must be a size from 1MiB to 1048576GiB",
              {{"processes.front.memory", "200Mb", "--set processes.front.memory"}});
  ExpectFault(kRobot, "--set a: ", {{"laser.params[3]", "1", "--set a"}});
  ExpectFault(kRobot, "--set a: ", {{"laser..params", "1", "--set a"}});
  ExpectFault(kRobot, "--set a: ", {{"", "1", "--set a"}});
  ExpectFault(kRobot, "--set a:", {{"laser.params.x", "[1", "--set a"}});
}

TEST(RobotFileTest, FaultsHaveAPlaceAndTheNearestName) {
  ExpectFault("a: 1\ncomponents: {a: {type: x/A}}", "robot.yaml:1:1: Unknown key \"a\" at the top level.");
  ExpectFault("component: {}\ncomponents: {a: {type: x/A}}", "Did you mean \"components\"?");
  ExpectFault("processes: {}", "The file has no \"components\" and no \"programs\".");
  ExpectFault("component: {a: {type: x/A}}",
              "robot.yaml:1:1: Unknown key \"component\" at the top level. Did you mean \"components\"?");
  ExpectFault("components: {}", "components has no component.");
  ExpectFault("components: [a]", "components must be a map from names to components, but is a list.");
  ExpectFault("components: {a: {typ: y, type: x}}",
              "robot.yaml:1:18: Unknown key \"typ\" in components.a. Did you mean \"type\"?");
  ExpectFault("components: {a: {type: [x]}}", "components.a.type must be the name of a component type");
  ExpectFault("components: {a/b: {type: x}}", "\"a/b\" cannot be the name of a component: it has a slash or a dot.");
  ExpectFault("components: {a: {type: x, params: 5}}", "components.a.params must be a map of parameters");
  ExpectFault("components: {a: {type: x, remap: {s: 'a b'}}}", "components.a.remap.s has the name \"a b\"");
  ExpectFault("components: {a: {type: x, nodes: {s: {queu: latest}}}}", "Unknown key \"queu\"");
  ExpectFault("components: {a: {type: x, essential: 1}}", "must be true or false");
  ExpectFault("components: {a: {type: x, restart: always}}", "must be one of never, on-failure, on-exception");
  ExpectFault("components: {a: {type: x, checkpoint: soon}}",
              "components.a.checkpoint must be a duration such as 500ms");
  ExpectFault("components: {a: {type: x, checkpoint: 5ms}}", "is too short. The shortest is 10ms.");
  ExpectFault("components: {a: {type: x, deadline: 0s}}", "is too short. The shortest is 1ms.");
  ExpectBelow("processes: {p: {components: [b]}}", "2:30: processes.p.components[0] is \"b\"");
  ExpectFault("components: {abcd: {type: x}}\nprocesses: {p: {components: [abce]}}", "Did you mean \"abcd\"?");
  ExpectBelow("processes: {p: {components: [a]}, q: {components: [a]}}", "which is placed already at robot.yaml:2:30");
  ExpectBelow("processes: {p: {restart: sometimes}}", "must be one of never, on-failure, always");
  ExpectBelow("processes: {p: {cpus: [1, 1]}}", "is a CPU that the list already has");
  ExpectBelow("processes: {p: {env: {\"A=B\": 1}}}", "cannot be the name of a variable");
  ExpectBelow("processes: {p: {env: {A: \"a\\0b\"}}}", "processes.p.env.A has a byte 0");
  ExpectBelow("processes: {p: {env: {\"A\\0B\": 1}}}", "cannot be the name of a variable");
  ExpectBelow("programs: {p: {command: [ls, \"a\\0b\"]}}", "has a byte 0");
  ExpectFault("include: /dev/zero", "which is a pipe or a device");
  ExpectBelow("processes: {p: {env: {A: [1]}}}", "processes.p.env.A must be a text");
  ExpectBelow("programs: {p: {}}", "programs.p has no \"command\"");
  ExpectBelow("programs: {p: {command: []}}", "names no program");
  ExpectBelow("programs: {p: {command: ls}}", "must be a list of the program");
  ExpectBelow("time: simulatd", "Did you mean \"simulated\"?");
  ExpectBelow("processes: {p: {time: simulatd}}", "2:23: time must be one of");
  ExpectFault("components: {a: ${X}}", "The variable X is not set.");
}

TEST(RobotFileTest, ANameMeansOneThing) {
  ExpectBelow("programs: {a: {command: [ls]}}", "The name \"a\" is taken by the component at robot.yaml:1:14.");
  ExpectBelow("processes: {a: {}}", "The name \"a\" is taken by the component at robot.yaml:1:14.");
  ExpectBelow("programs: {main: {command: [ls]}}",
              "The name \"main\" is taken by the process of components without one, such as that at robot.yaml:1:14.");
  EXPECT_TRUE(FaultsOf("components: {a: {type: x}}\nprocesses: {a: {components: [a]}}").empty());
}

TEST(RobotFileTest, EveryFaultIsReported) {
  const std::vector<std::string> faults = FaultsOf(
      "components:\n  a: {type: x, essential: 3}\n  b: {}\nprocesses:\n  p: {nice: 99, components: [a, c]}\n"
      "programs: {q: {command: 1}}\ntime: never\n");
  ASSERT_EQ(faults.size(), 6U);
  EXPECT_TRUE(faults[0].starts_with("robot.yaml:2:27: ")) << faults[0];
  EXPECT_TRUE(faults[5].starts_with("robot.yaml:7:7: ")) << faults[5];
}

TEST(RobotFileTest, TellsRobotFilesFromOthers) {
  const ScratchFolder folder;
  EXPECT_TRUE(RobotFile::Is(folder.Write("a.yaml", "components: {a: {type: '${MISSING}'}}")));
  EXPECT_FALSE(RobotFile::Is(folder.Write("b.yaml", "network: {}")));
  EXPECT_FALSE(RobotFile::Is(folder.Write("c.yaml", "[")));
  EXPECT_FALSE(RobotFile::Is(folder.path() / "none.yaml"));
  EXPECT_TRUE(RobotFile::Is(folder.Write("d.yaml", "include: none.yaml"))) << "Its fault is that of a robot file.";
  EXPECT_TRUE(RobotFile::Is(folder.Write("e.yaml", "include: e.yaml")));
  const auto similar = folder.Write("f.yaml", "component: {a: {type: x}}");
  EXPECT_TRUE(RobotFile::Is(similar));
  EXPECT_FALSE(RobotFile::Is(similar, {"component"})) << "The section of a program.";
  EXPECT_TRUE(RobotFile::Is(folder.Write("g.yaml", "processes: {p: {components: [a]}}")));
  EXPECT_TRUE(RobotFile::Is(folder.Write("i.yaml", "components: {a: {type: '${1}'}}"))) << "Whatever is wrong in it.";
  EXPECT_TRUE(RobotFile::Is(folder.Write("j.yaml", "components: {a: {type: b}")));
  EXPECT_FALSE(RobotFile::Is(folder.Write("h.yaml", "network: {}\ncompass: {}")));
}

TEST(RobotFileTest, ReadsHosts) {
  const RobotFile robot = Read(
      "hosts: {cart: {address: 10.0.0.1, home: true}, base: {address: 'fe80::1', port: 7000}, "
      "arm: {ssh: me@arm, hgros: ~/bin/hgros}}\n"
      "components: {a: {type: x}, b: {type: x}, c: {type: x}}\n"
      "processes: {p: {components: [a], host: base}, q: {components: [b], host: cart}}\n"
      "programs: {s: {command: [ls], host: arm}}\n");
  ASSERT_EQ(robot.hosts.size(), 3U);
  EXPECT_EQ(robot.hosts[0].port, 5650);
  EXPECT_EQ(robot.hosts[1].address, "fe80::1");
  EXPECT_EQ(robot.hosts[1].port, 7000);
  EXPECT_EQ(robot.hosts[1].ssh, "");
  EXPECT_EQ(robot.hosts[1].hgros, "hgros");
  EXPECT_EQ(robot.hosts[2].address, "arm");
  EXPECT_EQ(robot.hosts[2].ssh, "me@arm");
  EXPECT_EQ(robot.hosts[2].hgros, "~/bin/hgros");
  EXPECT_EQ(robot.FindHost(""), &robot.hosts[0]);
  EXPECT_EQ(robot.FindHost("base"), &robot.hosts[1]);
  EXPECT_EQ(robot.FindProcess("p")->host, "base");
  EXPECT_EQ(robot.FindProcess("q")->host, "") << "It is home.";
  EXPECT_EQ(robot.FindProcess("main")->host, "");
  EXPECT_EQ(robot.programs[0].host, "arm");
}

TEST(RobotFileTest, FaultsOfHostsHaveAPlaceAndTheNearestName) {
  ExpectBelow("hosts: {base: {adress: x}}", "2:16: Unknown key \"adress\" in hosts.base. Did you mean \"address\"?");
  ExpectBelow("hosts: {'a b': {}}", "\"a b\" cannot be the name of a host.");
  ExpectBelow("hosts: {b: {address: 'tcp://x'}}", "Write it without scheme and port");
  ExpectBelow("hosts: {b: {address: '10.0.0.1:5650'}}", "Write it without scheme and port");
  ExpectBelow("hosts: {b: {port: 0}}", "hosts.b.port must be an integer from 1 to 64535");
  ExpectBelow("hosts: {b: {home: 1}}", "hosts.b.home must be true or false");
  ExpectBelow("hosts: {b: {ssh: '-oProxyCommand=x'}}",
              "hosts.b.ssh is \"-oProxyCommand=x\", to which ssh cannot connect");
  ExpectBelow("hosts: {b: {hgros: ''}}", "hosts.b.hgros is empty");
  ExpectBelow("hosts: {b: {key: short, secret_key_file: /k}}", "hosts.b.key has 5 characters, but a key has 40");
  ExpectBelow("hosts: {b: {secret_key_file: /k}}", "hosts.b has a secret_key_file, but no key");
  ExpectBelow("hosts: {a: {home: true}, b: {home: true}}", "2:26: Two hosts are home: \"a\" and \"b\".");
  ExpectBelow("hosts: {a: {address: 10.0.0.1}, b: {address: 10.0.0.1}}",
              "2:33: The hosts \"a\" and \"b\" have the same address, 10.0.0.1, and both use its port 5650.");
  ExpectBelow("hosts: {a: {address: h, home: true}, b: {address: h, port: 5651}}\nprocesses: {p: {}, q: {}}",
              "and both use its port 5651. Correct the address of one, or give it another `port`.");
  ExpectBelow(
      "hosts: {a: {address: h, home: true}, b: {address: h, port: 5651}}\n"
      "processes: {p: {}}\nprograms: {q: {command: [ls], publishes: [x]}}",
      "and both use its port 5651.");
  ExpectBelow("programs: {q: {command: [ls], calls: plan}}", "programs.q.calls must be a list of names");
  ExpectBelow("hosts: {base: {home: 1}}\nprocesses: {p: {host: base}}", "hosts.base.home must be true or false");
  ExpectBelow("hosts: {base: 5}\nprocesses: {p: {host: base}}", "hosts.base must be a map with address");
  ExpectBelow("hosts: {base: }\nprocesses: {p: {host: bas}}",
              "3:23: processes.p.host is \"bas\", which is no host of the robot. Did you mean \"base\"?");
  const std::string key = "rq:rM>}U?@Lns47E1%kR.o@n%FcmmsL/@{H8]yf7";
  ExpectBelow("hosts: {a: {key: '" + key + "'}}", "hosts.a has a key, but no secret_key_file");
  ExpectBelow("hosts: {a: {key: '" + key + "', secret_key_file: k}}", "hosts.a.secret_key_file must be a full path");
  ExpectBelow("hosts: {a: {key: '" + key + "', secret_key_file: /k}, b: }",
              "The host \"b\" has no key, but others have one.");
  EXPECT_TRUE(FaultsOf("hosts: {a: {address: h, home: true}, b: {address: h, port: 5652}}\n"
                       "components: {a: {type: x}}\nprocesses: {p: {}}")
                  .empty());
}

TEST(RobotFileTest, SectionsOfTheRobotAreOfNoOtherProcess) {
  const RobotFile robot = Read(
      "components: {a: {type: x}, b: {type: x}, c: {type: x}}\ndata_graph: {threads: 1}\n"
      "processes: {p: {components: [a], data_graph: {threads: 7}}, q: {components: [b]}, r: {components: [c]}}\n");
  EXPECT_EQ(robot.processes[0].config.threads, 7);
  EXPECT_EQ(robot.processes[1].config.threads, 1);
  EXPECT_EQ(robot.processes[2].config.threads, 1);
}

}  // namespace
}  // namespace hgros
