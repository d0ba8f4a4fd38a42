// iceoryx: chunks lent from shared memory. The publisher waits for a slow subscriber. The subscriber is called by the
// runtime's listener (listener), sleeps in a wait set (waitset), or never sleeps (poll). Needs iox-roudi.
#include <algorithm>
#include <atomic>
#include <thread>

#include <iceoryx_posh/popo/listener.hpp>
#include <iceoryx_posh/popo/untyped_publisher.hpp>
#include <iceoryx_posh/popo/untyped_subscriber.hpp>
#include <iceoryx_posh/popo/wait_set.hpp>
#include <iceoryx_posh/runtime/posh_runtime.hpp>

#include "peer.hpp"
#include "receiving_thread.hpp"

namespace hgros::bench {
namespace {

using iox::popo::SubscriberEvent;
using iox::popo::SubscriberState;
using iox::popo::UntypedSubscriber;

constexpr std::size_t kMostQueued = 256;  // The maximum of this release.

iox::capro::ServiceDescription ServiceOf(const Lane& lane) {
  return {iox::capro::IdString_t("hgros"), iox::capro::IdString_t("peers"),
          iox::capro::IdString_t(iox::cxx::TruncateToCapacity, lane.name.c_str())};
}

iox::popo::SubscriberOptions OptionsOf(const Lane& lane) {
  iox::popo::SubscriberOptions options;
  options.queueCapacity = std::min(lane.depth(), kMostQueued);
  options.queueFullPolicy = iox::popo::QueueFullPolicy::BLOCK_PRODUCER;
  return options;
}

struct Destination {
  Sink& sink;
  std::size_t size_bytes;
};

void TakeAll(UntypedSubscriber* subscriber, Destination* to) {
  for (auto chunk = subscriber->take(); !chunk.has_error(); chunk = subscriber->take()) {
    to->sink.Note(chunk.value(), to->size_bytes);
    subscriber->release(chunk.value());
  }
}

class ListenerInlet final : public Inlet {
 public:
  ListenerInlet(const Lane& lane, Sink& sink)
      : to_{sink, lane.size_bytes}, subscriber_(ServiceOf(lane), OptionsOf(lane)) {
    listener_
        .attachEvent(subscriber_, SubscriberEvent::DATA_RECEIVED, iox::popo::createNotificationCallback(TakeAll, to_))
        .or_else([](auto) { Fail("iceoryx cannot attach a listener"); });
  }
  ~ListenerInlet() override { listener_.detachEvent(subscriber_, SubscriberEvent::DATA_RECEIVED); }

 private:
  Destination to_;
  UntypedSubscriber subscriber_;
  iox::popo::Listener listener_;
};

class WaitSetInlet final : public Inlet {
 public:
  WaitSetInlet(const Lane& lane, Sink& sink)
      : to_{sink, lane.size_bytes},
        subscriber_(ServiceOf(lane), OptionsOf(lane)),
        thread_([this](const std::atomic<bool>& stopped) {
          iox::popo::WaitSet<> set;
          set.attachState(subscriber_, SubscriberState::HAS_DATA).or_else([](auto) {
            Fail("iceoryx cannot attach a wait set");
          });
          while (!stopped.load()) {
            if (!set.timedWait(iox::units::Duration::fromMilliseconds(50)).empty()) TakeAll(&subscriber_, &to_);
          }
          set.detachState(subscriber_, SubscriberState::HAS_DATA);
        }) {}

 private:
  Destination to_;
  UntypedSubscriber subscriber_;
  ReceivingThread thread_;
};

class PollInlet final : public Inlet {
 public:
  PollInlet(const Lane& lane, Sink& sink)
      : to_{sink, lane.size_bytes},
        subscriber_(ServiceOf(lane), OptionsOf(lane)),
        thread_([this](const std::atomic<bool>& stopped) {
          while (!stopped.load()) TakeAll(&subscriber_, &to_);
        }) {}

 private:
  Destination to_;
  UntypedSubscriber subscriber_;
  ReceivingThread thread_;
};

class IceoryxOutlet final : public Outlet {
 public:
  explicit IceoryxOutlet(const Lane& lane)
      : publisher_(ServiceOf(lane),
                   [] {
                     iox::popo::PublisherOptions options;
                     options.subscriberTooSlowPolicy = iox::popo::ConsumerTooSlowPolicy::WAIT_FOR_CONSUMER;
                     return options;
                   }()),
        size_bytes_(static_cast<std::uint32_t>(lane.size_bytes)) {}
  std::byte* Take() override {
    auto chunk = publisher_.loan(size_bytes_);
    if (chunk.has_error()) {
      std::this_thread::yield();
      return nullptr;
    }
    taken_ = chunk.value();
    return static_cast<std::byte*>(taken_);
  }
  bool Publish() override {
    publisher_.publish(taken_);
    return true;
  }
  [[nodiscard]] bool lends() const override { return true; }

 private:
  iox::popo::UntypedPublisher publisher_;
  std::uint32_t size_bytes_;
  void* taken_ = nullptr;
};

class Iceoryx final : public Peer {
 public:
  explicit Iceoryx(const Task& task) : mode_(task.mode) {
    const std::string name =
        task.name + (task.role == Task::Role::kPublish ? "_pub" : "_sub" + std::to_string(task.receiver));
    iox::runtime::PoshRuntime::initRuntime(iox::RuntimeName_t(iox::cxx::TruncateToCapacity, name.c_str()));
  }
  std::unique_ptr<Inlet> Subscribe(const Lane& lane, Sink& sink) override {
    if (mode_ == "listener") return std::make_unique<ListenerInlet>(lane, sink);
    if (mode_ == "waitset") return std::make_unique<WaitSetInlet>(lane, sink);
    return std::make_unique<PollInlet>(lane, sink);
  }
  std::unique_ptr<Outlet> Publish(const Lane& lane) override { return std::make_unique<IceoryxOutlet>(lane); }

 private:
  std::string mode_;
};

}  // namespace

std::unique_ptr<Peer> MakePeer(const Task& task) {
  if (task.mode != "listener" && task.mode != "waitset" && task.mode != "poll") {
    Fail("iceoryx has no mode \"" + task.mode + "\"");
  }
  return std::make_unique<Iceoryx>(task);
}

}  // namespace hgros::bench
