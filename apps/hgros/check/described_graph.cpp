#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "check/deployment.hpp"

namespace hgros::cli {
namespace {

constexpr std::string_view kAll = "all channels";  // Without a list, their names are not known.

// Files say which channels of each publisher pass to which process. So each channel of each publisher is one of the
// graph's channels, and what enters a process takes the place of its nodes.
class DescribedGraph {
 public:
  explicit DescribedGraph(const Deployment& deployment) : first_(deployment.processes.data()) {
    for (const DescribedProcess& process : deployment.processes) graph_.processes.push_back({{}, process.name, {}, {}});
    for (const DescribedProcess& process : deployment.processes) {
      for (const DescribedEndpoint& endpoint : process.publishers) {
        for (const auto& [name, position] : endpoint.channels) ChannelOf(name, &process);
        if (endpoint.all_channels) ChannelOf(kAll, &process);
      }
    }
    for (const DescribedLink& link : deployment.links) AddLink(link);
  }

  Hypergraph Take() {
    for (auto& [key, channel] : channels_) graph_.channels.push_back(std::move(channel));
    graph_.Arrange();
    return std::move(graph_);
  }

 private:
  [[nodiscard]] std::size_t PlaceOf(const DescribedProcess* process) const {
    return static_cast<std::size_t>(process - first_);
  }

  Hypergraph::Channel& ChannelOf(std::string_view name, const DescribedProcess* publisher) {
    Hypergraph::Channel& channel = channels_[std::pair(publisher, std::string(name))];
    if (!channel.name.empty()) return channel;
    channel.name = name;
    if (publisher != nullptr) channel.publishers.push_back({PlaceOf(publisher)});
    return channel;
  }

  void AddSubscriber(Hypergraph::Channel& channel, std::size_t process) {
    std::vector<Hypergraph::Node>& nodes = graph_.processes[process].nodes;
    auto node = std::ranges::find(nodes, channel.name, &Hypergraph::Node::name);
    if (node == nodes.end()) node = nodes.insert(nodes.end(), {channel.name, channel.name});
    const auto place = static_cast<std::size_t>(node - nodes.begin());
    if (std::ranges::find(channel.subscribers, process, &Hypergraph::Subscriber::process) == channel.subscribers.end())
      channel.subscribers.push_back({process, place, {"ZeroMQ"}});
  }

  void AddLink(const DescribedLink& link) {
    const std::size_t process = PlaceOf(link.subscriber.process);
    const DescribedEndpoint& from = *link.subscriber.endpoint;
    std::set<std::string_view> lonely;
    for (const auto& [name, position] : from.channels) lonely.insert(name);
    for (const DescribedLink::End& end : link.publishers) {
      const DescribedEndpoint& to = *end.endpoint;
      for (const std::string_view name : PassingNames(from, to)) {
        AddSubscriber(ChannelOf(name, end.process), process);
        lonely.erase(name);
      }
      if (!IsOnlyOnItsHost(from.text)) graph_.processes[PlaceOf(end.process)].host = HostOf(from.text);
    }
    for (const std::string_view name : lonely) AddSubscriber(ChannelOf(name, nullptr), process);
  }

  [[nodiscard]] static std::set<std::string_view> PassingNames(const DescribedEndpoint& from,
                                                               const DescribedEndpoint& to) {
    std::set<std::string_view> names;
    for (const auto& [name, position] : from.channels) {
      if (to.Passes(name)) names.insert(name);
    }
    for (const auto& [name, position] : to.channels) {
      if (from.Passes(name)) names.insert(name);
    }
    if (from.all_channels && to.all_channels) names.insert(kAll);
    return names;
  }

  const DescribedProcess* first_;
  Hypergraph graph_;
  std::map<std::pair<const DescribedProcess*, std::string>, Hypergraph::Channel> channels_;
};

}  // namespace

Hypergraph Deployment::Graph() const { return DescribedGraph(*this).Take(); }

}  // namespace hgros::cli
