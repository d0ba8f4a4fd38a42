// CURVE keys of the two ends of a connection. No sentence shows a key.
#include <algorithm>
#include <string>

#include "check/deployment.hpp"
#include "hgros/base/error.hpp"

namespace hgros::cli {
namespace {

bool IsEncrypted(const DescribedProcess& process) { return !process.config.security.public_key.empty(); }

FilePosition KeysOf(const DescribedProcess& process) { return process.PlaceOf({"network", "security"}); }

void CheckLink(const DescribedLink& link, FileFindings& findings) {
  if (link.publishers.size() != 1) return;
  const DescribedProcess& from = *link.subscriber.process;
  const DescribedProcess& to = *link.publishers.front().process;
  const std::string connects = from.name + " connects to " + to.name + " at " + link.subscriber.endpoint->text;
  if (IsEncrypted(from) != IsEncrypted(to)) {
    const DescribedProcess& with = IsEncrypted(from) ? from : to;
    const DescribedProcess& without = IsEncrypted(from) ? to : from;
    findings.push_back({Severity::kFault,
                        "key",
                        without.PlaceOf({"network"}),
                        connects + ", but " + without.name + " has no keys, and " + with.name + " has.",
                        "Give both network.security, or none.",
                        {},
                        KeysOf(with)});
    return;
  }
  if (!IsEncrypted(from)) return;
  const SecurityConfig& client = from.config.security;
  const SecurityConfig& server = to.config.security;
  const auto expected = client.servers.find(link.subscriber.endpoint->text);
  if (expected != client.servers.end() && expected->second != server.public_key) {
    findings.push_back({Severity::kFault,
                        "key",
                        from.PlaceOf({"network", "security", "servers"}),
                        connects + ", but the key under servers is not the public key of " + to.name + ".",
                        "Write the public key of " + to.name + ".",
                        {},
                        to.PlaceOf({"network", "security", "public_key"})});
  }
  if (std::ranges::find(server.allowed_clients, client.public_key) == server.allowed_clients.end()) {
    const bool has_list = !server.allowed_clients.empty();
    findings.push_back({Severity::kFault,
                        "key",
                        has_list ? to.PlaceOf({"network", "security", "allowed_clients"}) : KeysOf(to),
                        connects + ", but the public key of " + from.name + " is not under allowed_clients.",
                        "Add it.",
                        {},
                        from.PlaceOf({"network", "security", "public_key"})});
  }
}

}  // namespace

void CheckKeys(const Deployment& deployment, FileFindings& findings) {
  for (const DescribedLink& link : deployment.links) CheckLink(link, findings);
}

}  // namespace hgros::cli
