// The floor between processes: ZeroMQ PUB/SUB with default settings, moving the same bytes without a copy on our side.
#include <zmq.h>

#include <cstdio>
#include <cstdlib>
#include <thread>

#include "support/pair.hpp"

namespace hgros::bench {
namespace {

void CheckZmq(bool good, const char* what) {
  if (good) return;
  std::fprintf(stderr, "raw ZeroMQ: %s: %s\n", what, zmq_strerror(zmq_errno()));
  std::exit(2);
}

class ZmqSender final : public PairSender {
 public:
  explicit ZmqSender(const std::string& endpoint) {
    const int unlimited = 0;
    zmq_setsockopt(socket_, ZMQ_SNDHWM, &unlimited, sizeof unlimited);
    CheckZmq(zmq_bind(socket_, endpoint.c_str()) == 0, endpoint.c_str());
  }
  ~ZmqSender() override {
    zmq_close(socket_);
    zmq_ctx_term(context_);
  }
  void Send(const std::shared_ptr<Block>& block) override {
    zmq_msg_t message;
    auto* keep = new std::shared_ptr<Block>(block);
    zmq_msg_init_data(
        &message, const_cast<std::byte*>(block->bytes().data()), block->bytes().size(),
        [](void*, void* hint) { delete static_cast<std::shared_ptr<Block>*>(hint); }, keep);
    CheckZmq(zmq_msg_send(&message, socket_, 0) >= 0, "send");
  }

 private:
  void* context_ = zmq_ctx_new();
  void* socket_ = zmq_socket(context_, ZMQ_PUB);
};

class ZmqReceiver final : public PairReceiver {
 public:
  ZmqReceiver(const std::string& endpoint, PairControl& control) {
    const int unlimited = 0;
    zmq_setsockopt(socket_, ZMQ_RCVHWM, &unlimited, sizeof unlimited);
    zmq_setsockopt(socket_, ZMQ_SUBSCRIBE, "", 0);
    CheckZmq(zmq_connect(socket_, endpoint.c_str()) == 0, endpoint.c_str());
    thread_ = std::jthread([this, &control] {
      for (;;) {
        zmq_msg_t message;
        zmq_msg_init(&message);
        if (zmq_msg_recv(&message, socket_, 0) < 0) break;
        NoteArrival(control, {static_cast<const std::byte*>(zmq_msg_data(&message)), zmq_msg_size(&message)});
        zmq_msg_close(&message);
      }
      zmq_close(socket_);
    });
  }
  ~ZmqReceiver() override { zmq_ctx_term(context_); }

 private:
  void* context_ = zmq_ctx_new();
  void* socket_ = zmq_socket(context_, ZMQ_SUB);
  std::jthread thread_;
};

}  // namespace

std::unique_ptr<PairSender> MakeZmqSender(const std::string& endpoint) { return std::make_unique<ZmqSender>(endpoint); }
std::unique_ptr<PairReceiver> MakeZmqReceiver(const std::string& endpoint, PairControl& control) {
  return std::make_unique<ZmqReceiver>(endpoint, control);
}

}  // namespace hgros::bench
