// Ours, called as a program calls it: one session a process, FromAny and a handle of Advertise. A mode is a line of
// Places: which endpoints the two sessions have, if any, and where messages lie.
#include <chrono>
#include <functional>
#include <map>

#include "buffers.hpp"
#include "hgros/hgros.hpp"
#include "peer.hpp"

namespace hgros::bench {
namespace {

struct Place {
  std::function<std::string(const Task&)> endpoint;  ///< Where the sender binds; none if the two need none.
  Executor executor;
  ShmWait wait = ShmWait::kSleep;
  bool lends = false;  ///< Each message is lent by the session; otherwise a ring of blocks is reused.
};

const std::map<std::string, Place>& Places() {
  static const std::map<std::string, Place> places = {
      {"ipc", {[](const Task& task) { return "ipc://" + task.folder + "/" + task.name; }, Executor::Inline()}},
      {"tcp",
       {[](const Task& task) { return "tcp://127.0.0.1:" + std::to_string(task.lanes[0].port); }, Executor::Inline()}},
      {"shm", {nullptr, Executor::Inline()}},
      {"shm_loan", {nullptr, Executor::Inline(), ShmWait::kSleep, true}},
      {"shm_busy", {nullptr, Executor::Inline(), ShmWait::kBusy}},
      {"shm_busy_loan", {nullptr, Executor::Inline(), ShmWait::kBusy, true}},
      {"pointer", {nullptr, Executor::Inline()}},
      {"pointer_tbb", {nullptr, Executor::Tbb()}},
  };
  return places;
}

Config ConfigOf(const Task& task, const Place& place) {
  Config config;
  config.shared_memory.wait = place.wait;
  // The two processes of a measurement, and nobody else.
  config.discovery.domain = "bench-" + std::to_string(std::hash<std::string>()(task.folder + "/" + task.name));
  if (!place.endpoint) return config;
  config.discovery.local = false;
  auto& side = task.role == Task::Role::kPublish ? config.publishers : config.subscribers;
  side.push_back({place.endpoint(task), {}, true});
  return config;
}

void Quiet(LogLevel level, std::string_view text) {
  if (level >= LogLevel::kWarning) std::fprintf(stderr, "%.*s\n", static_cast<int>(text.size()), text.data());
}

class OurOutlet final : public Outlet {
 public:
  OurOutlet(Session& session, const Lane& lane, const Place& place)
      : session_(session),
        lane_(lane),
        place_(place),
        publish_(session.Advertise<Block>(lane.name)),
        ring_(place.lends ? 0 : 2 * lane.depth() + 8, [&] {
          auto block = std::make_shared<Block>(Block::Allocate(lane.size_bytes));
          Fill(block->writable().data(), lane.size_bytes);
          return block;
        }) {
    if (!session.WaitForSubscribers(lane.name, 1, std::chrono::seconds(10))) Fail("our receiver did not come in 10 s");
  }
  std::byte* Take() override {
    taken_ = lends() ? std::shared_ptr<Block>(session_.Loan<Block>(lane_.name, lane_.size_bytes)) : ring_.Take();
    return taken_->writable().data();
  }
  bool Publish() override {
    const std::shared_ptr<const Block> message = std::move(taken_);
    return publish_.Wait(message, std::chrono::steady_clock::now() + std::chrono::seconds(5)) == PublishStatus::kOk;
  }
  [[nodiscard]] bool lends() const override { return place_.lends; }

 private:
  Session& session_;
  const Lane& lane_;
  const Place& place_;
  hgros::Publisher<Block> publish_;
  PointerRing<std::shared_ptr<Block>> ring_;
  std::shared_ptr<Block> taken_;
};

class OurInlet final : public Inlet {
 public:
  OurInlet(Session& session, const Lane& lane, const Executor& executor, Sink& sink)
      : subscription_(session.FromAny<Block>(
            lane.name, Invoke::kSerial, [&sink](const Block& block) { sink.Note(block.bytes().data(), block.size()); },
            {{}, Queue::KeepAll(lane.depth()), executor})) {}

 private:
  Subscription subscription_;
};

class Ours final : public Peer {
 public:
  Ours(const Task& task, const Place& place) : place_(place), session_(ConfigOf(task, place), {"bench_peer", Quiet}) {}
  std::unique_ptr<Inlet> Subscribe(const Lane& lane, Sink& sink) override {
    return std::make_unique<OurInlet>(session_, lane, place_.executor, sink);
  }
  std::unique_ptr<Outlet> Publish(const Lane& lane) override {
    return std::make_unique<OurOutlet>(session_, lane, place_);
  }

 private:
  const Place& place_;
  Session session_;
};

}  // namespace

std::unique_ptr<Peer> MakePeer(const Task& task) {
  const auto place = Places().find(task.mode);
  if (place == Places().end()) Fail("ours has no mode \"" + task.mode + "\"");
  return std::make_unique<Ours>(task, place->second);
}

}  // namespace hgros::bench
