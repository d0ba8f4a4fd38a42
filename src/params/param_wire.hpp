#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <hgros/Params.pb.h>

#include "hgros/params/param_server.hpp"

// Parameters as messages.
namespace hgros::param_wire {

struct Channels {
  // Throws Error if `name` gives invalid channel names.
  explicit Channels(std::string_view name);
  std::string ask;
  std::string answer;
  std::string state;
};

void WriteValues(const ParamView& root, ParamsState& state);
// Throws ConfigError or ParamError, with `name` in place of a file name.
[[nodiscard]] ParamNodePtr ReadValues(const ParamsState& state, const std::string& name);

void WriteDeclarations(const std::vector<ParamDeclaration>& declarations, ParamsState& state);
[[nodiscard]] std::vector<ParamDeclaration> ReadDeclarations(const ParamsState& state);

void WriteChanges(const std::vector<ParamChange>& changes, ParamsQuestion& question);
// Throws ConfigError or ParamError.
[[nodiscard]] std::vector<ParamChange> ReadChanges(const ParamsQuestion& question);

}  // namespace hgros::param_wire
