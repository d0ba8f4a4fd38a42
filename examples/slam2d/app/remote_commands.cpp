#include "remote_commands.hpp"

#include <cstdio>
#include <string>
#include <vector>

#include <hgros/hgros.hpp>
#include <hgros/params/remote_params.hpp>

#include "channels.hpp"
#include "console.hpp"
#include "ending.hpp"
#include "messages.hpp"
#include "parameters.hpp"

namespace slam2d {
namespace {

void Complain(const std::string& sentence) { std::fprintf(stderr, "slam2d: %s\n", sentence.c_str()); }

std::string Quoted(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c < ' ' ? ' ' : c;
  }
  return quoted + '"';
}

void Print(const hgros::ParamDeclaration& one, const std::string& value, bool json) {
  const hgros::ParamInfo& info = one.info;
  if (json) {
    std::printf(
        "{\"kind\": \"param\", \"path\": %s, \"value\": %s, \"unit\": %s, \"least\": %g, \"most\": %g, "
        "\"read_only\": %s, \"description\": %s}\n",
        Quoted(one.path).c_str(), Quoted(value).c_str(), Quoted(info.unit).c_str(), info.least.value_or(0),
        info.most.value_or(0), info.read_only ? "true" : "false", Quoted(info.description).c_str());
    return;
  }
  const std::string shown = info.unit.empty() ? value : value + " " + info.unit;
  std::printf("%-40s %-12s %s (%g to %g%s)\n", one.path.c_str(), shown.c_str(), info.description.c_str(),
              info.least.value_or(0), info.most.value_or(0), info.read_only ? ", read-only" : "");
}

// Lists the parameters node by node. Unreachable nodes are skipped if at least one node is reachable.
int ListParams(hgros::Session& session, bool json) {
  std::string refusal;
  bool any = false;
  for (const TunedNode& node : kTunedNodes) {
    hgros::RemoteParams remote(session, node.offered);
    const auto declared = remote.Describe();
    const auto values = remote.Snapshot();
    if (!declared.ok() || !values.ok()) {
      refusal = declared.ok() ? values.refusal : declared.refusal;
      continue;
    }
    any = true;
    for (const hgros::ParamDeclaration& one : *declared) {
      const hgros::ParamView value = values->At(one.path);
      if (value.exists()) Print(one, value.node()->text, json);
    }
  }
  if (any) return kSuccess;
  Complain("The parameters were not listed: " + refusal);
  return kFailure;
}

// Sets those of one node together, or none of them.
int SetParams(hgros::Session& session, const std::vector<hgros::ParamOverride>& wanted) {
  for (const hgros::ParamOverride& one : wanted) {
    if (TunedNodeOf(one.path) != nullptr) continue;
    Complain("There is no parameter " + one.path +
             "; the demo's parameters begin with slam.source, slam.matcher or slam.map.");
    return kBadInput;
  }
  for (const TunedNode& node : kTunedNodes) {
    std::vector<hgros::ParamChange> changes;
    for (const hgros::ParamOverride& one : wanted) {
      if (TunedNodeOf(one.path)->node != node.node) continue;
      changes.push_back({one.path, hgros::ParamNode::Text(one.value, false)});
    }
    if (changes.empty()) continue;
    hgros::RemoteParams remote(session, node.offered);
    if (const auto there = remote.Describe(); !there.ok()) {
      Complain("The parameters of the " + std::string(node.node) + " were not set: " + there.refusal);
      return kFailure;
    }
    if (const hgros::ParamResult result = remote.Change(changes); !result.ok()) {
      Complain(result.refusal);
      return kBadInput;
    }
    for (const hgros::ParamChange& change : changes) {
      std::printf("%s is %s\n", change.path.c_str(), change.value->text.c_str());
    }
  }
  return kSuccess;
}

int SaveMap(hgros::Session& session, std::chrono::seconds patience) {
  const auto saved = session.Call<msg::SaveMap, msg::MapSaved>(kSaveMap, msg::SaveMap(), patience).Wait();
  if (!saved) {
    Complain("The map was not saved: " + saved.failure().reason);
    return kFailure;
  }
  std::printf("map         %s, after %llu scans\ntrajectory  %s\nlog time    %.1f s .. %.1f s\n",
              saved->map_file().c_str(), static_cast<unsigned long long>(saved->scans()),
              saved->trajectory_file().c_str(), saved->log_time().first_seconds(), saved->log_time().last_seconds());
  if (saved->has_robot()) {
    std::printf("robot       x = %.2f m, y = %.2f m, heading = %.2f rad\n", saved->robot().x(), saved->robot().y(),
                saved->robot().theta());
  }
  return kSuccess;
}

}  // namespace

int AskRunningDemo(const Options& options, const hgros::Config& config) {
  Console console(options.quiet);
  hgros::Session session(config, {.name = "slam2d", .log = console.log()});
  int exit_code = SetParams(session, options.set_params);
  if (exit_code == kSuccess && options.list_params) exit_code = ListParams(session, options.json);
  if (exit_code == kSuccess && options.save_map) exit_code = SaveMap(session, options.patience);
  return exit_code;
}

}  // namespace slam2d
