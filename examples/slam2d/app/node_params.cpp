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

DeclaredParams::DeclaredParams(const hgros::ParamSources& sources, Console& console)
    : server_(sources, console.log()),
      validating_(server_.AddValidator("slam",
                                       [this](const hgros::ParamEvent& event) -> std::optional<std::string> {
                                         const std::vector<std::string> known = PathsOf(server_);
                                         for (const hgros::ParamPath& path : event.paths) {
                                           const std::string text = path.ToString();
                                           if (event.after.At(path).exists() && std::ranges::count(known, text) == 0) {
                                             return UnknownParam(text, known);
                                           }
                                         }
                                         return std::nullopt;
                                       })),
      telling_(server_.OnChange("slam", [&console](const hgros::ParamEvent& event) {
        for (const hgros::ParamPath& path : event.paths) {
          const hgros::ParamView value = event.after.At(path);
          if (value.exists()) console.Say(path.ToString() + " is " + value.node()->text + " from the next scan on.");
        }
      })) {}

}  // namespace slam2d
