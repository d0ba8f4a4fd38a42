// Reads the sections discovery and shared_memory.
#include <array>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "config/config_draft.hpp"
#include "hgros/discovery/domain.hpp"
#include "hgros/yaml/quoted.hpp"

namespace hgros {
namespace {

using yaml::Section;
using yaml::Settle;
using yaml::Value;

constexpr std::uint64_t kMostSharedBytes = std::uint64_t{1} << 40U;
constexpr std::int64_t kLongestSpinUs = 1'000'000;
constexpr std::size_t kLongestProcessName = 200;
constexpr std::size_t kLongestInterfaceName = 15;  // IFNAMSIZ - 1: without the final zero.
constexpr std::array kWaits{ShmWait::kSleep, ShmWait::kSpin, ShmWait::kBusy};

// Distinct names, sorted, so that the result does not depend on their order in the file.
std::vector<std::string> ReadNames(const Value& list, std::string_view what, std::size_t longest) {
  std::map<std::string, FilePosition> names;
  const auto read = [&](const Value& item) {
    const std::string& name = item.Text(what);
    if (name.empty() || name.size() > longest) {
      item.Fail("cannot be " + std::string(what), "Use 1 to " + std::to_string(longest) + " bytes.");
    }
    const auto [first, fresh] = names.emplace(name, item.position());
    if (!fresh) {
      item.Fail("is " + yaml::Quoted(name) + ", which the list already has at " + first->second.ToString(),
                "Keep one of them.");
    }
  };
  const std::vector<Value> items = list.List("a list of names");
  for (const Value& item : items) item.faults().Attempt([&] { read(item); });
  std::vector<std::string> sorted;
  for (const auto& [name, position] : names) sorted.push_back(name);
  return sorted;
}

ConfigDraft::NamedSwitch ReadLocal(const Value& local) {
  if (local.kind() == yaml::Node::Kind::kText) return {local.Boolean(), {}};
  if (local.kind() != yaml::Node::Kind::kList) local.FailType("true, false or a list of process names");
  auto names = ReadNames(local, "a process name", kLongestProcessName);
  if (local.List({}).empty()) local.Fail("lists no process", "Write false to switch off discovery on this host.");
  return {true, std::move(names)};
}

ConfigDraft::NamedSwitch ReadLan(const Value& lan) {
  if (lan.kind() == yaml::Node::Kind::kText) return {lan.Boolean(), {}};
  const Section section(lan, "true, false or a map with interfaces", {"interfaces"});
  const Value interfaces = section.Require("interfaces");
  auto names = ReadNames(interfaces, "a network interface name", kLongestInterfaceName);
  if (interfaces.List({}).empty()) lan.Fail("lists no interface", "Write true for all interfaces, or false.");
  return {true, std::move(names)};
}

}  // namespace

void ReadDiscovery(const Value& value, ConfigDraft& draft) {
  const Section section(value, "a map", {"local", "lan", "domain"});
  section.Read("local", [&](const Value& local) { Settle(draft.discovery_local, ReadLocal(local), local); });
  section.Read("lan", [&](const Value& lan) { Settle(draft.discovery_lan, ReadLan(lan), lan); });
  section.Read("domain", [&](const Value& domain) {
    const std::string& name = domain.Text("the name of a domain");
    if (!IsDomain(name)) {
      domain.Fail("is " + yaml::Quoted(name) + ", which cannot name a domain",
                  "Use 1 to 64 letters, digits, '_', '-' and '.', not beginning with a '.', or none for no discovery.");
    }
    Settle(draft.domain, name, domain);
  });
}

void ReadSharedMemory(const Value& value, ConfigDraft& draft) {
  const Section section(value, "a map", {"limit_bytes", "wait", "spin_us"});
  section.Read("limit_bytes", [&](const Value& limit) {
    Settle(draft.shared_memory_limit_bytes, limit.SizeBytes(0, kMostSharedBytes), limit);
  });
  section.Read("wait", [&](const Value& wait) {
    Settle(draft.shared_memory_wait, kWaits.at(wait.Choice({"sleep", "spin", "busy"})), wait);
  });
  section.Read("spin_us", [&](const Value& spin) {
    Settle(draft.shared_memory_spin_us, static_cast<int>(spin.Integer(0, kLongestSpinUs)), spin);
  });
}

void CheckHost(const ConfigDraft& draft) {
  const auto& wait = draft.shared_memory_wait;
  if (draft.shared_memory_spin_us && (!wait || wait->value != ShmWait::kSpin)) {
    draft.faults.Report(
        ConfigError("shared_memory.spin_us applies only with wait: spin, but " +
                        (wait ? "shared_memory.wait at " + wait->position.ToString() + " has another value."
                              : std::string("shared_memory.wait is not set.")),
                    draft.shared_memory_spin_us->position, "Write wait: spin, or remove it."));
  }
  if (draft.discovery_lan && draft.discovery_lan->value.on && draft.secret_key) {
    draft.faults.Report(
        ConfigError("discovery.lan cannot find sessions whose connections are encrypted, as network.security at " +
                        draft.secret_key->position.ToString() + " requires: a beacon does not carry keys.",
                    draft.discovery_lan->position,
                    "Name the endpoints under network.subscribers and their keys under network.security.servers, or "
                    "remove one of the two."));
  }
}

}  // namespace hgros
