// Ours, called as a program calls it: one session per process, FromAny and a handle of Advertise. A mode is a line of
// Places: which endpoints the two sessions have, if any, and which message they send.
#include <chrono>
#include <functional>
#include <map>

#include <foxglove/PointCloud.pb.h>

#include "buffers.hpp"
#include "hgros/hgros.hpp"
#include "peer.hpp"

namespace hgros::bench {
namespace {

// The message of a mode: its type, how a filled one is made for the ring of reused messages (or how the session lends
// one), and where its bytes are.

/// Only bytes. Each message is copied once into shared memory.
struct BareForm {
  using Message = Block;
  static constexpr bool kLent = false;
  static std::shared_ptr<Message> Make(std::size_t size_bytes) {
    auto block = std::make_shared<Block>(Block::Allocate(size_bytes));
    Fill(block->writable().data(), size_bytes);
    return block;
  }
  static std::byte* Writable(Message& message) { return message.writable().data(); }
  static Bytes Readable(const Message& message) { return message.bytes(); }
};

/// Bulk: the sender writes where the receiver reads. Only this struct defines how such a message is made.
struct BulkForm {
  using Message = Bulk<foxglove::PointCloud>;
  static constexpr bool kLent = true;
  static std::shared_ptr<Message> Lend(Session& session, const Lane& lane) {
    std::shared_ptr<Message> cloud = session.Loan<Message>(lane.name, lane.size_bytes);
    cloud->head().set_frame_id("lidar");
    cloud->head().set_point_stride(16);
    return cloud;
  }
  static std::byte* Writable(Message& message) { return message.writable().data(); }
  static Bytes Readable(const Message& message) { return message.bytes(); }
};

/// An ordinary protobuf message with the bytes in one of its fields.
struct PlainForm {
  using Message = foxglove::PointCloud;
  static constexpr bool kLent = false;
  static std::shared_ptr<Message> Make(std::size_t size_bytes) {
    auto cloud = std::make_shared<Message>();
    cloud->set_frame_id("lidar");
    cloud->set_point_stride(16);
    cloud->mutable_data()->resize(size_bytes);
    Fill(Writable(*cloud), size_bytes);
    return cloud;
  }
  static std::byte* Writable(Message& message) { return reinterpret_cast<std::byte*>(message.mutable_data()->data()); }
  static Bytes Readable(const Message& message) { return AsBytes(message.data()); }
};

struct Place {
  std::function<std::string(const Task&)> endpoint;  ///< Where the sender binds; empty if the two need none.
  Executor executor;
  ShmWait wait = ShmWait::kSleep;
};

void Quiet(LogLevel level, std::string_view text) {
  if (level >= LogLevel::kWarning) std::fprintf(stderr, "%.*s\n", static_cast<int>(text.size()), text.data());
}

template <class Form>
class OurOutlet final : public Outlet {
 public:
  OurOutlet(Session& session, const Task& task, const Lane& lane)
      : session_(session),
        lane_(lane),
        publish_(session.Advertise<Message>(lane.name)),
        ring_(Form::kLent ? 0 : 2 * lane.depth() + 8, [&]() -> std::shared_ptr<Message> {
          if constexpr (Form::kLent)
            return nullptr;
          else
            return Form::Make(lane.size_bytes);
        }) {
    if (!session.WaitForSubscribers(lane.name, task.receivers, std::chrono::seconds(10))) {
      Fail("our receiver did not start within 10 s");
    }
  }
  std::byte* Take() override {
    if constexpr (Form::kLent) {
      taken_ = Form::Lend(session_, lane_);
    } else {
      taken_ = ring_.Take();
    }
    return Form::Writable(*taken_);
  }
  bool Publish() override {
    const std::shared_ptr<const Message> message = std::move(taken_);
    return publish_.Wait(message, std::chrono::steady_clock::now() + std::chrono::seconds(5)) == PublishStatus::kOk;
  }
  [[nodiscard]] bool lends() const override { return Form::kLent; }

 private:
  using Message = typename Form::Message;
  Session& session_;
  const Lane& lane_;
  hgros::Publisher<Message> publish_;
  PointerRing<std::shared_ptr<Message>> ring_;
  std::shared_ptr<Message> taken_;
};

template <class Form>
class OurInlet final : public Inlet {
 public:
  OurInlet(Session& session, const Lane& lane, const Executor& executor, Sink& sink)
      : subscription_(session.FromAny<Message>(lane.name, Invoke::kSerial,
                                               [&sink](const Message& message) {
                                                 const Bytes bytes = Form::Readable(message);
                                                 sink.Note(bytes.data(), bytes.size());
                                               },
                                               {{}, Queue::KeepAll(lane.depth()), executor})) {}

 private:
  using Message = typename Form::Message;
  Subscription subscription_;
};

Config ConfigOf(const Task& task, const Place& place) {
  Config config;
  // Only the receiver waits that way, as with the others: a third thread that never sleeps takes the sender's core.
  if (task.role != Task::Role::kPublish) {
    config.shared_memory.wait = place.wait;
    if (place.wait == ShmWait::kSpin) config.shared_memory.spin_us = 5000;  // Above the pause between two messages.
  }
  // Only the processes of one measurement find each other.
  config.discovery.domain = "bench-" + std::to_string(std::hash<std::string>()(task.folder + "/" + task.name));
  if (!place.endpoint) return config;
  config.discovery.local = false;
  auto& side = task.role == Task::Role::kPublish ? config.publishers : config.subscribers;
  side.push_back({place.endpoint(task), {}, true});
  return config;
}

template <class Form>
class Ours final : public Peer {
 public:
  Ours(const Task& task, const Place& place)
      : task_(task), executor_(place.executor), session_(ConfigOf(task, place), {"bench_peer", Quiet}) {}
  std::unique_ptr<Inlet> Subscribe(const Lane& lane, Sink& sink) override {
    return std::make_unique<OurInlet<Form>>(session_, lane, executor_, sink);
  }
  std::unique_ptr<Outlet> Publish(const Lane& lane) override {
    return std::make_unique<OurOutlet<Form>>(session_, task_, lane);
  }

 private:
  const Task& task_;
  Executor executor_;
  Session session_;
};

template <class Form>
std::unique_ptr<Peer> Make(const Task& task, const Place& place) {
  return std::make_unique<Ours<Form>>(task, place);
}

std::string Ipc(const Task& task) { return "ipc://" + task.folder + "/" + task.name; }
std::string Tcp(const Task& task) {
  return "tcp://" + task.sender_address() + ":" + std::to_string(task.lanes[0].port);
}

struct Way {
  Place place;
  std::unique_ptr<Peer> (*make)(const Task&, const Place&) = Make<BareForm>;
};

const std::map<std::string, Way>& Places() {
  static const std::map<std::string, Way> places = {
      {"ipc", {{Ipc, Executor::Inline()}}},
      {"tcp", {{Tcp, Executor::Inline()}}},
      {"tcp_plain", {{Tcp, Executor::Inline()}, Make<PlainForm>}},
      {"shm", {{nullptr, Executor::Inline()}}},
      {"shm_plain", {{nullptr, Executor::Inline()}, Make<PlainForm>}},
      {"shm_bulk", {{nullptr, Executor::Inline()}, Make<BulkForm>}},
      {"shm_spin", {{nullptr, Executor::Inline(), ShmWait::kSpin}}},
      {"shm_busy", {{nullptr, Executor::Inline(), ShmWait::kBusy}}},
      {"shm_busy_bulk", {{nullptr, Executor::Inline(), ShmWait::kBusy}, Make<BulkForm>}},
      {"pointer", {{nullptr, Executor::Inline()}}},
      {"pointer_tbb", {{nullptr, Executor::Tbb()}}},
  };
  return places;
}

}  // namespace

std::unique_ptr<Peer> MakePeer(const Task& task) {
  const auto way = Places().find(task.mode);
  if (way == Places().end()) Fail("ours has no mode \"" + task.mode + "\"");
  return way->second.make(task, way->second.place);
}

}  // namespace hgros::bench
