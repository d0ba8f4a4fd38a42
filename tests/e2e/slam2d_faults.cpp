// A program with four faults beside the SLAM demo, until SIGTERM: it takes a channel with the wrong type, misspells
// one, has a callback that takes longer than the time between messages, and a queue that is always full.
#include <condition_variable>
#include <csignal>
#include <cstdio>
#include <mutex>

#include <foxglove/Log.pb.h>
#include <foxglove/PoseInFrame.pb.h>
#include <hgros/hgros.hpp>

namespace {

using foxglove::PoseInFrame;

// A callback that takes this long.
void Work(std::chrono::milliseconds time) {
  std::mutex mutex;
  std::unique_lock lock(mutex);
  std::condition_variable never;
  never.wait_for(lock, time, [] { return false; });
}

hgros::NodeOptions Node(const char* name, hgros::Queue queue) {
  return {.name = name, .queue = queue, .executor = hgros::Executor::Dedicated()};
}

}  // namespace

int main() try {
  sigset_t stop;
  sigemptyset(&stop);
  sigaddset(&stop, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &stop, nullptr);
  hgros::Session session(hgros::Config(), {.name = "faulty"});
  // Not on a channel of the demo, which ends if a type there does not fit.
  hgros::Session reporter(hgros::Config(), {.name = "reporter"});
  const auto report = reporter.Advertise<PoseInFrame>("report");
  const auto wrong_type = session.FromAny<foxglove::Log>("report", hgros::Invoke::kSerial, [](const foxglove::Log&) {});
  const auto misspelled = session.FromAny<PoseInFrame>("trajectroy", hgros::Invoke::kSerial, [](const PoseInFrame&) {});
  const auto slow = session.FromAny<PoseInFrame>(
      "trajectory", hgros::Invoke::kSerial, [](const PoseInFrame&) { Work(std::chrono::milliseconds(150)); },
      Node("slow", hgros::Queue::Latest()));
  const auto full = session.FromAny<PoseInFrame>(
      "trajectory", hgros::Invoke::kSerial, [](const PoseInFrame&) { Work(std::chrono::milliseconds(300)); },
      Node("full", hgros::Queue::KeepLast(4)));
  int signal = 0;
  (void)sigwait(&stop, &signal);
  return 0;
} catch (const hgros::Error& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 2;
}
