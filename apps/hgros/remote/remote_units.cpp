#include "remote/remote_units.hpp"

#include <stdlib.h>

#include <set>
#include <utility>

#include "remote/library_build.hpp"
#include "remote/ssh_relay.hpp"

namespace hgros::cli {
namespace {

std::string IdText(const std::string& id) { return id.empty() ? "no build id" : "build id " + id; }

}  // namespace

RemoteUnits::RemoteUnits(const RobotFile& robot, const yaml::Document& document,
                         std::map<std::string, std::string> networks,
                         const std::vector<ComponentDescription>& descriptions, const ComponentCatalog& catalog)
    : robot_(robot), file_(document.name()), text_(document.ToYaml()), networks_(std::move(networks)) {
  std::map<std::filesystem::path, LibraryBuild> builds;
  for (const RobotComponent& component : robot.components) {
    const std::filesystem::path& file = catalog.Find(component.setup.type).file;
    const auto [build, fresh] = builds.try_emplace(file);
    if (fresh) build->second = BuildOf(file);
    RemoteOrder::Library& library = libraries_[component.setup.name];
    library.set_name(file.filename().string());
    library.set_build(build->second.id);
    library.set_machine(build->second.machine);
    library.set_type(component.setup.type);
  }
  for (const ComponentDescription& one : descriptions) fingerprints_[one.name] = one.fingerprints;
}

RemoteOrder RemoteUnits::StartOf(const RobotUnit& unit) const {
  RemoteOrder order;
  RemoteOrder::Start& start = *order.mutable_start();
  start.set_file(file_);
  start.set_robot(text_);
  start.set_host(unit.host);
  start.set_unit(unit.name);
  if (const char* domain = getenv("HGROS_DOMAIN")) start.set_domain(domain);
  if (const auto found = networks_.find(unit.name); found != networks_.end()) start.set_network(found->second);
  const RobotProcess* process = robot_.FindProcess(unit.name);
  if (process == nullptr) return order;
  start.mutable_components()->Assign(process->components.begin(), process->components.end());
  std::set<std::string> files;
  std::map<std::string, std::uint64_t> fingerprints;
  for (const std::string& name : process->components) {
    const RemoteOrder::Library& library = libraries_.at(name);
    if (files.insert(library.name()).second) *start.add_libraries() = library;
    if (const auto found = fingerprints_.find(name); found != fingerprints_.end()) {
      fingerprints.insert(found->second.begin(), found->second.end());
    }
  }
  for (const auto& [type, fingerprint] : fingerprints) {
    auto& to = *start.add_fingerprints();
    to.set_type(type);
    to.set_value(fingerprint);
  }
  return order;
}

int RemoteUnits::Run(int socket, const RobotUnit& unit, const KeptComponents& kept) const {
  SshRelay relay(socket, *robot_.FindHost(unit.host));
  if (const RobotProcess* process = robot_.FindProcess(unit.name)) {
    for (const std::string& name : process->components) {
      const auto found = kept.find(name);
      if (found == kept.end()) continue;
      RemoteOrder order;
      if (found->second.state != nullptr) {
        *order.mutable_saved() = ReportOf(name, *found->second.state).saved();
        relay.Add(order);
      }
      for (const auto& [path, value] : found->second.params) {
        RunReport::Changed& changed = *order.mutable_changed();
        changed.set_component(name);
        changed.set_path(path);
        changed.set_value(value);
        relay.Add(order);
      }
    }
  }
  relay.Add(StartOf(unit));
  return relay.Run();
}

std::vector<std::string> LibraryDifferences(const RemoteOrder::Start& start,
                                            const std::vector<ComponentDescription>& descriptions,
                                            const ComponentCatalog& catalog) {
  std::vector<std::string> differences;
  for (const RemoteOrder::Library& one : start.libraries()) {
    const std::filesystem::path& file = catalog.Find(one.type()).file;
    const LibraryBuild here = BuildOf(file);
    if (here.machine != one.machine() || here.id == one.build()) continue;
    differences.push_back("The library of " + one.type() + " is another one here: " + file.string() + " has " +
                          IdText(here.id) + ", and where hgros run was started, " + one.name() + " has " +
                          IdText(one.build()) + ".");
  }
  std::set<std::string> told;
  for (const ComponentDescription& component : descriptions) {
    for (const auto& [type, fingerprint] : component.fingerprints) {
      const auto there = std::ranges::find_if(start.fingerprints(),
                                              [&, &wanted = type](const auto& one) { return one.type() == wanted; });
      const bool same = there != start.fingerprints().end() && there->value() == fingerprint;
      if (same || !told.insert(type).second) continue;
      differences.push_back("The message type " + type + " of the component \"" + component.name +
                            "\" has other fields here than where hgros run was started.");
    }
  }
  return differences;
}

}  // namespace hgros::cli
