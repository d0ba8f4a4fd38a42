// Prints five greetings: ./subscriber subscriber.yaml
#include <cstdio>
#include <semaphore>

#include <foxglove/Log.pb.h>
#include <hgros/hgros.hpp>

int main(int argc, char** argv) try {
  hgros::Session session(hgros::Config::Load(argc > 1 ? argv[1] : "subscriber.yaml"));
  std::counting_semaphore<> received{0};
  const auto subscription =
      session.FromAny<foxglove::Log>("greetings", hgros::Invoke::kSerial, [&](const foxglove::Log& log) {
        std::puts(log.message().c_str());
        received.release();
      });

  for (int i = 0; i < 5; ++i) {
    if (!received.try_acquire_for(std::chrono::seconds(30))) return 1;
  }
} catch (const hgros::Error& error) {  // Configuration, endpoints, types: what, where, and how to mend it.
  std::fprintf(stderr, "%s\n", error.what());
  return 2;
}
