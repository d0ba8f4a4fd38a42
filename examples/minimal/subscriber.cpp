// Prints greetings until Ctrl-C: ./subscriber; for another machine: ./subscriber subscriber.yaml
#include <csignal>
#include <cstdio>

#include <foxglove/Log.pb.h>
#include <hgros/hgros.hpp>

int main(int argc, char** argv) try {
  sigset_t stop;  // Ctrl-C and kill. Main waits for them; block them before the session starts its threads.
  sigemptyset(&stop);
  sigaddset(&stop, SIGINT);
  sigaddset(&stop, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &stop, nullptr);

  hgros::Session session(argc > 1 ? hgros::Config::Load(argv[1]) : hgros::Config());
  const auto subscription = session.FromAny<foxglove::Log>(
      "greetings", hgros::Invoke::kSerial, [](const foxglove::Log& log) { std::puts(log.message().c_str()); });

  int signal = 0;
  sigwait(&stop, &signal);
} catch (const hgros::Error& error) {  // Configuration, endpoints, types: what is wrong, where, and the fix.
  std::fprintf(stderr, "%s\n", error.what());
  return 2;
}
