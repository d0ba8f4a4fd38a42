// ZeroMQ PUB/SUB with default settings: ipc, tcp. Buffers are passed without a copy and come back through the free
// function. With XPUB_NODROP a fast publisher waits instead of losing messages.
#include <zmq.h>

#include <atomic>
#include <vector>

#include "buffers.hpp"
#include "peer.hpp"
#include "receiving_thread.hpp"

namespace hgros::bench {
namespace {

void Set(void* socket, int option, int value) { zmq_setsockopt(socket, option, &value, sizeof value); }

std::string EndpointOf(const Task& task, const Lane& lane) {
  return task.mode == "tcp" ? "tcp://" + task.sender_address() + ":" + std::to_string(lane.port)
                            : "ipc://" + task.folder + "/" + lane.name;
}

class ZmqInlet final : public Inlet {
 public:
  ZmqInlet(void* context, const std::string& endpoint, const Lane& lane, Sink& sink)
      : socket_(zmq_socket(context, ZMQ_SUB)),
        thread_([this, endpoint, &lane, &sink](const std::atomic<bool>& stopped) {
          Set(socket_, ZMQ_RCVHWM, static_cast<int>(lane.depth()));
          Set(socket_, ZMQ_RCVTIMEO, 50);
          Set(socket_, ZMQ_LINGER, 0);
          zmq_setsockopt(socket_, ZMQ_SUBSCRIBE, "", 0);
          if (zmq_connect(socket_, endpoint.c_str()) != 0) Fail("ZeroMQ cannot connect to " + endpoint);
          zmq_msg_t message;
          zmq_msg_init(&message);
          while (!stopped.load()) {
            if (zmq_msg_recv(&message, socket_, 0) >= 0) sink.Note(zmq_msg_data(&message), zmq_msg_size(&message));
          }
          zmq_msg_close(&message);
          zmq_close(socket_);
        }) {}

 private:
  void* socket_;
  ReceivingThread thread_;
};

class ZmqOutlet final : public Outlet {
 public:
  ZmqOutlet(void* context, const std::string& endpoint, const Lane& lane)
      : socket_(zmq_socket(context, ZMQ_PUB)), slots_(2 * lane.depth() + 8) {
    for (Slot& slot : slots_) slot.bytes = FilledBuffer(lane.size_bytes);
    Set(socket_, ZMQ_SNDHWM, static_cast<int>(lane.depth()));
    Set(socket_, ZMQ_LINGER, 0);
    Set(socket_, ZMQ_XPUB_NODROP, 1);
    if (zmq_bind(socket_, endpoint.c_str()) != 0) Fail("ZeroMQ cannot bind " + endpoint);
  }
  ~ZmqOutlet() override {
    zmq_close(socket_);
    // The context's threads still hold messages for a moment. Their buffers have to live that long.
    for (const Slot& slot : slots_) {
      while (slot.busy.load(std::memory_order_acquire)) std::this_thread::yield();
    }
  }
  std::byte* Take() override {
    for (std::size_t tries = 0;; ++tries) {
      Slot& slot = slots_[next_];
      next_ = (next_ + 1) % slots_.size();
      if (!slot.busy.load(std::memory_order_acquire)) {
        taken_ = &slot;
        return slot.bytes.data();
      }
      if (tries >= slots_.size()) std::this_thread::yield();
    }
  }
  bool Publish() override {
    taken_->busy.store(true, std::memory_order_relaxed);
    zmq_msg_t message;
    zmq_msg_init_data(
        &message, taken_->bytes.data(), taken_->bytes.size(),
        [](void*, void* slot) { static_cast<Slot*>(slot)->busy.store(false, std::memory_order_release); }, taken_);
    if (zmq_msg_send(&message, socket_, 0) >= 0) return true;
    zmq_msg_close(&message);
    return false;
  }

 private:
  struct Slot {
    std::vector<std::byte> bytes;
    std::atomic<bool> busy{false};
  };
  void* socket_;
  std::vector<Slot> slots_;
  std::size_t next_ = 0;
  Slot* taken_ = nullptr;
};

class ZeroMq final : public Peer {
 public:
  explicit ZeroMq(const Task& task) : task_(task) {}
  ~ZeroMq() override { zmq_ctx_term(context_); }
  std::unique_ptr<Inlet> Subscribe(const Lane& lane, Sink& sink) override {
    return std::make_unique<ZmqInlet>(context_, EndpointOf(task_, lane), lane, sink);
  }
  std::unique_ptr<Outlet> Publish(const Lane& lane) override {
    return std::make_unique<ZmqOutlet>(context_, EndpointOf(task_, lane), lane);
  }

 private:
  const Task& task_;
  void* context_ = zmq_ctx_new();
};

}  // namespace

std::unique_ptr<Peer> MakePeer(const Task& task) {
  if (task.mode != "ipc" && task.mode != "tcp") Fail("ZeroMQ has no mode \"" + task.mode + "\"");
  return std::make_unique<ZeroMq>(task);
}

}  // namespace hgros::bench
