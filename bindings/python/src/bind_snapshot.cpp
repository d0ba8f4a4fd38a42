#include <pybind11/stl.h>

#include <string>

#include "bindings.hpp"
#include "session_handle.hpp"

namespace hgros::python {
namespace {

using py::literals::operator""_a;  // NOLINT(misc-unused-using-decls): clang-tidy 14 does not see its uses

py::dict AsDict(const LogHistogram& times) {
  return py::dict("count"_a = times.count(), "mean_ns"_a = times.mean_ns(), "median_ns"_a = times.Quantile(0.5),
                  "p99_ns"_a = times.Quantile(0.99), "max_ns"_a = times.max_ns());
}

py::dict AsDict(const NodeSnapshot& node) {
  return py::dict("name"_a = node.name, "channel"_a = node.channel, "received"_a = node.received,
                  "dropped"_a = node.dropped, "run"_a = node.run, "failed"_a = node.failed, "queued"_a = node.queued,
                  "queue_wait"_a = AsDict(node.queue_wait), "run_time"_a = AsDict(node.run_time));
}

py::dict AsDict(const ChannelSnapshot& channel) {
  py::list nodes;
  for (const auto& node : channel.nodes) nodes.append(AsDict(node));
  return py::dict("name"_a = channel.name, "type_name"_a = channel.type, "published"_a = channel.published,
                  "rate_hz"_a = channel.rate_hz, "refused"_a = channel.refused, "received"_a = channel.received,
                  "latched"_a = channel.latched, "nodes"_a = nodes);
}

py::dict AsDict(const PeerInfo& peer) {
  return py::dict("id"_a = peer.id.ToString(), "process"_a = peer.process, "host"_a = peer.host, "pid"_a = peer.pid,
                  "transport"_a = peer.transport, "why"_a = peer.why);
}

py::dict AsDict(const ChannelTraffic& traffic) {
  std::uint64_t lost = 0;
  for (const auto& one : traffic.in) lost += one.lost;
  return py::dict("channel"_a = traffic.channel, "encoded"_a = traffic.encoded,
                  "encoded_bytes"_a = traffic.encoded_bytes, "copied"_a = traffic.out.copied, "loans"_a = traffic.loans,
                  "heap_loans"_a = traffic.heap_loans, "publishers"_a = traffic.publishers, "lost"_a = lost);
}

template <class List>
py::list Dicts(const List& list) {
  py::list dicts;
  for (const auto& one : list) dicts.append(AsDict(one));
  return dicts;
}

py::dict Snapshot(const SessionHandle& handle) {
  SessionSnapshot taken;
  {
    const GilRelease released;
    taken = handle.Use()->Snapshot();
  }
  return py::dict("id"_a = taken.id.ToString(), "name"_a = taken.name, "channels"_a = Dicts(taken.graph.channels),
                  "traffic"_a = Dicts(taken.traffic), "peers"_a = Dicts(taken.peers));
}

py::list Channels(const SessionHandle& handle) {
  std::vector<KnownChannel> known;
  {
    const GilRelease released;
    known = handle.Use()->Channels();
  }
  py::list list;
  for (const auto& one : known) {
    list.append(py::dict("name"_a = one.name, "type_name"_a = one.type_name, "publishers"_a = one.publishers.size(),
                         "subscribers"_a = one.subscribers.size()));
  }
  return list;
}

}  // namespace

void BindSnapshot(py::module_& module) {
  module.def("snapshot", &Snapshot, py::arg("session"));
  module.def("channels", &Channels, py::arg("session"));
}

}  // namespace hgros::python
