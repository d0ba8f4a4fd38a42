#include "launch/host_networks.hpp"

#include <algorithm>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "hgros/base/error.hpp"
#include "hgros/base/names.hpp"

namespace hgros::cli {
namespace {

std::string InQuotes(std::string_view text) {
  std::string quoted = "\"";
  for (const char letter : text) {
    if (letter == '"' || letter == '\\') quoted += '\\';
    quoted += letter;
  }
  return quoted + "\"";
}

std::string ListOf(const std::set<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + InQuotes(name);
  return "[" + list + "]";
}

// What exchanges messages, in the order of the ports: processes, then programs that say what they exchange.
std::vector<const RobotUnit*> Exchanging(const RobotFile& robot) {
  std::vector<const RobotUnit*> units;
  for (const RobotProcess& one : robot.processes) units.push_back(&one);
  for (const RobotProgram& one : robot.programs) {
    if (one.declares()) units.push_back(&one);
  }
  return units;
}

const RobotHost& HostOf(const RobotFile& robot, const RobotUnit& unit) {
  if (const RobotHost* host = robot.FindHost(unit.host)) return *host;
  throw ConfigError((robot.FindProcess(unit.name) != nullptr ? "The process \"" : "The program \"") + unit.name +
                        "\" exchanges messages with another host, but no host is home.",
                    unit.at,
                    "Add the host where `hgros run` is started: `hosts: {NAME: {address: ADDRESS, home: true}}`.");
}

// Each of them on a host has a port, in the order of the file.
int PortOf(const RobotFile& robot, const RobotHost& host, const RobotUnit& unit) {
  int port = host.port;
  for (const RobotUnit* one : Exchanging(robot)) {
    if (one->name == unit.name) break;
    port += one->host == unit.host ? 1 : 0;
  }
  return port;
}

bool HasIpv6(const RobotHost& host) { return host.address.find(':') != std::string::npos; }

// Where others reach the host.
std::string EndpointOf(const RobotHost& host, int port) {
  return "tcp://" + (HasIpv6(host) ? "[" + host.address + "]" : host.address) + ":" + std::to_string(port);
}

// All addresses of the host, since others may reach it by another than its own.
std::string PublisherEndpointOf(const RobotHost& host, int port) {
  return (HasIpv6(host) ? "tcp://[::]:" : "tcp://*:") + std::to_string(port);
}

// What the file says of the process must not contradict what is derived.
void RequireRoom(const RobotProcess& process, const RobotHost& host, bool publishes, int number) {
  if (!host.key.empty() && process.config.security.enabled()) {
    throw ConfigError("The process \"" + process.name + "\" has network.security, and its host has a key.", process.at,
                      "Keep one of them.");
  }
  const std::string port = ":" + std::to_string(number);
  for (const EndpointConfig& own : process.config.publishers) {
    if (!publishes || !own.endpoint.ends_with(port)) continue;
    throw ConfigError("The process \"" + process.name + "\" publishes at " + own.endpoint +
                          ", but its host uses that port for other hosts.",
                      process.at, "Set another `port` of the host.");
  }
}

// The old place of a component asks its subscribers whether they have everything.
void AddQuestions(std::set<std::string>& out, std::set<std::string>& in) {
  const bool asks = !out.empty();
  const bool answers = !in.empty();
  if (asks) {
    out.insert("hgros/control");
    in.insert("hgros/control/replies");
  }
  if (answers) {
    in.insert("hgros/control");
    out.insert("hgros/control/replies");
  }
}

std::string NetworkOf(const RobotFile& robot, const RobotGraph& graph, const RobotUnit& unit) {
  std::set<std::string> published;
  std::set<std::string> clients;
  std::string subscribers;
  std::string servers;
  for (const RobotUnit* each : Exchanging(robot)) {
    const RobotUnit& other = *each;
    if (other.host == unit.host) continue;
    std::set<std::string> out = graph.ChannelsFrom(unit.name, other.name);
    std::set<std::string> in = graph.ChannelsFrom(other.name, unit.name);
    if (out.empty() && in.empty()) continue;
    if (graph.HasMoving()) AddQuestions(out, in);
    const RobotHost& host = HostOf(robot, other);
    published.insert(out.begin(), out.end());
    if (!out.empty()) clients.insert(host.key);
    if (in.empty()) continue;
    const std::string endpoint = InQuotes(EndpointOf(host, PortOf(robot, host, other)));
    subscribers += "    - {ip: " + endpoint + ", channels: " + ListOf(in) + "}\n";
    servers += "      " + endpoint + ": " + InQuotes(host.key) + "\n";
  }
  if (published.empty() && subscribers.empty()) return {};
  const RobotHost& host = HostOf(robot, unit);
  const int port = PortOf(robot, host, unit);
  if (const RobotProcess* process = robot.FindProcess(unit.name)) RequireRoom(*process, host, !published.empty(), port);
  std::string yaml = "network:\n";
  if (!published.empty()) {
    yaml +=
        "  publisher: {ip: " + InQuotes(PublisherEndpointOf(host, port)) + ", channels: " + ListOf(published) + "}\n";
  }
  if (!subscribers.empty()) yaml += "  subscribers:\n" + subscribers;
  if (host.key.empty()) return yaml;
  yaml += "  security:\n    public_key: " + InQuotes(host.key) +
          "\n    secret_key_file: " + InQuotes(host.secret_key_file) + "\n";
  if (!clients.empty()) yaml += "    allowed_clients: " + ListOf(clients) + "\n";
  if (!servers.empty()) yaml += "    servers:\n" + servers;
  return yaml;
}

void Add(Config derived, Config& config) {
  for (EndpointConfig& endpoint : derived.publishers) config.publishers.push_back(std::move(endpoint));
  for (EndpointConfig& endpoint : derived.subscribers) {
    std::erase_if(config.subscribers, [&](const auto& own) { return own.endpoint == endpoint.endpoint; });
    config.subscribers.push_back(std::move(endpoint));
  }
  std::ranges::sort(config.publishers, {}, &EndpointConfig::endpoint);
  std::ranges::sort(config.subscribers, {}, &EndpointConfig::endpoint);
  if (derived.security.enabled()) config.security = std::move(derived.security);
}

// Faults get the place of the host in the robot file, because no file has this text.
Config ParseNetwork(const std::string& yaml, const RobotHost& host) {
  try {
    return Config::Parse(yaml, "hosts");
  } catch (const ConfigError& fault) {
    constexpr std::string_view kOwn = "network.security.secret_key_file";
    std::string what = fault.sentence();
    if (what.starts_with(kOwn)) what.replace(0, kOwn.size(), "hosts." + host.name + ".secret_key_file");
    throw ConfigError(what, host.at, fault.mend());
  }
}

}  // namespace

std::map<std::string, std::string> HostNetworks(const RobotFile& robot, const RobotGraph& graph) {
  std::map<std::string, std::string> networks;
  for (const RobotUnit* unit : Exchanging(robot)) {
    if (std::string yaml = NetworkOf(robot, graph, *unit); !yaml.empty()) networks[unit->name] = std::move(yaml);
  }
  return networks;
}

void RequireHost(const RobotFile& robot, const std::string& host) {
  if (host.empty()) return;
  std::vector<std::string> names;
  for (const RobotHost& one : robot.hosts) names.push_back(one.name);
  if (std::ranges::find(names, host) != names.end()) return;
  const std::string nearest = NearestName(host, names);
  throw Error("The robot has no host \"" + host + "\".", {},
              nearest.empty() ? "Add it to hosts." : "Did you mean \"" + nearest + "\"?");
}

RobotFile PartOfHost(const RobotFile& robot, const std::string& host,
                     const std::map<std::string, std::string>& networks) {
  const RobotHost* home = robot.FindHost({});
  const std::string here = home != nullptr && home->name == host ? std::string() : host;
  RobotFile part = robot;
  const auto elsewhere = [&](const RobotUnit& one) { return !host.empty() && one.host != here; };
  std::erase_if(part.components, [&](const RobotComponent& one) { return elsewhere(*robot.FindProcess(one.process)); });
  std::erase_if(part.processes, elsewhere);
  std::erase_if(part.programs, elsewhere);
  if (part.processes.empty() && part.programs.empty()) {
    throw Error("Nothing of the robot runs on the host \"" + host + "\".", {}, "Give a process the key `host`.");
  }
  for (RobotProcess& process : part.processes) {
    const auto network = networks.find(process.name);
    if (network == networks.end() || process.host != here) continue;
    Add(ParseNetwork(network->second, HostOf(robot, process)), process.config);
  }
  for (RobotProgram& program : part.programs) {
    const auto network = networks.find(program.name);
    if (network != networks.end() && program.host == here) program.env.emplace("HGROS_CONFIG", network->second);
  }
  return part;
}

}  // namespace hgros::cli
