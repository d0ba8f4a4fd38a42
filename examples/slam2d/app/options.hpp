#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <variant>
#include <vector>

#include <hgros/params/param_sources.hpp>

#include "plan.hpp"

namespace slam2d {

struct Options {
  std::optional<std::filesystem::path> log;  ///< Without it: the simulated building.
  std::optional<double> rate;
  std::optional<std::uint64_t> scans;
  std::filesystem::path out = "slam2d_out";
  std::vector<std::filesystem::path> configs;
  std::optional<std::uint64_t> move_mapper_at;
  std::optional<std::filesystem::path> relations;
  std::chrono::seconds patience{30};  ///< How long to wait for other processes.
  hgros::ParamSources params;         ///< Files, environment and command line, --rate included.
  // Requests to a running demo. The other options are for a demo in this process.
  std::vector<hgros::ParamOverride> set_params;
  bool list_params = false;
  bool save_map = false;
  bool quiet = false;
  bool json = false;

  [[nodiscard]] bool asks() const { return save_map || list_params || !set_params.empty(); }

  static constexpr std::uint64_t kSimulatedScans = 1500;
};

/// The options, or the exit code after --help or after an error in the command line, which has been printed.
[[nodiscard]] std::variant<Options, int> ReadCommandLine(int argc, char** argv);

/// Throws std::runtime_error with a sentence if an option belongs to a node of another process.
void CheckAgainst(const Plan& plan, const Options& options);

}  // namespace slam2d
