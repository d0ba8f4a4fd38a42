// Publishes a greeting once a second until Ctrl-C: ./publisher; for another machine: ./publisher publisher.yaml
#include <csignal>
#include <cstdio>
#include <ctime>
#include <string>

#include <foxglove/Log.pb.h>
#include <hgros/hgros.hpp>

int main(int argc, char** argv) try {
  sigset_t stop;  // Ctrl-C and kill. Main waits for them; block them before the session starts its threads.
  sigemptyset(&stop);
  sigaddset(&stop, SIGINT);
  sigaddset(&stop, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &stop, nullptr);

  hgros::Session session(argc > 1 ? hgros::Config::Load(argv[1]) : hgros::Config());
  const auto greetings = session.Advertise<foxglove::Log>("greetings");

  const timespec one_second{1, 0};
  for (int i = 1; sigtimedwait(&stop, nullptr, &one_second) < 0; ++i) {
    auto log = std::make_unique<foxglove::Log>();
    log->set_message("Hello number " + std::to_string(i));
    if (greetings(std::move(log)) != hgros::PublishStatus::kOk) return 1;
  }
} catch (const hgros::Error& error) {  // Configuration, endpoints, types: what is wrong, where, and the fix.
  std::fprintf(stderr, "%s\n", error.what());
  return 2;
}
