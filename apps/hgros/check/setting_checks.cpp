// Settings that do not fit each other: time, domains, heartbeats, transports.
#include <algorithm>
#include <string>

#include "check/deployment.hpp"
#include "hgros/base/names.hpp"

namespace hgros::cli {
namespace {

bool Discovers(const DescribedProcess& process) {
  const DiscoveryConfig& discovery = process.config.discovery;
  return (discovery.local || discovery.lan) && discovery.domain != "none";
}

// A process that others can reach only through endpoints gets the clock through an endpoint, or publishes it.
void CheckClock(const DescribedProcess& process, FileFindings& findings) {
  const bool has_it = PassesAny(process.subscribers, "clock") || PassesAny(process.publishers, "clock");
  if (!process.config.simulated_time || Discovers(process) || has_it || process.subscribers.empty()) return;
  findings.push_back({Severity::kFault, "clock", process.PlaceOf({"time"}),
                      process.name + " follows simulated time, but the channel clock can enter nowhere.",
                      "Add clock at " + LineOf(process.subscribers.front().list) + ".", "clock",
                      process.subscribers.front().list});
}

void CheckDomains(const DescribedProcess& a, const DescribedProcess& b, FileFindings& findings) {
  if (!Discovers(a) || !Discovers(b) || !DifferByATypingError(a.config.discovery.domain, b.config.discovery.domain)) {
    return;
  }
  findings.push_back({Severity::kWarning,
                      "domain",
                      b.PlaceOf({"discovery", "domain"}),
                      b.name + " is in the domain " + b.config.discovery.domain + " and " + a.name + " in " +
                          a.config.discovery.domain + ", so they do not find each other.",
                      "Give both one domain.",
                      {},
                      a.PlaceOf({"discovery", "domain"})});
}

void CheckHeartbeats(const DescribedProcess& one, const DescribedProcess& peer, FileFindings& findings) {
  if (peer.config.peer_timeout_ms > one.config.heartbeat_ms) return;
  findings.push_back({Severity::kFault,
                      "heartbeat",
                      one.PlaceOf({"network", "heartbeat_ms"}),
                      one.name + " sends a heartbeat every " + std::to_string(one.config.heartbeat_ms) + " ms, but " +
                          peer.name + " declares it gone after " + std::to_string(peer.config.peer_timeout_ms) + " ms.",
                      "Set network.peer_timeout_ms of " + peer.name + " to several heartbeats.",
                      {},
                      peer.PlaceOf({"network", "peer_timeout_ms"})});
}

bool AllowsNetwork(const TransportKeys& transports) {
  return !transports || std::ranges::find(*transports, "zmq") != transports->end();
}

// A channel in the list of an endpoint that may not use the network.
void CheckTransports(const DescribedProcess& process, FileFindings& findings) {
  for (const auto* side : {&process.publishers, &process.subscribers}) {
    for (const DescribedEndpoint& endpoint : *side) {
      for (const auto& [name, position] : endpoint.channels) {
        const auto rule = process.config.channels.find(name);
        if (rule == process.config.channels.end() || AllowsNetwork(rule->second.transports)) continue;
        findings.push_back(
            {Severity::kFault, "transport", position,
             name + " is listed at " + endpoint.text + ", but channels." + name + ".transports does not allow zmq.",
             "Remove it here, or add zmq there.", name, process.PlaceOf({"channels", name, "transports"})});
      }
    }
  }
}

}  // namespace

void CheckSettings(const Deployment& deployment, FileFindings& findings) {
  for (const DescribedProcess& process : deployment.processes) {
    CheckClock(process, findings);
    CheckTransports(process, findings);
  }
  for (auto b = deployment.processes.begin(); b != deployment.processes.end(); ++b) {
    for (auto a = deployment.processes.begin(); a != b; ++a) CheckDomains(*a, *b, findings);
  }
  for (const DescribedLink& link : deployment.links) {
    if (link.publishers.size() != 1) continue;
    CheckHeartbeats(*link.subscriber.process, *link.publishers.front().process, findings);
    CheckHeartbeats(*link.publishers.front().process, *link.subscriber.process, findings);
  }
}

}  // namespace hgros::cli
