// The floor through the kernel: one blocking stream socket with fixed-size messages, unix or tcp.
#include <arpa/inet.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <atomic>
#include <cstdio>
#include <cstring>

#include "buffers.hpp"
#include "peer.hpp"
#include "receiving_thread.hpp"

namespace hgros::bench {
namespace {

/// The address of a lane. The receiver binds it and the sender connects to it.
class Address {
 public:
  Address(const Lane& lane, const Task& task) : tcp_(task.mode == "tcp") {
    if (tcp_) {
      internet_.sin_family = AF_INET;
      internet_.sin_port = htons(static_cast<std::uint16_t>(lane.port));
      if (inet_pton(AF_INET, task.receiver_address().c_str(), &internet_.sin_addr) != 1)
        Fail("the address is not an IPv4 address");
    } else {
      local_.sun_family = AF_UNIX;
      std::snprintf(local_.sun_path, sizeof local_.sun_path, "%s/%s", task.folder.c_str(), lane.name.c_str());
    }
  }
  [[nodiscard]] int Listen() const {
    const int listener = NewSocket();
    const int yes = 1;
    setsockopt(listener, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    if (bind(listener, get(), size()) != 0 || listen(listener, 1) != 0) Fail("a raw socket cannot be bound");
    return listener;
  }
  [[nodiscard]] int Connect() const {
    const int connection = NewSocket();
    if (connect(connection, get(), size()) != 0) Fail("a raw socket cannot be connected");
    const int yes = 1;
    if (tcp_) setsockopt(connection, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
    return connection;
  }

 private:
  [[nodiscard]] int NewSocket() const { return socket(tcp_ ? AF_INET : AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0); }
  [[nodiscard]] const sockaddr* get() const {
    return tcp_ ? reinterpret_cast<const sockaddr*>(&internet_) : reinterpret_cast<const sockaddr*>(&local_);
  }
  [[nodiscard]] socklen_t size() const { return tcp_ ? sizeof internet_ : sizeof local_; }

  bool tcp_;
  sockaddr_in internet_{};
  sockaddr_un local_{};
};

class SocketInlet final : public Inlet {
 public:
  SocketInlet(const Address& address, const Lane& lane, Sink& sink)
      : listener_(address.Listen()), thread_([this, &lane, &sink](const std::atomic<bool>& stopped) {
          const int connection = accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
          if (connection < 0) return;
          const timeval look{0, 50'000};
          setsockopt(connection, SOL_SOCKET, SO_RCVTIMEO, &look, sizeof look);
          std::vector<std::byte> bytes(lane.size_bytes);
          for (std::size_t have = 0; !stopped.load();) {
            const ssize_t count = recv(connection, bytes.data() + have, bytes.size() - have, 0);
            if (count == 0) break;
            if (count < 0) continue;
            have += static_cast<std::size_t>(count);
            if (have < bytes.size()) continue;
            sink.Note(bytes.data(), bytes.size());
            have = 0;
          }
          close(connection);
        }) {}
  ~SocketInlet() override {
    shutdown(listener_, SHUT_RDWR);
    close(listener_);
  }

 private:
  int listener_;
  ReceivingThread thread_;
};

class SocketOutlet final : public Outlet {
 public:
  SocketOutlet(const Address& address, std::size_t size_bytes)
      : connection_(address.Connect()), message_(FilledBuffer(size_bytes)) {}
  ~SocketOutlet() override { close(connection_); }
  std::byte* Take() override { return message_.data(); }
  bool Publish() override {
    for (std::size_t done = 0; done < message_.size();) {
      const ssize_t count = send(connection_, message_.data() + done, message_.size() - done, MSG_NOSIGNAL);
      if (count <= 0) Fail("a raw socket failed");
      done += static_cast<std::size_t>(count);
    }
    return true;
  }

 private:
  int connection_;
  std::vector<std::byte> message_;
};

class RawSocket final : public Peer {
 public:
  explicit RawSocket(const Task& task) : task_(task) {}
  std::unique_ptr<Inlet> Subscribe(const Lane& lane, Sink& sink) override {
    return std::make_unique<SocketInlet>(Address(lane, task_), lane, sink);
  }
  std::unique_ptr<Outlet> Publish(const Lane& lane) override {
    return std::make_unique<SocketOutlet>(Address(lane, task_), lane.size_bytes);
  }

 private:
  const Task& task_;
};

}  // namespace

std::unique_ptr<Peer> MakePeer(const Task& task) {
  if (task.mode != "tcp" && task.mode != "uds") Fail("raw sockets have no mode \"" + task.mode + "\"");
  return std::make_unique<RawSocket>(task);
}

}  // namespace hgros::bench
