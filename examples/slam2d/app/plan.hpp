#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <vector>

namespace slam2d {

inline constexpr const char* kNodeNames[] = {"source", "matcher", "mapper", "writer"};

/// Which nodes run in this process.
struct Plan {
  std::set<std::string> nodes{std::begin(kNodeNames), std::end(kNodeNames)};
  bool standby = false;  ///< The mapper takes over from one in another process.

  [[nodiscard]] bool Runs(const std::string& node) const { return nodes.contains(node); }
};

/// The key of the plan in the configuration files: `slam2d: {nodes: [mapper], standby: true}`.
inline constexpr const char* kPlanSection = "slam2d";

/// Reads the plan from the files' `slam2d` sections, merged. Without such a section, all nodes run here.
///
/// Errors: throws std::runtime_error with file, line and the known names.
[[nodiscard]] Plan ReadPlan(const std::vector<std::filesystem::path>& files);

/// A node gets its input from the node that publishes it. If both run in this process, but the channel is closed here,
/// it never gets any; then another process must run it. Removes such nodes from the plan. Returns one sentence for
/// each.
[[nodiscard]] std::vector<std::string> LeaveToOthers(Plan& plan, const std::vector<std::string>& closed_channels);

/// "a, b and c".
[[nodiscard]] std::string Enumerate(const std::vector<std::string>& names);

}  // namespace slam2d
