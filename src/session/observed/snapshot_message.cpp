#include "hgros/session/snapshot_message.hpp"

#include <algorithm>
#include <ctime>
#include <numeric>

#include "hgros/base/memory_room.hpp"
#include "hgros/clock/time.hpp"
#include "hgros/discovery/announcement.hpp"
#include "session/control/control_desk.hpp"

namespace hgros {
namespace {

constexpr double kMiddle = 0.5;
constexpr double kAlmostAll = 0.99;

const char* NameOf(Executor::Kind kind) {
  switch (kind) {
    case Executor::Kind::kTbb: break;
    case Executor::Kind::kInline: return "inline";
    case Executor::Kind::kDedicated: return "dedicated";
    case Executor::Kind::kPolled: return "polled";
  }
  return "tbb";
}

std::int64_t ProcessCpuTime() {
  timespec time{};
  return clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time) == 0 ? time.tv_sec * 1'000'000'000 + time.tv_nsec : 0;
}

void Fill(Snapshot::Node& message, const NodeSnapshot& node) {
  message.set_name(node.name);
  message.set_serial(node.invoke == Invoke::kSerial);
  message.set_lossless(node.queue.lossless());
  message.set_queue_depth(node.queue.depth());
  message.set_received(node.received);
  message.set_dropped(node.dropped);
  message.set_run(node.run);
  message.set_failed(node.failed);
  message.set_refused(node.refused);
  message.set_handed_over(node.handed_over);
  message.set_queued(node.queued);
  message.set_wait_p50_ns(node.queue_wait.Quantile(kMiddle));
  message.set_wait_p99_ns(node.queue_wait.Quantile(kAlmostAll));
  message.set_run_p50_ns(node.run_time.Quantile(kMiddle));
  message.set_run_p99_ns(node.run_time.Quantile(kAlmostAll));
  message.set_run_sum_ns(
      static_cast<std::uint64_t>(node.run_time.mean_ns() * static_cast<double>(node.run_time.count())));
  message.set_executor(NameOf(node.executor.kind()));
  message.set_fifo_priority(static_cast<std::uint32_t>(node.executor.fifo_priority()));
  for (const ChainAges& ages : node.ages) {
    Snapshot::ChainAge& one = *message.add_ages();
    one.set_origin(ages.origin);
    one.set_count(ages.age.count());
    one.set_p50_ns(ages.age.Quantile(kMiddle));
    one.set_p99_ns(ages.age.Quantile(kAlmostAll));
    one.set_max_ns(ages.age.max_ns());
  }
}

void Fill(Snapshot::Channel& message, const ChannelTraffic& traffic) {
  message.set_encoded(traffic.encoded);
  message.set_encoded_bytes(traffic.encoded_bytes);
  message.set_sent(traffic.out.sent);
  message.set_subscribers(traffic.out.subscribers);
  message.set_publishers(traffic.publishers);
  message.set_send_dropped(traffic.out.dropped + traffic.out.missed);
  std::uint64_t lost = 0;
  for (const PublisherTraffic& publisher : traffic.in) lost += publisher.lost;
  message.set_lost(lost);
  message.set_faults(std::accumulate(traffic.faults.begin(), traffic.faults.end(), std::uint64_t{0}));
  message.set_transport_p50_ns(traffic.transport.Quantile(kMiddle));
  message.set_transport_p99_ns(traffic.transport.Quantile(kAlmostAll));
}

}  // namespace

Snapshot ToMessage(const SessionSnapshot& snapshot) {
  const Announcement self = AnnouncementOfThisProcess(snapshot.id, 0);
  Snapshot message;
  message.set_session(snapshot.id.value);
  message.set_process(snapshot.name);
  message.set_host(self.host);
  message.set_pid(self.pid);
  message.set_time_ns(WallNow().nanoseconds);
  message.set_steady_ns(MonotonicNow());
  for (const ChannelSnapshot& channel : snapshot.graph.channels) {
    Snapshot::Channel& one = *message.add_channels();
    one.set_name(channel.name);
    one.set_type(channel.type);
    one.set_published(channel.published);
    one.set_refused(channel.refused);
    one.set_received(channel.received);
    one.set_rate_hz(channel.rate_hz);
    one.set_latched(channel.latched);
    one.set_closed(channel.closed);
    const auto why = [&](const auto& reasons) {
      const auto found = reasons.find(channel.name);
      return found == reasons.end() ? std::string() : found->second;
    };
    one.set_not_leaving(why(snapshot.not_leaving));
    one.set_not_entering(why(snapshot.not_entering));
    one.set_forbidden(snapshot.forbidden.contains(channel.name));
    for (const NodeSnapshot& node : channel.nodes) Fill(*one.add_nodes(), node);
    const auto traffic = std::ranges::lower_bound(snapshot.traffic, channel.name, {}, &ChannelTraffic::channel);
    if (traffic != snapshot.traffic.end() && traffic->channel == channel.name) Fill(one, *traffic);
  }
  for (const ServiceSnapshot& service : snapshot.services) {
    Snapshot::Service& one = *message.add_services();
    one.set_name(service.name);
    one.set_unhandled_requests(service.unhandled_requests);
    one.set_dropped_replies(service.dropped_replies);
  }
  for (const PeerInfo& peer : snapshot.peers) {
    Snapshot::Peer& one = *message.add_peers();
    one.set_session(peer.id.value);
    one.set_transport(peer.transport);
    if (peer.transport != "shared memory") one.set_why(peer.why);  // Of the cheapest one nobody asks why.
  }
  message.set_cpu_ns(ProcessCpuTime());
  message.set_memory_bytes(static_cast<std::int64_t>(ResidentBytes()));
  message.set_version(HGROS_VERSION);
  message.set_control(snapshot.steerable ? kControlVersion : 0);
  message.set_refused_orders(snapshot.refused_orders);
  return message;
}

}  // namespace hgros
