#include "node_params.hpp"

#include <algorithm>

#include <hgros/base/names.hpp>

namespace slam2d {
namespace {

std::vector<std::string> PathsOf(const hgros::ParamServer& server) {
  std::vector<std::string> paths;
  for (const hgros::ParamDeclaration& one : server.Declarations()) paths.push_back(one.path);
  return paths;
}

}  // namespace

std::string UnknownParam(const std::string& path, const std::vector<std::string>& known) {
  const std::string nearest = hgros::NearestName(path, known);
  return "There is no parameter " + path + "." + (nearest.empty() ? "" : " Did you mean " + nearest + "?");
}

DeclaredParams::DeclaredParams(std::string_view prefix, const hgros::ParamSources& sources, Console& console)
    : prefix_(hgros::ParamPath::Parse(prefix)),
      server_(sources, console.log()),
      validating_(server_.AddValidator("", [this](const hgros::ParamEvent& event) { return Fault(event); })),
      telling_(server_.OnChange(prefix, [this, &console](const hgros::ParamEvent& event) {
        for (const hgros::ParamPath& path : event.paths) {
          const hgros::ParamView value = event.after.At(path);
          if (!path.Overlaps(prefix_) || !value.exists()) continue;
          console.Say(path.ToString() + " is " + value.node()->text + " from the next scan on.");
        }
      })) {}

std::optional<std::string> DeclaredParams::Fault(const hgros::ParamEvent& event) const {
  const std::vector<std::string> known = PathsOf(server_);
  for (const hgros::ParamPath& path : event.paths) {
    const hgros::ParamView value = event.after.At(path);
    const std::string text = path.ToString();
    if (!value.exists() || std::ranges::count(known, text) != 0) continue;
    if (path.Overlaps(prefix_) || value.node()->origin.at_run_time) return UnknownParam(text, known);
  }
  return std::nullopt;
}

}  // namespace slam2d
