#pragma once

#include "session/domain_fixture.hpp"

namespace hgros::test {

/// A publishing session, and one that observes it over the transport that the parameter names: sharedmemory, ipc or
/// tcp.
class ObservedFixture : public DomainFixture, public testing::WithParamInterface<std::string> {
 protected:
  [[nodiscard]] std::string PublisherYaml() const {
    if (GetParam() == "sharedmemory") return "";
    const std::string at = GetParam() == "ipc" ? bus_.Endpoint("robot") : "tcp://127.0.0.1:*";
    return "network: {publisher: {ip: '" + at + "'}}\ndiscovery: {local: false}\n";
  }
  [[nodiscard]] std::string ObserverYaml() const {
    return GetParam() == "sharedmemory" ? "" : "discovery: {local: false}\n";
  }
  /// Connects the two if the transport needs an endpoint.
  void Connect(Session& from, const Session& publisher) const {
    for (const std::string& endpoint : publisher.PublisherEndpoints()) {
      from.AddSubscriberEndpoint({endpoint, {}, true});
    }
  }
  void Begin() {
    robot.emplace(PublisherYaml(), "robot");
    observer.emplace(ObserverYaml(), "observer");
    Connect(*observer->session, *robot->session);
  }

  /// The channel as the observer knows it.
  [[nodiscard]] std::optional<KnownChannel> Known(const std::string& name) const {
    for (const KnownChannel& channel : (*observer)->Channels()) {
      if (channel.name == name) return channel;
    }
    return std::nullopt;
  }
  [[nodiscard]] bool IsPublished(const std::string& name) const {
    const auto channel = Known(name);
    return channel && !channel->publishers.empty();
  }

  Bus bus_;
  std::optional<Robot> robot;
  std::optional<Robot> observer;
};

}  // namespace hgros::test
