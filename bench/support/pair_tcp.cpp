// The floor between hosts: one TCP connection, each message as its length and its bytes.
#include <arpa/inet.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <sys/uio.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <thread>

#include "support/pair.hpp"

namespace hgros::bench {
namespace {

void CheckSocket(bool good, const char* what) {
  if (good) return;
  std::perror(what);
  std::exit(2);
}

sockaddr_in AddressOf(const std::string& endpoint) {
  const std::size_t colon = endpoint.rfind(':');
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(std::stoi(endpoint.substr(colon + 1))));
  CheckSocket(inet_pton(AF_INET, endpoint.substr(0, colon).c_str(), &address.sin_addr) == 1, "address of raw TCP");
  return address;
}

void NoDelay(int connection) {
  const int yes = 1;
  setsockopt(connection, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
}

bool ReadAll(int connection, void* to, std::size_t size) {
  auto* bytes = static_cast<char*>(to);
  while (size > 0) {
    const ssize_t count = recv(connection, bytes, size, 0);
    if (count <= 0) return false;
    bytes += count;
    size -= static_cast<std::size_t>(count);
  }
  return true;
}

class TcpSender final : public PairSender {
 public:
  explicit TcpSender(const std::string& endpoint) {
    const int listener = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    const int yes = 1;
    setsockopt(listener, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    const sockaddr_in address = AddressOf(endpoint);
    CheckSocket(bind(listener, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0, "raw TCP bind");
    CheckSocket(listen(listener, 1) == 0, "raw TCP listen");
    connection_ = accept4(listener, nullptr, nullptr, SOCK_CLOEXEC);
    CheckSocket(connection_ >= 0, "raw TCP accept");
    NoDelay(connection_);
    close(listener);
  }
  ~TcpSender() override { close(connection_); }
  void Send(const std::shared_ptr<Block>& block) override {
    std::uint64_t size = block->bytes().size();
    iovec parts[2] = {{&size, sizeof size}, {const_cast<std::byte*>(block->bytes().data()), size}};
    msghdr header{};
    header.msg_iov = parts;
    header.msg_iovlen = 2;
    while (parts[1].iov_len > 0) {
      const ssize_t sent = sendmsg(connection_, &header, MSG_NOSIGNAL);
      CheckSocket(sent > 0, "raw TCP send");
      std::size_t left = static_cast<std::size_t>(sent);
      for (iovec& part : parts) {
        const std::size_t step = std::min(left, part.iov_len);
        part.iov_base = static_cast<char*>(part.iov_base) + step;
        part.iov_len -= step;
        left -= step;
      }
    }
  }

 private:
  int connection_ = -1;
};

class TcpReceiver final : public PairReceiver {
 public:
  TcpReceiver(const std::string& endpoint, PairControl& control) {
    const sockaddr_in address = AddressOf(endpoint);
    for (int tries = 0;; ++tries) {
      connection_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
      if (connect(connection_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) break;
      close(connection_);
      CheckSocket(tries < 500, "raw TCP connect");
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    NoDelay(connection_);
    thread_ = std::jthread([this, &control] {
      std::vector<std::byte> bytes;
      for (std::uint64_t size = 0; ReadAll(connection_, &size, sizeof size);) {
        if (bytes.size() < size) bytes.resize(size);
        if (!ReadAll(connection_, bytes.data(), size)) break;
        NoteArrival(control, {bytes.data(), size});
      }
    });
  }
  ~TcpReceiver() override {
    shutdown(connection_, SHUT_RDWR);
    thread_.join();
    close(connection_);
  }

 private:
  int connection_ = -1;
  std::jthread thread_;
};

}  // namespace

std::unique_ptr<PairSender> MakeTcpSender(const std::string& endpoint) { return std::make_unique<TcpSender>(endpoint); }
std::unique_ptr<PairReceiver> MakeTcpReceiver(const std::string& endpoint, PairControl& control) {
  return std::make_unique<TcpReceiver>(endpoint, control);
}

}  // namespace hgros::bench
