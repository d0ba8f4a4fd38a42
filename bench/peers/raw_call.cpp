// The floor inside a process: the callback is called, directly (call) or after a copy of the bytes (memcpy).
#include <cstring>
#include <vector>

#include "buffers.hpp"
#include "peer.hpp"

namespace hgros::bench {
namespace {

class RawCall final : public Peer {
 public:
  explicit RawCall(bool copies) : copies_(copies) {}
  std::unique_ptr<Inlet> Subscribe(const Lane&, Sink& sink) override {
    sink_ = &sink;
    return std::make_unique<Inlet>();
  }
  std::unique_ptr<Outlet> Publish(const Lane& lane) override {
    return std::make_unique<Call>(lane.size_bytes, *sink_, copies_);
  }

 private:
  class Call final : public Outlet {
   public:
    Call(std::size_t size_bytes, Sink& sink, bool copies)
        : message_(FilledBuffer(size_bytes)),
          copy_(copies ? FilledBuffer(size_bytes) : message_),
          sink_(sink),
          copies_(copies) {}
    std::byte* Take() override { return message_.data(); }
    bool Publish() override {
      if (copies_) std::memcpy(copy_.data(), message_.data(), message_.size());
      sink_.Note(copies_ ? copy_.data() : message_.data(), message_.size());
      return true;
    }

   private:
    std::vector<std::byte> message_;
    std::vector<std::byte> copy_;
    Sink& sink_;
    bool copies_;
  };

  Sink* sink_ = nullptr;
  bool copies_;
};

}  // namespace

std::unique_ptr<Peer> MakePeer(const Task& task) {
  if (task.mode != "call" && task.mode != "memcpy") Fail("raw calls have no mode \"" + task.mode + "\"");
  return std::make_unique<RawCall>(task.mode == "memcpy");
}

}  // namespace hgros::bench
