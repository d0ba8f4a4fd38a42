// Endpoints that are bound twice or that nobody reaches.
#include <algorithm>
#include <numeric>

#include "check/deployment.hpp"
#include "robot/overview.hpp"

namespace hgros::cli {
namespace {

// Processes that are on one host for certain, because one connects to the other over the loopback or a socket file.
class Hosts {
 public:
  explicit Hosts(const Deployment& deployment) : first_(deployment.processes.data()), of_(deployment.processes.size()) {
    std::iota(of_.begin(), of_.end(), std::size_t{0});
    for (const DescribedLink& link : deployment.links) {
      if (link.publishers.size() != 1 || !IsOnlyOnItsHost(link.subscriber.endpoint->text)) continue;
      const std::size_t from = HostOfProcess(link.subscriber.process);
      const std::size_t to = HostOfProcess(link.publishers.front().process);
      std::ranges::replace(of_, to, from);
    }
  }
  [[nodiscard]] bool Same(const DescribedProcess& a, const DescribedProcess& b) const {
    return HostOfProcess(&a) == HostOfProcess(&b);
  }

 private:
  [[nodiscard]] std::size_t HostOfProcess(const DescribedProcess* process) const {
    return of_[static_cast<std::size_t>(process - first_)];
  }

  const DescribedProcess* first_;
  std::vector<std::size_t> of_;
};

// Whether one host cannot bind both.
bool Clash(std::string_view a, std::string_view b) {
  if (a == b) return HostOf(a).empty() || !PortOf(a).empty();
  return !PortOf(a).empty() && PortOf(a) == PortOf(b) && (IsWildcard(HostOf(a)) || IsWildcard(HostOf(b)));
}

// An address that only one host has.
bool NamesOneHost(std::string_view endpoint) {
  const std::string_view host = HostOf(endpoint);
  return !host.empty() && IsAddress(host) && !IsOnlyOnItsHost(endpoint) && !IsWildcard(host);
}

void CheckTwice(const Deployment& deployment, FileFindings& findings) {
  const Hosts hosts(deployment);
  for (auto second = deployment.processes.begin(); second != deployment.processes.end(); ++second) {
    for (auto first = deployment.processes.begin(); first != second; ++first) {
      for (const DescribedEndpoint& a : first->publishers) {
        for (const DescribedEndpoint& b : second->publishers) {
          if (!Clash(a.text, b.text)) continue;
          const bool certain = hosts.Same(*first, *second) || (a.text == b.text && NamesOneHost(a.text));
          const std::string both = first->name + " and " + second->name + " both bind " + b.text;
          findings.push_back(
              {certain ? Severity::kFault : Severity::kNote,
               "endpoint",
               b.at,
               certain ? both + (a.text == b.text ? "" : " (one as " + a.text + ")") +
                             " on one host, which only one of them can."
                       : both + ": that works only on two hosts.",
               "Give each its own. If one program loads both files, check " + first->name + "+" + second->name + ".",
               {},
               a.at});
        }
      }
    }
  }
}

// A channel that has a name in both lists, and is not the library's.
std::string SharedChannel(const DescribedEndpoint& a, const DescribedEndpoint& b) {
  for (const auto& [name, position] : a.channels) {
    if (b.channels.contains(name) && !IsInternal(name)) return name;
  }
  return {};
}

// Says why a subscriber endpoint leads nowhere, if the files show what was meant.
void CheckLonely(const Deployment& deployment, const DescribedLink& link, FileFindings& findings) {
  const DescribedEndpoint& from = *link.subscriber.endpoint;
  for (const DescribedProcess& process : deployment.processes) {
    if (&process == link.subscriber.process) continue;
    for (const DescribedEndpoint& to : process.publishers) {
      const bool own_host_only = !PortOf(from.text).empty() && PortOf(from.text) == PortOf(to.text) &&
                                 !IsOnlyOnItsHost(from.text) && IsOnlyOnItsHost(to.text);
      if (own_host_only) {
        findings.push_back({Severity::kWarning,
                            "endpoint",
                            to.at,
                            link.subscriber.process->name + " connects to " + from.text + ", but " + process.name +
                                " offers this port only to its own host, at " + to.text + ".",
                            "Write tcp://*:" + std::string(PortOf(to.text)) + ".",
                            {},
                            from.at});
        return;
      }
    }
  }
  for (const DescribedProcess& process : deployment.processes) {
    if (&process == link.subscriber.process) continue;
    for (const DescribedEndpoint& to : process.publishers) {
      const bool is_used = std::ranges::any_of(deployment.links, [&to](const DescribedLink& other) {
        return std::ranges::find(other.publishers, &to, &DescribedLink::End::endpoint) != other.publishers.end();
      });
      const std::string channel = SharedChannel(from, to);
      if (is_used || channel.empty()) continue;
      findings.push_back({Severity::kWarning, "endpoint", from.at,
                          link.subscriber.process->name + " connects to " + from.text + " for " + channel +
                              ", where none of the files binds an endpoint, and nobody connects to " + to.text +
                              ", where " + process.name + " offers it.",
                          "Make the two endpoints the same.", channel, to.at});
      return;
    }
  }
}

}  // namespace

void CheckEndpoints(const Deployment& deployment, FileFindings& findings) {
  CheckTwice(deployment, findings);
  for (const DescribedLink& link : deployment.links) {
    if (link.publishers.empty()) CheckLonely(deployment, link, findings);
  }
}

}  // namespace hgros::cli
