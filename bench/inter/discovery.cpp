// How soon sessions of one host discover and reach each other without configuration: two, and fifty.
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <thread>
#include <vector>

#include "hgros/clock/time.hpp"
#include "hgros/hgros.hpp"
#include "support/handoff.hpp"
#include "support/samples.hpp"

namespace hgros::bench {
namespace {

constexpr int kSessions = 50;
constexpr int kChannels = 20;  // Per session: it publishes half of them and subscribes to the others.

Config InDomain(const std::string& name) {
  Config config;
  config.discovery.domain = "bench-" + name + "-" + std::to_string(getpid());
  return config;
}

// From the moment when the later of two programs begins to create its session until the first message.
void FirstMessage(int rounds) {
  const Config config = InDomain("two");
  Session early(config, {"early", nullptr});
  Arrival arrival;
  const auto subscription = early.FromAny<Block>("first", Invoke::kSerial, [&](const Block&) { arrival.Note(); },
                                                 {{}, {}, Executor::Inline()});
  Samples samples;
  for (int round = 0; round < rounds; ++round) {
    const std::int64_t start = MonotonicNow();
    Session late(config, {"late", nullptr});
    const auto publish = late.Advertise<Block>("first");
    if (!late.WaitForSubscribers("first", 1, std::chrono::seconds(10))) {
      std::fprintf(stderr, "two sessions did not find each other\n");
      return;
    }
    publish(std::make_shared<const Block>(Block::Allocate(64)));
    samples.Add(static_cast<double>(arrival.Wait() - start));
  }
  Report("discovery_first_message_ms", samples.Median() / 1e6, "ms");
}

// What the processes of the fifty sessions report to the measuring process.
struct Board {
  std::atomic<int> settled{0};
  std::atomic<int> measured{0};
  std::atomic<int> stop{0};
  std::array<std::atomic<double>, kSessions> cpu_seconds{};
};

double CpuSeconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_usec) / 1e6;
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

std::string ChannelOf(int session, int index) {
  return "session" + std::to_string(session) + "/" + std::to_string(index);
}

void Sleep(double seconds) { std::this_thread::sleep_for(std::chrono::duration<double>(seconds)); }

[[noreturn]] void RunOne(int number, const Config& config, Board& board, double idle_s) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  {
    Session session(config, {"one_of_fifty", nullptr});
    std::vector<Publisher<Block>> publishers;
    std::vector<Subscription> subscriptions;
    const int neighbor = (number + 1) % kSessions;
    for (int i = 0; i < kChannels / 2; ++i) {
      publishers.push_back(session.Advertise<Block>(ChannelOf(number, i)));
      subscriptions.push_back(session.FromAny<Block>(ChannelOf(neighbor, i), Invoke::kSerial, [](const Block&) {}));
    }
    bool settled = true;
    for (int i = 0; i < kChannels / 2; ++i) {
      settled = settled && session.WaitForSubscribers(ChannelOf(number, i), 1, std::chrono::seconds(60)) &&
                session.WaitForPublishers(ChannelOf(neighbor, i), 1, std::chrono::seconds(60));
    }
    if (settled) ++board.settled;
    while (board.settled < kSessions && board.stop == 0) Sleep(0.01);
    Sleep(1);
    const double before = CpuSeconds();
    Sleep(idle_s);
    board.cpu_seconds[static_cast<std::size_t>(number)] = CpuSeconds() - before;
    ++board.measured;
    while (board.stop == 0) Sleep(0.01);
  }
  _exit(0);
}

void Fifty(double idle_s) {
  const Config config = InDomain("fifty");
  void* memory = mmap(nullptr, sizeof(Board), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) return;
  Board& board = *new (memory) Board;
  std::vector<pid_t> children;
  const std::int64_t start = MonotonicNow();
  for (int i = 0; i < kSessions; ++i) {
    children.push_back(fork());
    if (children.back() == 0) RunOne(i, config, board, idle_s);
  }
  const std::int64_t deadline = start + 60'000'000'000;
  while (board.settled < kSessions && MonotonicNow() < deadline) Sleep(0.001);
  const double settle_s = static_cast<double>(MonotonicNow() - start) / 1e9;
  if (board.settled < kSessions) {
    std::fprintf(stderr, "only %d of %d sessions settled\n", board.settled.load(), kSessions);
  } else {
    Report("sessions50_settle_s", settle_s, "s");
    while (board.measured < kSessions && MonotonicNow() < deadline) Sleep(0.01);
    double cpu = 0;
    for (const auto& one : board.cpu_seconds) cpu += one;
    Report("sessions50_idle_cpu_percent", 100 * cpu / idle_s, "%");
  }
  board.stop = 1;
  for (const pid_t child : children) waitpid(child, nullptr, 0);
  munmap(memory, sizeof(Board));
}

}  // namespace
}  // namespace hgros::bench

int main(int argc, char** argv) {
  using namespace hgros::bench;
  unsetenv("HGROS_DOMAIN");
  const bool quick = argc > 1 && std::string(argv[1]) == "--quick";
  Fifty(quick ? 3 : 10);  // First: it forks before this process has a session.
  FirstMessage(quick ? 9 : 25);
  return 0;
}
