#include "check/deployment.hpp"

#include <algorithm>
#include <filesystem>

namespace hgros::cli {
namespace {

constexpr std::string_view kTcp = "tcp://";

bool IsLoopback(std::string_view host) { return host == "localhost" || host == "[::1]" || host.starts_with("127."); }

bool CanReach(std::string_view subscriber, std::string_view publisher) {
  if (!subscriber.starts_with(kTcp) || !publisher.starts_with(kTcp)) return subscriber == publisher;
  const std::string_view from = HostOf(subscriber);
  const std::string_view to = HostOf(publisher);
  if (PortOf(publisher).empty() || PortOf(subscriber) != PortOf(publisher)) return false;
  if (IsWildcard(to) || from == to) return true;
  if (IsLoopback(from) || IsLoopback(to)) return IsLoopback(from) && IsLoopback(to);
  return !IsAddress(from) || !IsAddress(to);  // A name can mean any address.
}

// Whether a file of the process, or its folder, is called like the host.
bool IsNamedLike(const DescribedProcess& process, std::string_view host) {
  return !host.empty() && std::ranges::any_of(process.documents, [host](const yaml::Document& document) {
    const std::filesystem::path path(document.name());
    return path.stem() == host || path.parent_path().filename() == host;
  });
}

template <typename Keep>
void KeepIfAny(std::vector<DescribedLink::End>& ends, Keep keep) {
  if (std::ranges::none_of(ends, keep)) return;
  std::erase_if(ends, [&keep](const DescribedLink::End& end) { return !keep(end); });
}

}  // namespace

std::string_view HostOf(std::string_view endpoint) {
  if (!endpoint.starts_with(kTcp)) return {};
  endpoint.remove_prefix(kTcp.size());
  return endpoint.substr(0, endpoint.rfind(':'));
}

std::string_view PortOf(std::string_view endpoint) {
  if (!endpoint.starts_with(kTcp)) return {};
  const std::string_view port = endpoint.substr(endpoint.rfind(':') + 1);
  return port == "*" ? std::string_view() : port;
}

bool IsAddress(std::string_view host) {
  return host.starts_with('[') || host.find_first_not_of("0123456789.") == std::string_view::npos;
}

bool IsWildcard(std::string_view host) { return host == "*" || host == "[::]"; }

bool IsOnlyOnItsHost(std::string_view endpoint) { return !endpoint.starts_with(kTcp) || IsLoopback(HostOf(endpoint)); }

Deployment::Deployment(const std::vector<DescribedProcess>& described) : processes(described) {
  for (const DescribedProcess& subscriber : processes) {
    for (const DescribedEndpoint& from : subscriber.subscribers) {
      std::vector<DescribedLink::End> ends;
      for (const DescribedProcess& publisher : processes) {
        if (&publisher == &subscriber) continue;
        for (const DescribedEndpoint& to : publisher.publishers) {
          if (CanReach(from.text, to.text)) ends.push_back({&publisher, &to});
        }
      }
      KeepIfAny(ends, [&](const DescribedLink::End& end) { return HostOf(end.endpoint->text) == HostOf(from.text); });
      KeepIfAny(ends, [&](const DescribedLink::End& end) { return IsNamedLike(*end.process, HostOf(from.text)); });
      links.push_back({{&subscriber, &from}, std::move(ends)});
    }
  }
}

}  // namespace hgros::cli
