// Lists of channels at the two ends of a connection.
#include <algorithm>
#include <string>
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

std::string LineOf(const FilePosition& at) { return at.file + ":" + std::to_string(at.line); }

// The name of the list that is probably meant by `name`: one that the other list does not have. Empty: none.
std::string Meant(std::string_view name, const DescribedEndpoint& list, const DescribedEndpoint& other) {
  std::vector<std::string> candidates;
  for (const auto& [channel, position] : list.channels) {
    if (!other.Passes(channel)) candidates.push_back(channel);
  }
  return NearestName(name, candidates);
}

// Channels that a subscriber lets enter, but no publisher at that endpoint lets leave.
void CheckEntering(const DescribedLink& link, FileFindings& findings) {
  if (link.publishers.empty()) return;
  for (const auto& [channel, position] : link.subscriber.endpoint->channels) {
    std::vector<const DescribedProcess*> refusing;
    std::string nearest;
    for (const DescribedLink::End& end : link.publishers) {
      if (end.endpoint->Passes(channel)) break;
      refusing.push_back(end.process);
      if (nearest.empty()) nearest = Meant(channel, *end.endpoint, *link.subscriber.endpoint);
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

// Whether the files of the process mention a channel that none of its endpoints lets enter.
bool Wants(const DescribedProcess& process, const std::string& channel) {
  if (std::ranges::any_of(process.subscribers, [&](const DescribedEndpoint& one) { return one.Passes(channel); })) {
    return false;
  }
  const auto first_node = process.config.nodes.lower_bound(channel + "#");
  const bool has_node = first_node != process.config.nodes.end() && first_node->first.starts_with(channel + "#");
  return has_node || process.config.channels.contains(channel) || (process.config.simulated_time && channel == "clock");
}

// Channels that leave at an endpoint to which processes connect, but that none of these lets enter.
void CheckLeaving(const Deployment& deployment, const DescribedProcess& process, const DescribedEndpoint& endpoint,
                  FileFindings& findings) {
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
    const bool is_told = std::ranges::any_of(links, [&](const DescribedLink* link) {
      return !Meant(channel, *link->subscriber.endpoint, endpoint).empty();
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

// A service or parameters that pass in one direction only.
void CheckAnswers(const Deployment& deployment, const DescribedLink& link, FileFindings& findings) {
  for (const auto& entry : link.subscriber.endpoint->channels) {
    const std::string& channel = entry.first;
    const std::string_view service = ServiceOf(channel);
    if (service.empty() || link.publishers.size() != 1) continue;
    const DescribedLink::End& publisher = link.publishers.front();
    if (!publisher.endpoint->channels.contains(channel)) continue;
    const bool comes_back = std::ranges::any_of(publisher.process->subscribers,
                                                [&](const DescribedEndpoint& one) { return one.Passes(channel); });
    const bool is_sent = std::ranges::any_of(deployment.processes, [&](const DescribedProcess& process) {
      return &process != publisher.process &&
             std::ranges::any_of(process.publishers, [&](const DescribedEndpoint& one) { return one.Passes(channel); });
    });
    if (comes_back || !is_sent) continue;
    findings.push_back({Severity::kWarning, "service", publisher.endpoint->channels.find(channel)->second,
                        "The service " + std::string(service) + " needs both directions, but " + channel +
                            " only leaves " + publisher.process->name + ".",
                        "Add it to a list under network.subscribers there.", channel, entry.second});
  }
}

}  // namespace

void CheckChannelLists(const Deployment& deployment, FileFindings& findings) {
  for (const DescribedLink& link : deployment.links) {
    CheckEntering(link, findings);
    CheckAnswers(deployment, link, findings);
  }
  for (const DescribedProcess& process : deployment.processes) {
    for (const DescribedEndpoint& endpoint : process.publishers) CheckLeaving(deployment, process, endpoint, findings);
  }
}

}  // namespace hgros::cli
