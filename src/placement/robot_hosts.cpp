// The hosts of a robot file, and which of them a process names.
#include <algorithm>
#include <cctype>
#include <string>
#include <string_view>
#include <vector>

#include "hgros/base/names.hpp"
#include "hgros/yaml/quoted.hpp"
#include "placement/robot_draft.hpp"

namespace hgros {
namespace {

using yaml::Field;
using yaml::Section;
using yaml::Value;

constexpr int kFirstPort = 5650;
constexpr int kMostPort = 64535;  // Room for a thousand processes.
constexpr std::size_t kKeyLength = 40;

bool IsHostLetter(char letter) {
  return std::isalnum(static_cast<unsigned char>(letter)) != 0 ||
         std::string_view(".-_:%").find(letter) != std::string_view::npos;
}

std::string ReadAddress(const Value& value) {
  const std::string& address = value.Text("an address or a host name");
  const bool has_port = std::ranges::count(address, ':') == 1;  // An IPv6 address has more.
  if (address.empty() || has_port || !std::ranges::all_of(address, IsHostLetter)) {
    value.Fail("is " + yaml::Quoted(address) + ", which is neither an address nor a host name",
               "Write it without scheme and port, such as 192.168.1.7 or robot2.");
  }
  return address;
}

// As ssh takes it: a name of its configuration, or user@host.
std::string ReadDestination(const Value& value) {
  const std::string& destination = value.Text("what ssh connects to");
  const auto allowed = [](char letter) {
    return IsHostLetter(letter) || std::string_view("@/[]").find(letter) != std::string_view::npos;
  };
  if (destination.empty() || destination.starts_with('-') || !std::ranges::all_of(destination, allowed)) {
    value.Fail("is " + yaml::Quoted(destination) + ", to which ssh cannot connect",
               "Write a host of your ssh configuration, or USER@HOST.");
  }
  return destination;
}

}  // namespace

void RobotDraft::ReadHost(const Field& field) {
  if (field.key.empty() || field.key.starts_with('-') || !std::ranges::all_of(field.key, IsHostLetter)) {
    throw ConfigError(yaml::Quoted(field.key) + " cannot be the name of a host.", field.key_position,
                      "Use letters, digits, \"_\" and \"-\".");
  }
  RobotHost& host = robot_.hosts.emplace_back();  // Whatever is wrong with it: others may name it.
  host.name = field.key;
  host.at = field.key_position;
  host.port = kFirstPort;
  host.address = field.key;
  const Section section(field.value, "a map with address",
                        {"address", "port", "key", "secret_key_file", "home", "ssh", "hgros"});
  section.Read("address", [&](const Value& address) { host.address = ReadAddress(address); });
  section.Read("port", [&](const Value& port) { host.port = static_cast<int>(port.Integer(1, kMostPort)); });
  section.Read("home", [&](const Value& home) { host.home = home.Boolean(); });
  section.Read("ssh", [&](const Value& ssh) { host.ssh = ReadDestination(ssh); });
  section.Read("hgros", [&](const Value& command) {
    host.hgros = command.Text("a command there");
    if (host.hgros.empty()) command.Fail("is empty", "Name the command there, such as /opt/robot/bin/hgros.");
  });
  section.Read("key", [&](const Value& key) {
    host.key = key.Text("a public key of 40 characters");
    if (host.key.size() != kKeyLength) {
      key.Fail("has " + std::to_string(host.key.size()) + " characters, but a key has 40",
               "`hgros-keygen` prints the public key.");
    }
  });
  section.Read("secret_key_file", [&](const Value& file) {
    host.secret_key_file = file.Text("the path of a file on that host");
    if (!host.secret_key_file.starts_with('/')) file.Fail("must be a full path", "It is read on that host.");
  });
  if (host.key.empty() != host.secret_key_file.empty()) {
    const bool lacks_key = host.key.empty();
    section.value().Fail(
        std::string("has a ") + (lacks_key ? "secret_key_file, but no key" : "key, but no secret_key_file"),
        lacks_key ? "Add the public key that `hgros-keygen` has printed."
                  : "Name the file that `hgros-keygen` has written on that host.");
  }
}

void RobotDraft::CheckHosts() const {
  const RobotHost* home = nullptr;
  for (const RobotHost& host : robot_.hosts) {
    if (host.key.empty() != robot_.hosts.front().key.empty()) {
      faults_.Report(ConfigError("The host " + yaml::Quoted(host.key.empty() ? host.name : robot_.hosts.front().name) +
                                     " has no key, but others have one.",
                                 host.at, "Give all hosts a key, or none."));
    }
    if (!host.home) continue;
    if (home != nullptr) {
      faults_.Report(
          ConfigError("Two hosts are home: " + yaml::Quoted(home->name) + " and " + yaml::Quoted(host.name) + ".",
                      host.at, "Keep `home: true` at the one where `hgros run` is started."));
    }
    home = &host;
  }
}

// Each process of a host has a port of its own, and so has each program that says what it exchanges.
void RobotDraft::CheckPorts() const {
  const auto end_of = [this](const RobotHost& host) {
    const std::string name = host.home ? std::string() : host.name;
    const auto processes = std::ranges::count(robot_.processes, name, &RobotProcess::host);
    const auto programs = std::ranges::count_if(
        robot_.programs, [&](const RobotProgram& one) { return one.host == name && one.declares(); });
    return host.port + std::max(1, static_cast<int>(processes + programs));
  };
  for (auto second = robot_.hosts.begin(); second != robot_.hosts.end(); ++second) {
    for (auto first = robot_.hosts.begin(); first != second; ++first) {
      const int port = std::max(first->port, second->port);
      if (first->address != second->address || port >= std::min(end_of(*first), end_of(*second))) continue;
      faults_.Report(ConfigError("The hosts " + yaml::Quoted(first->name) + " and " + yaml::Quoted(second->name) +
                                     " have the same address, " + second->address + ", and both use its port " +
                                     std::to_string(port) + ".",
                                 second->at, "Correct the address of one, or give it another `port`."));
    }
  }
}

void RobotDraft::ReadHostOf(const Section& section, RobotUnit& unit) const {
  section.Read("host", [&](const Value& value) {
    const std::string& name = value.Text("the name of a host");
    std::vector<std::string> names;
    for (const RobotHost& one : robot_.hosts) {
      names.push_back(one.name);
      if (one.name != name) continue;
      unit.host = one.home ? std::string() : name;
      return;
    }
    const std::string nearest = NearestName(name, names);
    value.Fail("is " + yaml::Quoted(name) + ", which is no host of the robot",
               nearest.empty() ? "Add it to hosts: `hosts: {NAME: {address: ADDRESS}}`."
                               : "Did you mean \"" + nearest + "\"?");
  });
}

}  // namespace hgros
