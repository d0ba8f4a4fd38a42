#include "roll_call.hpp"

#include <algorithm>
#include <memory>

#include "channels.hpp"
#include "plan.hpp"

namespace slam2d {
namespace {

// The last messages of a process that is gone may still be in the queues.
constexpr std::chrono::seconds kLastWords{2};

}  // namespace

RollCall::RollCall(hgros::Session& session, Ending& ending)
    : ending_(ending),
      stop_(ending.token()),
      session_(session.id().ToString()),
      ready_(session.Advertise<msg::Ready>(kReady, {.latched = 1})),
      ready_subscription_(session.FromAny<msg::Ready>(
          kReady, hgros::Invoke::kSerial,
          [this](const msg::Ready& message) { ending_.Guard("roll call", [&] { TakeReady(message); }); },
          {.name = "roll call", .queue = hgros::Queue::KeepAll(64), .executor = {}})),
      event_subscription_(session.FromGraph<hgros::PeerEvent>(
          hgros::kPeerEventsChannel, hgros::Invoke::kSerial,
          [this](const hgros::PeerEvent& event) { ending_.Guard("roll call", [&] { TakeEvent(event); }); },
          {.name = "roll call/peers", .queue = hgros::Queue::KeepLast(64), .executor = {}})) {}

void RollCall::Answer(const std::set<std::string>& nodes, std::uint64_t next_scan) {
  auto ready = std::make_unique<msg::Ready>();
  ready->set_session(session_);
  for (const std::string& node : nodes) ready->add_nodes(node);
  ready->set_next_scan(next_scan);
  if (const hgros::PublishStatus status = ready_(std::move(ready)); status != hgros::PublishStatus::kOk) {
    ending_.Fail("roll call: the answer could not be published: " + std::string(hgros::ToString(status)) + ".");
  }
}

void RollCall::TakeReady(const msg::Ready& message) {
  const std::scoped_lock lock(mutex_);
  members_[message.session()] = {{message.nodes().begin(), message.nodes().end()}, message.next_scan()};
  changed_.notify_all();
}

void RollCall::TakeEvent(const hgros::PeerEvent& event) {
  const std::string who = event.peer.process + " (session " + event.peer.id.ToString() + " on " + event.peer.host + ")";
  if (event.kind == hgros::PeerEvent::Kind::kTypeMismatch) {
    ending_.Fail(event.reason);
  }
  if (event.kind != hgros::PeerEvent::Kind::kGone) return;
  const std::scoped_lock lock(mutex_);
  const auto member = members_.find(event.peer.id.ToString());
  if (member == members_.end()) return;
  const std::vector<std::string> nodes(member->second.nodes.begin(), member->second.nodes.end());
  ending_.FailAt(std::chrono::steady_clock::now() + kLastWords,
                 who + (nodes.empty() ? "" : ", which ran " + Enumerate(nodes) + ",") +
                     " is gone before the work was done: " + event.reason);
}

std::vector<std::string> RollCall::WaitFor(const std::vector<std::string>& nodes,
                                           std::chrono::steady_clock::time_point deadline) {
  std::vector<std::string> missing;
  std::unique_lock lock(mutex_);
  changed_.wait_until(lock, stop_, deadline, [&] {
    missing = nodes;
    for (const auto& [session, member] : members_) {
      std::erase_if(missing, [&](const std::string& node) { return member.nodes.contains(node); });
    }
    return missing.empty();
  });
  return missing;
}

std::string RollCall::WaitForSuccessor(std::uint64_t next_scan, std::chrono::steady_clock::time_point deadline) {
  std::string successor;
  std::unique_lock lock(mutex_);
  changed_.wait_until(lock, stop_, deadline, [&] {
    for (const auto& [session, member] : members_) {
      if (session != session_ && member.nodes.contains("mapper") && member.next_scan == next_scan) successor = session;
    }
    return !successor.empty();
  });
  return successor;
}

}  // namespace slam2d
