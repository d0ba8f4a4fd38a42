#include "transport/zmq/carrier.hpp"

#include <string>
#include <utility>

namespace hgros::zmq {
namespace {

ZmqOptions Completed(ZmqOptions options) {
  if (options.session.value == 0) options.session = SessionId::Random();
  return options;
}

}  // namespace

Carrier::Carrier(ZmqOptions given, TransportListener& told, Log& voice)
    : options(Completed(std::move(given))),
      self(OwnFacts(options.session, options.process)),
      listener(told),
      log(voice),
      peers(told) {}

void Carrier::CountFault(PacketFault fault, std::string_view where, std::string_view what) {
  faults[static_cast<std::size_t>(fault)].fetch_add(1, std::memory_order_relaxed);
  std::string key = "zmq fault ";
  key.append(where).append(" ").append(ToString(fault));
  std::string text = "Dropped a packet from ";
  text.append(where).append(" (").append(ToString(fault)).append("): ").append(what);
  log.WriteLimited(LogLevel::kWarning, key, text);
}

void Carrier::Post(Actions&& actions) {
  if (actions.empty()) return;
  {
    const std::scoped_lock lock(posted_mutex_);
    for (auto& action : actions) posted_.push_back(std::move(action));
  }
  actions.clear();
  waker->Wake();
}

Actions Carrier::TakePosted() {
  const std::scoped_lock lock(posted_mutex_);
  return std::exchange(posted_, {});
}

}  // namespace hgros::zmq
