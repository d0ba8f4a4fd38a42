#include "plan.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "channels.hpp"

namespace slam2d {
namespace {

[[noreturn]] void Refuse(const std::filesystem::path& file, const YAML::Mark& mark, const std::string& sentence) {
  throw std::runtime_error(file.string() + ":" + std::to_string(mark.line + 1) + ":" + std::to_string(mark.column + 1) +
                           ": " + sentence);
}

template <class T>
T ValueOf(const std::filesystem::path& file, const YAML::Node& node, const std::string& what) {
  try {
    return node.as<T>();
  } catch (const YAML::Exception&) {
    Refuse(file, node.Mark(), what);
  }
}

void AddNodes(const std::filesystem::path& file, const YAML::Node& list, std::set<std::string>& nodes) {
  const std::vector<std::string> known(std::begin(kNodeNames), std::end(kNodeNames));
  if (!list.IsSequence() || list.size() == 0) {
    Refuse(file, list.Mark(), "slam2d.nodes must be a list of nodes: " + Enumerate(known) + ".");
  }
  for (const YAML::Node& entry : list) {
    const auto name = ValueOf<std::string>(file, entry, "slam2d.nodes must be a list of names.");
    if (std::ranges::find(known, name) == known.end()) {
      Refuse(file, entry.Mark(), "There is no node \"" + name + "\". There are " + Enumerate(known) + ".");
    }
    if (!nodes.insert(name).second) Refuse(file, entry.Mark(), "The node \"" + name + "\" is listed twice.");
  }
}

}  // namespace

Plan ReadPlan(const std::vector<std::filesystem::path>& files) {
  std::set<std::string> nodes;
  Plan plan;
  for (const std::filesystem::path& file : files) {
    YAML::Node document;
    try {
      document = YAML::LoadFile(file.string());
    } catch (const YAML::BadFile&) {
      throw std::runtime_error("The configuration " + file.string() + " cannot be opened. Name a YAML file.");
    } catch (const YAML::ParserException& error) {
      Refuse(file, error.mark, error.msg + ".");
    }
    if (!document.IsMap() || !document[kPlanSection]) continue;
    const YAML::Node section = document[kPlanSection];
    if (!section.IsMap()) Refuse(file, section.Mark(), "slam2d must be a map with the keys nodes and standby.");
    for (const auto& entry : section) {
      const auto key = ValueOf<std::string>(file, entry.first, "slam2d must be a map with the keys nodes and standby.");
      if (key == "nodes") {
        AddNodes(file, entry.second, nodes);
      } else if (key == "standby") {
        plan.standby = ValueOf<bool>(file, entry.second, "slam2d.standby must be true or false.");
      } else {
        Refuse(file, entry.first.Mark(), "Unknown key \"" + key + "\" in slam2d. Known keys: nodes, standby.");
      }
    }
  }
  if (!nodes.empty()) plan.nodes = nodes;
  if (plan.standby && plan.nodes != std::set<std::string>{"mapper"}) {
    throw std::runtime_error("slam2d.standby is for a process that runs the mapper alone: nodes: [mapper].");
  }
  return plan;
}

std::vector<std::string> LeaveToOthers(Plan& plan, const std::vector<std::string>& closed_channels) {
  struct Link {
    const char* from;
    std::string_view channel;
    const char* to;
  };
  constexpr Link kLinks[] = {{"source", kScan, "matcher"},
                             {"matcher", kPreChannel, "mapper"},
                             {"mapper", kNextChannel, "matcher"},
                             {"mapper", kNextChannel, "writer"}};
  std::vector<std::string> sentences;
  std::set<std::string> kept = plan.nodes;
  for (const Link& link : kLinks) {
    if (!plan.Runs(link.from) || std::ranges::find(closed_channels, link.channel) == closed_channels.end()) continue;
    if (kept.erase(link.to) == 0) continue;
    sentences.push_back("The channel " + std::string(link.channel) +
                        " is closed here (data_graph: close_channels), so the " + link.to +
                        " of another process is used.");
  }
  plan.nodes = std::move(kept);
  return sentences;
}

std::string Enumerate(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (i > 0) text += i + 1 == names.size() ? " and " : ", ";
    text += names[i];
  }
  return text;
}

}  // namespace slam2d
