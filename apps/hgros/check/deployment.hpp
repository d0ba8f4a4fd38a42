#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

#include "check/described_process.hpp"
#include "check/file_finding.hpp"
#include "robot/hypergraph.hpp"

namespace hgros::cli {

/// A subscriber endpoint, and the publisher endpoints of other processes that it can lead to. More than one: hosts are
/// not known, and several bind that port.
struct DescribedLink {
  struct End {
    const DescribedProcess* process;
    const DescribedEndpoint* endpoint;
  };
  End subscriber;
  std::vector<End> publishers;  ///< Empty: none of the processes binds it.
};

/// The processes that files describe, and how their endpoints lead to each other. Borrows the processes.
struct Deployment {
  explicit Deployment(const std::vector<DescribedProcess>& described);

  const std::vector<DescribedProcess>& processes;
  std::vector<DescribedLink> links;

  [[nodiscard]] Hypergraph Graph() const;
};

/// Whether the endpoint can be reached from its own host only.
[[nodiscard]] bool IsOnlyOnItsHost(std::string_view endpoint);
/// The host of a tcp endpoint; empty: ipc.
[[nodiscard]] std::string_view HostOf(std::string_view endpoint);
/// Whether a host is an address, and no name.
[[nodiscard]] bool IsAddress(std::string_view host);
/// Whether a host means all addresses of the host that binds it.
[[nodiscard]] bool IsWildcard(std::string_view host);
/// The port of a tcp endpoint; empty: ipc, or the system chooses.
[[nodiscard]] std::string_view PortOf(std::string_view endpoint);

/// Each function adds what contradicts.
void CheckEndpoints(const Deployment& deployment, FileFindings& findings);
void CheckChannelLists(const Deployment& deployment, FileFindings& findings);
void CheckKeys(const Deployment& deployment, FileFindings& findings);
void CheckSettings(const Deployment& deployment, FileFindings& findings);

}  // namespace hgros::cli
