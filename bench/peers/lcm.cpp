// LCM over UDP multicast on loopback: best effort by design, messages above 64 KB in fragments.
#include <lcm/lcm.h>

#include <atomic>

#include "buffers.hpp"
#include "peer.hpp"
#include "receiving_thread.hpp"

namespace hgros::bench {
namespace {

class LcmInlet final : public Inlet {
 public:
  LcmInlet(lcm_t* lcm, const Lane& lane, Sink& sink)
      : lcm_(lcm),
        subscription_(lcm_subscribe(
            lcm, lane.name.c_str(),
            [](const lcm_recv_buf_t* message, const char*, void* to) {
              static_cast<Sink*>(to)->Note(message->data, message->data_size);
            },
            &sink)) {
    lcm_subscription_set_queue_capacity(subscription_, static_cast<int>(lane.depth()));
    thread_ = std::make_unique<ReceivingThread>([lcm](const std::atomic<bool>& stopped) {
      while (!stopped.load()) lcm_handle_timeout(lcm, 50);
    });
  }
  ~LcmInlet() override {
    thread_.reset();
    lcm_unsubscribe(lcm_, subscription_);
  }

 private:
  lcm_t* lcm_;
  lcm_subscription_t* subscription_;
  std::unique_ptr<ReceivingThread> thread_;
};

class LcmOutlet final : public Outlet {
 public:
  LcmOutlet(lcm_t* lcm, const Lane& lane) : lcm_(lcm), channel_(lane.name), message_(FilledBuffer(lane.size_bytes)) {}
  std::byte* Take() override { return message_.data(); }
  bool Publish() override {
    return lcm_publish(lcm_, channel_.c_str(), message_.data(), static_cast<unsigned>(message_.size())) == 0;
  }

 private:
  lcm_t* lcm_;
  std::string channel_;
  std::vector<std::byte> message_;
};

class Lcm final : public Peer {
 public:
  explicit Lcm(const Task& task) {
    const std::string port = std::to_string(task.lanes[0].port);
    lcm_ = lcm_create(("udpm://239.255.76.67:" + port + "?ttl=0&recv_buf_size=4194304").c_str());
    if (lcm_ == nullptr) Fail("LCM cannot be started on a multicast address of the loopback interface");
  }
  ~Lcm() override { lcm_destroy(lcm_); }
  std::unique_ptr<Inlet> Subscribe(const Lane& lane, Sink& sink) override {
    return std::make_unique<LcmInlet>(lcm_, lane, sink);
  }
  std::unique_ptr<Outlet> Publish(const Lane& lane) override { return std::make_unique<LcmOutlet>(lcm_, lane); }

 private:
  lcm_t* lcm_ = nullptr;
};

}  // namespace

std::unique_ptr<Peer> MakePeer(const Task& task) {
  if (task.mode != "udpm") Fail("LCM has no mode \"" + task.mode + "\"");
  return std::make_unique<Lcm>(task);
}

}  // namespace hgros::bench
