// A process that publishes and subscribes through shared memory, to be killed.
//
//     shm_worker PLACE MODE
//
// Publishes "up" and subscribes to "down" at the session at PLACE, without loss. MODE: "work"; "fork", which leaves a
// child behind that does nothing; the folder of a memory control group, which it joins, to publish a large message for
// each one that it receives. Reports on standard output.
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <string>
#include <thread>

#include "hgros/transport/shm_transport.hpp"
#include "resilience/shm_numbers.hpp"
#include "support/await.hpp"

namespace {

volatile std::sig_atomic_t terminated = 0;

constexpr std::size_t kSmall = 100'000;
constexpr std::size_t kLarge = 500'000;

}  // namespace

int main(int argc, char** argv) {
  using namespace hgros;
  using namespace hgros::resilience;
  if (argc != 3) return 2;
  const std::string mode = argv[2];
  const bool grouped = mode.starts_with("/");
  if (grouped && !(std::ofstream(mode + "/cgroup.procs") << getpid() << std::flush)) return 3;
  std::signal(SIGTERM, [](int) { terminated = 1; });
  std::atomic<unsigned> warnings{0};
  Log log([&warnings](LogLevel, std::string_view text) {
    warnings += text.find("no shared memory") != std::string_view::npos ? 1 : 0;
    std::printf("log %.*s\n", static_cast<int>(text.size()), text.data());
    (void)std::fflush(nullptr);
  });
  QuietListener listener;
  ShmOptions options = NumberOptions("worker");
  options.peers = {argv[1]};
  if (grouped) options.limit_bytes = 1 << 30;
  const auto transport = MakeShmTransport(options, listener, log);
  NumberSink down;
  const auto inbound = transport->Subscribe("down", NumberType(), {.lossless = true}, down);
  NumberStream up(*transport, "up", grouped ? kLarge : kSmall, grouped ? kLarge : 0);
  std::jthread publishing([&](const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      if (grouped && up.published >= down.received) {
        test::Linger(std::chrono::milliseconds(1));
      } else {
        up.PublishNext(stop);
      }
    }
  });
  pid_t child = 0;
  while (terminated == 0) {
    if (mode == "fork" && child == 0 && down.received > 100) {
      child = fork();
      if (child == 0) {
        close(STDOUT_FILENO);
        down.LetGo();  // The child must not return what it inherited.
        for (;;) pause();
      }
    }
    std::printf("status received=%llu faults=%llu published=%llu child=%llu apart=%llu warnings=%u\n",
                static_cast<unsigned long long>(down.received), static_cast<unsigned long long>(down.faults),
                static_cast<unsigned long long>(up.published), static_cast<unsigned long long>(child),
                static_cast<unsigned long long>(transport->usage().sent_apart), warnings.load());
    (void)std::fflush(nullptr);
    test::Linger(std::chrono::milliseconds(10));
  }
  publishing = {};
  return 0;
}
