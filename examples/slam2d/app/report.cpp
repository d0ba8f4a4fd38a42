#include "report.hpp"

#include <algorithm>
#include <array>
#include <cinttypes>
#include <cstdio>
#include <numbers>
#include <string>
#include <vector>

#include "channels.hpp"

namespace slam2d {
namespace {

constexpr std::array kShownChannels{kScan, kPreChannel, kNextChannel, kMapState};

std::string Text(std::string_view text) { return std::string(text); }

std::string Duration(std::int64_t ns) {
  char text[32];
  const double value = static_cast<double>(ns);
  if (ns < 1'000) {
    std::snprintf(text, sizeof text, "%" PRId64 " ns", ns);
  } else if (ns < 1'000'000) {
    std::snprintf(text, sizeof text, "%.1f us", value * 1e-3);
  } else if (ns < 1'000'000'000) {
    std::snprintf(text, sizeof text, "%.1f ms", value * 1e-6);
  } else {
    std::snprintf(text, sizeof text, "%.2f s", value * 1e-9);
  }
  return text;
}

std::string Name(hgros::Executor::Kind kind) {
  switch (kind) {
    case hgros::Executor::Kind::kTbb: return "tbb";
    case hgros::Executor::Kind::kInline: return "inline";
    case hgros::Executor::Kind::kDedicated: return "dedicated";
  }
  return "unknown";
}

std::vector<const hgros::NodeSnapshot*> ShownNodes(const hgros::GraphSnapshot& graph) {
  std::vector<const hgros::NodeSnapshot*> nodes;
  for (const std::string_view name : kShownChannels) {
    for (const hgros::ChannelSnapshot& channel : graph.channels) {
      if (channel.name != name) continue;
      for (const hgros::NodeSnapshot& node : channel.nodes) nodes.push_back(&node);
    }
  }
  return nodes;
}

// Null if no scan was processed.
const msg::LogTime* LogTimeOf(const Report& report) {
  if (report.written && report.written->scans > 0) return &report.written->log_time;
  return report.done && report.done->scans() > 0 ? &report.done->log_time() : nullptr;
}

// Names are aligned left, numbers right.
void PrintTable(const std::vector<std::vector<std::string>>& rows, std::size_t names) {
  std::vector<std::size_t> widths(rows.front().size(), 0);
  for (const auto& row : rows) {
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  for (const auto& row : rows) {
    std::string line;
    for (std::size_t i = 0; i < row.size(); ++i) {
      const std::string blanks(widths[i] - row[i].size(), ' ');
      line += (i == 0 ? "" : "  ") + (i < names ? row[i] + blanks : blanks + row[i]);
    }
    line.erase(line.find_last_not_of(' ') + 1);
    std::printf("%s\n", line.c_str());
  }
}

void PrintNodes(const Report& report) {
  std::vector<std::vector<std::string>> rows{
      {"node", "channel", "executor", "messages", "dropped", "wait p50", "wait p99", "run p50", "run p99"}};
  if (report.scans_sent) {
    rows.push_back(
        {"source", "-> " + Text(kScan), "own thread", std::to_string(*report.scans_sent), "0", "-", "-", "-", "-"});
  }
  for (const hgros::NodeSnapshot* node : ShownNodes(report.graph)) {
    rows.push_back({node->name, node->channel, Name(node->executor.kind()), std::to_string(node->run),
                    std::to_string(node->dropped), Duration(node->queue_wait.Quantile(0.5)),
                    Duration(node->queue_wait.Quantile(0.99)), Duration(node->run_time.Quantile(0.5)),
                    Duration(node->run_time.Quantile(0.99))});
  }
  PrintTable(rows, 3);
}

}  // namespace

void PrintText(const Report& report) {
  if (const auto& written = report.written) {
    std::printf("map         %s, %.1f m x %.1f m, cells of %.2f m\n", written->map_file.c_str(), written->width_m,
                written->height_m, written->cell_size_m);
    std::printf("odometry    %s, with the path by odometry alone in red\n", written->odometry_file.c_str());
    std::printf("trajectory  %s, %" PRIu64 " poses\n", written->trajectory_file.c_str(), written->scans);
    std::printf("speed       %.2f s, %.0f scans/s\n", written->seconds,
                written->seconds > 0.0 ? static_cast<double>(written->scans) / written->seconds : 0.0);
  }
  if (const msg::LogTime* time = LogTimeOf(report)) {
    std::printf("log time    %.1f s .. %.1f s", time->first_seconds(), time->last_seconds());
    const double duration = time->last_seconds() - time->first_seconds();
    if (report.written && report.written->seconds > 0.0) {
      std::printf(", at %.4g times real time", duration / report.written->seconds);
    }
    std::printf("\n");
  }
  if (report.done) {
    std::printf("hashes      map %016" PRIx64 ", trajectory %016" PRIx64 "\n", report.done->map_hash(),
                report.done->trajectory_hash());
  }
  if (const auto& error = report.relations_error) {
    constexpr double kDegrees = 180.0 / std::numbers::pi;
    std::printf(
        "relations   %zu compared, %zu without poses: %.4f m +- %.4f m (at most %.3f m), %.3f deg +- %.3f deg\n",
        error->relations, error->unmatched, error->mean_translation_m, error->std_translation_m,
        error->max_translation_m, error->mean_rotation_rad * kDegrees, error->std_rotation_rad * kDegrees);
  }
  std::printf("\n");
  PrintNodes(report);
}

void PrintJson(const Report& report) {
  if (report.done) {
    std::printf("{\"kind\": \"result\", \"scans\": %" PRIu64 ", \"map_hash\": \"%016" PRIx64
                "\", \"trajectory_hash\": \"%016" PRIx64 "\"",
                report.done->scans(), report.done->map_hash(), report.done->trajectory_hash());
    if (const msg::LogTime* time = LogTimeOf(report)) {
      std::printf(", \"log_first_s\": %.3f, \"log_last_s\": %.3f", time->first_seconds(), time->last_seconds());
    }
    if (report.written) {
      std::printf(", \"width_m\": %.2f, \"height_m\": %.2f, \"seconds\": %.3f", report.written->width_m,
                  report.written->height_m, report.written->seconds);
    }
    std::printf("}\n");
  }
  if (const auto& error = report.relations_error) {
    std::printf(
        "{\"kind\": \"relations\", \"relations\": %zu, \"unmatched\": %zu, \"mean_translation_m\": %.9g, "
        "\"std_translation_m\": %.9g, \"mean_rotation_rad\": %.9g, \"std_rotation_rad\": %.9g}\n",
        error->relations, error->unmatched, error->mean_translation_m, error->std_translation_m,
        error->mean_rotation_rad, error->std_rotation_rad);
  }
  for (const hgros::NodeSnapshot* node : ShownNodes(report.graph)) {
    std::printf(
        "{\"kind\": \"node\", \"node\": \"%s\", \"channel\": \"%s\", \"executor\": \"%s\", \"messages\": %" PRIu64
        ", \"dropped\": %" PRIu64 ", \"wait_p50\": %" PRId64 ", \"wait_p99\": %" PRId64 ", \"run_p50\": %" PRId64
        ", \"run_p99\": %" PRId64 "}\n",
        node->name.c_str(), node->channel.c_str(), Name(node->executor.kind()).c_str(), node->run, node->dropped,
        node->queue_wait.Quantile(0.5), node->queue_wait.Quantile(0.99), node->run_time.Quantile(0.5),
        node->run_time.Quantile(0.99));
  }
}

}  // namespace slam2d
