#include "parameters.hpp"

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include <hgros/params/param_server.hpp>

namespace slam2d {
namespace {

template <class Options>
void AddPaths(const std::string& prefix, std::vector<std::string>& paths) {
  Options options;
  ForEachTunable(prefix, options,
                 [&paths](const std::string& path, const auto&, const auto&) { paths.push_back(path); });
}

std::vector<std::string> AllPaths() {
  std::vector<std::string> paths;
  AddPaths<SourceTuning>(kTunedSource.prefix, paths);
  AddPaths<MatcherOptions>(kTunedMatcher.prefix, paths);
  AddPaths<MapOptions>(kTunedMapper.prefix, paths);
  return paths;
}

// Parameters below `slam` and those on the command line are for the demo. Others in the files and in the environment
// may be for other programs.
void RequireKnown(const hgros::ParamView& view, const std::vector<std::string>& known, const Plan& plan) {
  if (view.is_null()) return;
  if (view.node()->kind == hgros::ParamNode::Kind::kMap) {
    for (const std::string& key : view.keys()) RequireKnown(view[key], known, plan);
    return;
  }
  const std::string path = view.path().ToString();
  const std::string said = view.node()->origin.ToString();
  const bool on_command_line = said.starts_with("--");
  if (std::ranges::count(known, path) == 0) {
    if (!on_command_line && !path.starts_with("slam.") && path != "slam") return;
    throw hgros::ParamError(UnknownParam(path, known), said, "slam2d --list-params lists those of a running demo.");
  }
  const char* node = TunedNodeOf(path)->node;
  if (on_command_line && !plan.Runs(node)) {
    throw hgros::ParamError(path + " is for the process that runs the " + node + "; this one runs only " +
                                Enumerate({plan.nodes.begin(), plan.nodes.end()}) + ".",
                            said);
  }
}

}  // namespace

const TunedNode* TunedNodeOf(std::string_view path) {
  const auto node = std::ranges::find_if(kTunedNodes, [path](const TunedNode& one) {
    const std::string_view prefix = one.prefix;
    return path.starts_with(prefix) && path.substr(prefix.size()).starts_with(".");
  });
  return node == kTunedNodes.end() ? nullptr : &*node;
}

Parameters::Parameters(const Plan& plan, const hgros::ParamSources& sources, Console& console) {
  RequireKnown(hgros::ParamServer(sources, console.log()).Snapshot(), AllPaths(), plan);
  if (plan.Runs("source")) source.emplace(kTunedSource.prefix, sources, console);
  if (plan.Runs("matcher")) matcher.emplace(kTunedMatcher.prefix, sources, console);
  if (plan.Runs("mapper")) mapper.emplace(kTunedMapper.prefix, sources, console);
}

}  // namespace slam2d
