// The cost of an idle session with 20 subscriptions and 2 peers. The session discovers the peers and also has their
// endpoints, so that both transports are in use.
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <thread>
#include <vector>

#include "hgros/hgros.hpp"
#include "support/samples.hpp"

namespace hgros::bench {
namespace {

constexpr int kSubscriptions = 20;

std::string Endpoint(const std::string& directory, int peer) {
  return "ipc://" + directory + "/idle_" + std::to_string(peer);
}

std::string Domain(const std::string& directory) { return directory.substr(directory.rfind('/') + 1); }

// A peer advertises all channels and sleeps. It never publishes.
[[noreturn]] void RunPeer(const std::string& directory, int peer) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  Config config;
  config.discovery.domain = Domain(directory);
  config.publishers.push_back({Endpoint(directory, peer), {}, true});
  Session session(std::move(config), {"idle_peer", nullptr});
  std::vector<Publisher<Block>> publishers;
  for (int i = 0; i < kSubscriptions; ++i) {
    publishers.push_back(session.Advertise<Block>("channel" + std::to_string(i)));
  }
  for (;;) pause();
}

double CpuSeconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_usec) / 1e6;
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

double ResidentMb() {
  double kb = 0;
  if (std::FILE* file = std::fopen("/proc/self/status", "r")) {
    char line[256];
    while (std::fgets(line, sizeof line, file) != nullptr) {
      if (std::sscanf(line, "VmRSS: %lf", &kb) == 1) break;
    }
    std::fclose(file);
  }
  return kb / 1024;
}

int Run(double seconds) {
  unsetenv("HGROS_DOMAIN");
  const char* temporary = std::getenv("TMPDIR");
  std::string directory = std::string(temporary != nullptr ? temporary : "/tmp") + "/hgros_idle_XXXXXX";
  if (mkdtemp(directory.data()) == nullptr) return 2;
  pid_t peers[2];
  for (int peer = 0; peer < 2; ++peer) {
    peers[peer] = fork();
    if (peers[peer] == 0) RunPeer(directory, peer);
  }
  {
    Config config;
    config.discovery.domain = Domain(directory);
    for (int peer = 0; peer < 2; ++peer) config.subscribers.push_back({Endpoint(directory, peer), {}, true});
    Session session(std::move(config), {"idle", nullptr});
    std::vector<Subscription> subscriptions;
    for (int i = 0; i < kSubscriptions; ++i) {
      subscriptions.push_back(
          session.FromAny<Block>("channel" + std::to_string(i), Invoke::kSerial, [](const Block&) {}));
    }
    bool connected = true;
    for (int i = 0; i < kSubscriptions; ++i) {
      connected = connected && session.WaitForPublishers("channel" + std::to_string(i), 2, std::chrono::seconds(10));
    }
    if (!connected) std::fprintf(stderr, "the two idle peers did not connect\n");
    std::this_thread::sleep_for(std::chrono::seconds(1));
    const double before = CpuSeconds();
    std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
    Report("idle_cpu_percent", 100 * (CpuSeconds() - before) / seconds, "%");
    Report("idle_rss_mb", ResidentMb(), "MB");
  }
  for (const pid_t peer : peers) {
    kill(peer, SIGKILL);
    waitpid(peer, nullptr, 0);
  }
  return std::system(("rm -rf " + directory).c_str()) == 0 ? 0 : 1;
}

}  // namespace
}  // namespace hgros::bench

int main(int argc, char** argv) {
  const bool quick = argc > 1 && std::string(argv[1]) == "--quick";
  return hgros::bench::Run(quick ? 5 : 10);
}
