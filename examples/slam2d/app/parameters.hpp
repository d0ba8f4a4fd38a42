#pragma once

#include <array>
#include <optional>
#include <string_view>
#include <tuple>

#include <hgros/params/param_sources.hpp>

#include "../nodes/node_params.hpp"
#include "../tunables.hpp"
#include "console.hpp"
#include "plan.hpp"

namespace slam2d {

/// Settings for playing the log.
struct SourceTuning {
  double rate = 0.0;
};

template <>
struct Tunables<SourceTuning> {
  static constexpr std::tuple kAll{
      Tunable{"rate", &SourceTuning::rate, "times real time, by the log's stamps; 0: as fast as possible", "", 0, 1e6},
  };
};

/// A node with parameters: those below `prefix`. The node offers them to others under the name `offered`, in any
/// process.
struct TunedNode {
  const char* node;
  const char* prefix;
  const char* offered;
};
inline constexpr TunedNode kTunedSource{"source", "slam.source", "slam2d/source"};
inline constexpr TunedNode kTunedMatcher{"matcher", "slam.matcher", "slam2d/matcher"};
inline constexpr TunedNode kTunedMapper{"mapper", "slam.map", "slam2d/mapper"};
inline constexpr std::array kTunedNodes{kTunedSource, kTunedMatcher, kTunedMapper};

/// The node with the parameter `path`, which need not exist. Null if it belongs to no node.
[[nodiscard]] const TunedNode* TunedNodeOf(std::string_view path);

/// The parameters of the nodes that run in this process.
///
/// Errors: throws ParamError or ConfigError naming the parameter and its origin, if a parameter does not exist, has an
/// invalid value, or is on the command line of a process that does not run its node.
struct Parameters {
  Parameters(const Plan& plan, const hgros::ParamSources& sources, Console& console);

  std::optional<NodeParams<SourceTuning>> source;
  std::optional<NodeParams<MatcherOptions>> matcher;
  std::optional<NodeParams<MapOptions>> mapper;
};

}  // namespace slam2d
