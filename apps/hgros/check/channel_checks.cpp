// Lists of channels at the two ends of a connection.
#include <algorithm>
#include <initializer_list>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "check/deployment.hpp"
#include "hgros/base/names.hpp"
#include "robot/overview.hpp"

namespace hgros::cli {
namespace {

std::string Listed(const std::vector<const DescribedProcess*>& processes) {
  std::string text;
  for (std::size_t i = 0; i < processes.size(); ++i) {
    text += (i == 0 ? "" : i + 1 == processes.size() ? " and " : ", ") + processes[i]->name;
  }
  return text;
}

// The names that are probably meant by others. Comparing all names of long lists takes long: then it finds none for
// some.
class MeantNames {
 public:
  // One of `list` that `other` does not have. Empty: none.
  [[nodiscard]] std::string Of(std::string_view name, const DescribedEndpoint& list, const DescribedEndpoint& other) {
    const auto [entry, is_new] = candidates_.try_emplace({&list, &other});
    std::vector<std::string>& names = entry->second;
    if (is_new) {
      for (const auto& [channel, position] : list.channels) {
        if (!other.Passes(channel)) names.push_back(channel);
      }
    }
    if (!MayCompare(name, names)) return {};
    std::string nearest = NearestName(name, names);
    if (!nearest.empty()) found_.emplace(&list, nearest);
    return nearest;
  }
  // Whether Of() has found this channel of `list` for another name. Needs no comparison.
  [[nodiscard]] bool WasFound(const std::string& channel, const DescribedEndpoint& list) const {
    return found_.contains({&list, channel});
  }
  // One that differs by a typing error. Empty: none.
  [[nodiscard]] std::string Alike(std::string_view name, const std::set<std::string>& names) {
    if (!MayCompare(name, names)) return {};
    const auto near =
        std::ranges::find_if(names, [&name](const std::string& one) { return DifferByATypingError(name, one); });
    return near == names.end() ? std::string() : *near;
  }

 private:
  [[nodiscard]] bool MayCompare(std::string_view name, const auto& names) {
    const std::size_t steps = names.size() * (name.size() + 1) * (name.size() + 1);  // Names are of similar lengths.
    const bool may = steps <= steps_left_;
    steps_left_ -= may ? steps : 0;
    return may;
  }

  std::map<std::pair<const DescribedEndpoint*, const DescribedEndpoint*>, std::vector<std::string>> candidates_;
  std::set<std::pair<const DescribedEndpoint*, std::string>> found_;
  std::size_t steps_left_ = 100'000'000;  // Less than a second.
};

// Channels that a subscriber lets enter, but no publisher at that endpoint lets leave.
void CheckEntering(const DescribedLink& link, MeantNames& meant, FileFindings& findings) {
  if (link.publishers.empty()) return;
  for (const auto& [channel, position] : link.subscriber.endpoint->channels) {
    std::vector<const DescribedProcess*> refusing;
    std::string nearest;
    for (const DescribedLink::End& end : link.publishers) {
      if (end.endpoint->Passes(channel)) break;
      refusing.push_back(end.process);
      if (nearest.empty()) nearest = meant.Of(channel, *end.endpoint, *link.subscriber.endpoint);
    }
    if (refusing.size() < link.publishers.size()) continue;
    const FilePosition& list = link.publishers.front().endpoint->list;
    findings.push_back(
        {Severity::kFault, "channel", position,
         channel + " may enter " + link.subscriber.process->name + " from " + link.subscriber.endpoint->text +
             ", but " + Listed(refusing) + (refusing.size() == 1 ? " does" : " do") + " not let it leave there.",
         nearest.empty() ? "Add it at " + LineOf(list) + ", or remove it here." : "Did you mean " + nearest + "?",
         channel, list});
  }
}

// Whether the process subscribes to the channel, as its settings show, but none of its endpoints lets it enter.
bool Wants(const DescribedProcess& process, const std::string& channel) {
  if (PassesAny(process.subscribers, channel) || PassesAny(process.publishers, channel)) return false;
  const auto first_node = process.config.nodes.lower_bound(channel + "#");
  const bool has_node = first_node != process.config.nodes.end() && first_node->first.starts_with(channel + "#");
  const auto settings = process.config.channels.find(channel);
  const bool has_queue = settings != process.config.channels.end() && settings->second.queue;
  return has_node || has_queue || (process.config.simulated_time && channel == "clock");
}

// Channels that leave at an endpoint to which processes connect, but that none of these lets enter.
void CheckLeaving(const Deployment& deployment, const DescribedProcess& process, const DescribedEndpoint& endpoint,
                  MeantNames& meant, FileFindings& findings) {
  std::vector<const DescribedLink*> links;
  for (const DescribedLink& link : deployment.links) {
    if (std::ranges::find(link.publishers, &endpoint, &DescribedLink::End::endpoint) != link.publishers.end()) {
      links.push_back(&link);
    }
  }
  for (const auto& entry : endpoint.channels) {
    const std::string& channel = entry.first;
    const bool enters = std::ranges::any_of(
        links, [&](const DescribedLink* link) { return link->subscriber.endpoint->Passes(channel); });
    const auto wanting = std::ranges::find_if(
        links, [&](const DescribedLink* link) { return Wants(*link->subscriber.process, channel); });
    // The other end of a misspelling is told by CheckEntering().
    const bool is_told =
        meant.WasFound(channel, endpoint) || std::ranges::any_of(links, [&](const DescribedLink* link) {
          return !meant.Of(channel, *link->subscriber.endpoint, endpoint).empty();
        });
    if (links.empty() || is_told || (wanting == links.end() && (enters || IsInternal(channel)))) continue;
    std::vector<const DescribedProcess*> refusing;
    for (const DescribedLink* link : links) refusing.push_back(link->subscriber.process);
    const DescribedLink& where = wanting == links.end() ? *links.front() : **wanting;
    const std::string leaves =
        channel + " leaves " + process.name + " at " + where.subscriber.endpoint->text + ", but ";
    const FilePosition& list = where.subscriber.endpoint->list;
    if (wanting != links.end()) {
      findings.push_back({Severity::kFault, "channel", list,
                          leaves + where.subscriber.process->name + ", which uses it, does not let it enter.",
                          "Add it at " + LineOf(list) + ".", channel, entry.second});
    } else {
      findings.push_back({Severity::kWarning, "channel", list,
                          leaves + Listed(refusing) + (refusing.size() == 1 ? " does" : " do") + " not let it enter.",
                          "Add it at " + LineOf(list) + ".", channel, entry.second});
    }
  }
}

// The channel of the other direction, if the channel is useless without it.
std::string BackChannelOf(const std::string& channel) {
  constexpr std::string_view kParams = "params/";
  constexpr std::string_view kAnswer = "/answer";
  if (!ServiceOf(channel).empty()) return channel;
  if (!channel.starts_with(kParams) || !channel.ends_with(kAnswer)) return {};
  return channel.substr(0, channel.size() - kAnswer.size()) + "/ask";
}

// A service or parameters that pass in one direction only.
void CheckAnswers(const Deployment& deployment, const DescribedLink& link, FileFindings& findings) {
  if (link.publishers.size() != 1) return;
  const DescribedProcess& process = *link.publishers.front().process;
  const DescribedEndpoint& endpoint = *link.publishers.front().endpoint;
  for (const auto& [channel, position] : link.subscriber.endpoint->channels) {
    const std::string back = BackChannelOf(channel);
    if (back.empty() || !endpoint.channels.contains(channel) || PassesAny(process.subscribers, back)) continue;
    const bool is_sent = std::any_of(
        deployment.processes.begin(), deployment.processes.end(),
        [&](const DescribedProcess& other) { return &other != &process && PassesAny(other.publishers, back); });
    if (!is_sent) continue;
    const std::string leaves = channel + " leaves " + process.name + ", but ";
    findings.push_back({Severity::kWarning, "service", endpoint.channels.find(channel)->second,
                        back == channel ? leaves + "cannot enter it: a service needs both directions."
                                        : leaves + back + " cannot enter it: parameters need both.",
                        "Add " + back + " to a list under network.subscribers there.", channel, position});
  }
}

// Settings of channels that no list has, if a list has nearly the same name.
void CheckNames(const Deployment& deployment, MeantNames& meant, FileFindings& findings) {
  std::set<std::string> listed;
  for (const DescribedProcess& process : deployment.processes) {
    for (const auto* side : {&process.publishers, &process.subscribers}) {
      for (const DescribedEndpoint& endpoint : *side) {
        for (const auto& [channel, position] : endpoint.channels) listed.insert(channel);
      }
    }
  }
  for (const DescribedProcess& process : deployment.processes) {
    // Finding a place takes long, so only what is reported is looked for.
    const auto check = [&](const std::string& name, std::initializer_list<std::string_view> keys) {
      if (listed.contains(name)) return;
      const std::string near = meant.Alike(name, listed);
      if (near.empty()) return;
      findings.push_back({Severity::kWarning, "name", process.PlaceOf(keys),
                          "No list of channels has " + name + ", but one has " + near + ".",
                          "Did you mean " + near + "?", name});
    };
    for (const auto& [name, settings] : process.config.channels) check(name, {"channels", name});
    for (const std::string& name : process.config.closed_channels) {
      check(name, {"data_graph", "close_channels"});
    }
  }
}

}  // namespace

void CheckChannelLists(const Deployment& deployment, FileFindings& findings) {
  MeantNames meant;
  CheckNames(deployment, meant, findings);
  for (const DescribedLink& link : deployment.links) {
    CheckEntering(link, meant, findings);
    CheckAnswers(deployment, link, findings);
  }
  for (const DescribedProcess& process : deployment.processes) {
    for (const DescribedEndpoint& endpoint : process.publishers)
      CheckLeaving(deployment, process, endpoint, meant, findings);
  }
}

}  // namespace hgros::cli
