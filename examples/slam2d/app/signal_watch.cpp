#include "signal_watch.hpp"

#include <pthread.h>
#include <signal.h>
#include <unistd.h>

#include <utility>

namespace slam2d {
namespace {

constexpr int kEndOfWatch = SIGUSR1;

}  // namespace

SignalWatch::SignalWatch(std::function<void(int)> on_signal) {
  sigset_t signals;
  sigemptyset(&signals);
  for (const int signal : {SIGINT, SIGTERM, kEndOfWatch}) sigaddset(&signals, signal);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  thread_ = std::thread([signals, on_signal = std::move(on_signal)] {
    for (bool again = false;; again = true) {
      int signal = 0;
      if (sigwait(&signals, &signal) != 0 || signal == kEndOfWatch) return;
      if (again) _exit(128 + signal);
      on_signal(signal);
    }
  });
}

SignalWatch::~SignalWatch() {
  pthread_kill(thread_.native_handle(), kEndOfWatch);
  thread_.join();
}

}  // namespace slam2d
