#include "launch/robot_graph.hpp"

#include <algorithm>
#include <set>
#include <string>
#include <string_view>

#include "hgros/base/names.hpp"
#include "hgros/session/clock_publisher.hpp"
#include "hgros/tf/transforms.hpp"

namespace hgros::cli {
namespace {

std::string InQuotes(const std::string& name) { return "\"" + name + "\""; }

template <class Map>
std::string NearestKey(const std::string& name, const Map& map) {
  std::vector<std::string> keys;
  for (const auto& [key, ends] : map) {
    if (key != name) keys.push_back(key);
  }
  const std::string nearest = NearestName(name, keys);
  return nearest.empty() ? std::string() : "Did you mean " + InQuotes(nearest) + "?";
}

template <class Map>
const typename Map::mapped_type& EndsOf(const Map& map, const std::string& channel) {
  static const typename Map::mapped_type none;
  const auto found = map.find(channel);
  return found == map.end() ? none : found->second;
}

bool IsOfTransforms(std::string_view channel) {
  return channel == kTransformsChannel || channel == kStaticTransformsChannel;
}

bool FindEachOther(const RobotProcess& first, const RobotProcess& second) {
  if (first.host != second.host) return true;  // By endpoints.
  const Config& one = first.config;
  const Config& other = second.config;
  return one.discovery.local && other.discovery.local && one.discovery.domain == other.discovery.domain &&
         one.discovery.only.empty() && other.discovery.only.empty();
}

}  // namespace

RobotGraph::RobotGraph(const RobotFile& robot, std::vector<ComponentDescription> descriptions) : robot_(robot) {
  for (const ComponentDescription& one : descriptions) {
    const RobotComponent* component = robot.FindComponent(one.name);
    if (component == nullptr) continue;
    const bool moves = !one.state.empty();
    moving_ = moving_ || moves;
    if (one.transforms) transforming_.push_back({component, nullptr, {}, moves});
    for (const ComponentChannel& input : one.inputs)
      inputs_[input.channel].push_back({component, nullptr, input.type, moves});
    for (const ComponentChannel& output : one.outputs) {
      outputs_[output.channel].push_back({component, nullptr, output.type, moves});
    }
    for (const ComponentService& service : one.services) {
      served_[service.service].push_back({{component, nullptr, service.request, moves}, service.reply});
    }
    for (const ComponentService& call : one.calls) {
      called_[call.service].push_back({{component, nullptr, call.request, moves}, call.reply});
    }
  }
  for (const RobotProgram& one : robot.programs) Add(one);
}

void RobotGraph::Add(const RobotProgram& program) {
  const End end{nullptr, &program, {}, false};
  for (const std::string& channel : program.subscribes) inputs_[channel].push_back(end);
  for (const std::string& channel : program.publishes) outputs_[channel].push_back(end);
  for (const std::string& service : program.serves) served_[service].push_back({end, {}});
  for (const std::string& service : program.calls) called_[service].push_back({end, {}});
}

std::vector<RobotFinding> RobotGraph::Check() const {
  std::vector<RobotFinding> findings;
  CheckChannels(findings);
  CheckServices(findings);
  return findings;
}

bool RobotGraph::IsListed(const End& end, const std::string& channel) const {
  const RobotProcess* process = robot_.FindProcess(end.unit());
  return process != nullptr && std::ranges::any_of(process->config.subscribers, [&](const EndpointConfig& endpoint) {
           return std::ranges::binary_search(endpoint.channels, channel);
         });
}

bool RobotGraph::MayComeFromOutside(const End& end) const {
  if (!std::ranges::all_of(robot_.programs, &RobotProgram::declares)) return true;
  const RobotProcess* process = robot_.FindProcess(end.unit());
  return process != nullptr && std::ranges::any_of(process->config.subscribers, &EndpointConfig::all_channels);
}

void RobotGraph::CheckChannels(std::vector<RobotFinding>& findings) const {
  for (const auto& [channel, ends] : inputs_) {
    const auto publishers = outputs_.find(channel);
    for (const End& end : ends) {
      const std::string& name = end.name();
      if (publishers == outputs_.end()) {
        const std::string nearest = NearestKey(channel, outputs_);
        if (IsListed(end, channel) || (IsOfTransforms(channel) && !transforming_.empty())) continue;
        if (nearest.empty() && MayComeFromOutside(end)) continue;
        findings.push_back({false, end.at(),
                            "No component publishes the channel " + InQuotes(channel) + ", to which " + InQuotes(name) +
                                " subscribes.",
                            nearest, channel});
        continue;
      }
      for (const End& publisher : publishers->second) {
        if (end.type.empty() || publisher.type.empty() || end.type == publisher.type) continue;
        findings.push_back({true, end.at(),
                            "The channel " + InQuotes(channel) + " has two types: " + InQuotes(publisher.name()) +
                                " publishes " + publisher.type + ", and " + InQuotes(name) + " subscribes to " +
                                end.type + ".",
                            "Rename one of them with remap."});
      }
    }
  }
  for (const auto& [channel, ends] : outputs_) {
    for (const End& end : ends) {
      if (end.type.empty() || ends.front().type.empty() || end.type == ends.front().type) continue;
      findings.push_back({true, end.at(),
                          "The channel " + InQuotes(channel) + " has two types: " + InQuotes(ends.front().name()) +
                              " publishes " + ends.front().type + ", and " + InQuotes(end.name()) + " publishes " +
                              end.type + ".",
                          "Rename one of them with remap."});
    }
  }
}

void RobotGraph::CheckServices(std::vector<RobotFinding>& findings) const {
  for (const auto& [service, servers] : served_) {
    for (std::size_t i = 1; i < servers.size(); ++i) {
      findings.push_back({true, servers[i].request.at(),
                          "The service " + InQuotes(service) + " is served twice: by " +
                              InQuotes(servers[0].request.name()) + " and by " + InQuotes(servers[i].request.name()) +
                              ".",
                          "Rename one of them with remap."});
    }
  }
  for (const auto& [service, callers] : called_) {
    const auto served = served_.find(service);
    for (const Pair& caller : callers) {
      const std::string& name = caller.request.name();
      if (served == served_.end()) {
        findings.push_back({false, caller.request.at(),
                            "No component serves " + InQuotes(service) + ", which " + InQuotes(name) + " calls.",
                            NearestKey(service, served_), service});
        continue;
      }
      const Pair& server = served->second.front();
      if (server.request.program != nullptr || caller.request.program != nullptr) continue;  // Of any type.
      if (server.request.type == caller.request.type && server.reply == caller.reply) continue;
      findings.push_back({true, caller.request.at(),
                          "The service " + InQuotes(service) + " takes " + server.request.type + " and returns " +
                              server.reply + " in " + InQuotes(server.request.name()) + ", but " + InQuotes(name) +
                              " sends " + caller.request.type + " and expects " + caller.reply + ".",
                          "Rename one of them with remap."});
    }
  }
}

std::map<std::string, std::size_t> RobotGraph::SubscribersOf(const RobotProcess& process) const {
  std::map<std::string, std::size_t> subscribers;
  for (const auto& [channel, found] : FindSubscribers(process)) subscribers[channel] = found.count();
  return subscribers;
}

std::map<std::string, RobotGraph::Subscribers> RobotGraph::FindSubscribersOfMoved(std::string_view component,
                                                                                  const RobotProcess& process) const {
  std::map<std::string, Subscribers> subscribers = FindSubscribers(process, component);
  std::erase_if(subscribers, [&](const auto& one) {
    return std::ranges::none_of(outputs_.at(one.first), [&](const End& end) { return end.name() == component; });
  });
  return subscribers;
}

std::map<std::string, RobotGraph::Subscribers> RobotGraph::FindSubscribers(const RobotProcess& process,
                                                                           std::string_view moved) const {
  const auto place = [&](const End& end) -> const std::string& {
    return end.name() == moved ? process.name : end.unit();
  };
  std::map<std::string, Subscribers> subscribers;
  for (const auto& [channel, ends] : outputs_) {
    const bool here = std::ranges::any_of(ends, [&](const End& end) { return place(end) == process.name; });
    const auto inputs = inputs_.find(channel);
    if (!here || inputs == inputs_.end()) continue;
    const bool closed = std::ranges::binary_search(process.config.closed_channels, channel);
    Subscribers found;
    for (const End& end : inputs->second) {
      if (place(end) == process.name) {
        found.here += closed ? 0 : 1;
      } else if (const RobotProcess* other = robot_.FindProcess(place(end));
                 other != nullptr && FindEachOther(process, *other)) {
        found.elsewhere.insert(other->name);
      }
    }
    if (found.count() > 0) subscribers[channel] = std::move(found);
  }
  return subscribers;
}

bool RobotGraph::Meet(std::string_view one, std::string_view other) const {
  return std::ranges::any_of(outputs_, [&](const auto& output) {
    const auto inputs = inputs_.find(output.first);
    if (inputs == inputs_.end()) return false;
    const auto has = [](const std::vector<End>& ends, std::string_view name) {
      return std::ranges::any_of(ends, [name](const End& end) { return end.name() == name; });
    };
    const auto leads = [&](std::string_view from, std::string_view to) {
      return has(output.second, from) && has(inputs->second, to);
    };
    return leads(one, other) || leads(other, one);
  });
}

bool RobotGraph::CanRunIn(const End& end, std::string_view unit) const {
  return end.unit() == unit || (end.moves && robot_.FindProcess(unit) != nullptr);
}

std::set<std::string> RobotGraph::ChannelsFrom(std::string_view from, std::string_view to) const {
  const auto leads = [&](const End& first, const End& second, std::string_view one, std::string_view other) {
    if (first.name() == second.name()) return false;  // It does not run in both.
    return CanRunIn(first, one) && CanRunIn(second, other);
  };
  const auto any_leads = [&](const std::vector<End>& ends, const std::vector<End>& inputs) {
    return std::ranges::any_of(ends, [&](const End& output) {
      return std::ranges::any_of(inputs, [&](const End& input) { return leads(output, input, from, to); });
    });
  };
  std::set<std::string> channels;
  const RobotProcess* follower = robot_.FindProcess(to);
  for (const auto& [channel, ends] : outputs_) {
    if (channel == kClockChannel && follower != nullptr &&
        follower->config.simulated_time) {  // Its session subscribes.
      const auto publishes = [&](const End& end) { return CanRunIn(end, from); };
      if (std::ranges::any_of(ends, publishes)) channels.insert(channel);
    }
    if (any_leads(ends, EndsOf(inputs_, channel))) channels.insert(channel);
  }
  for (const std::string& channel : {std::string(kTransformsChannel), std::string(kStaticTransformsChannel)}) {
    if (any_leads(transforming_, transforming_) || any_leads(transforming_, EndsOf(inputs_, channel)) ||
        any_leads(EndsOf(outputs_, channel), transforming_)) {
      channels.insert(channel);
    }
  }
  for (const auto& [service, servers] : served_) {
    const auto callers = called_.find(service);
    if (callers == called_.end()) continue;
    for (const Pair& server : servers) {
      for (const Pair& caller : callers->second) {
        const End& one = server.request;
        const End& other = caller.request;
        if (leads(one, other, from, to) || leads(one, other, to, from)) channels.insert("hgros/call/" + service);
      }
    }
  }
  return channels;
}

}  // namespace hgros::cli
