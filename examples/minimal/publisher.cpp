// Says hello once a second to whoever listens: ./publisher publisher.yaml
#include <chrono>
#include <cstdio>
#include <string>
#include <thread>

#include <foxglove/Log.pb.h>
#include <hgros/hgros.hpp>

int main(int argc, char** argv) try {
  hgros::Session session(hgros::Config::Load(argc > 1 ? argv[1] : "publisher.yaml"));
  const auto greetings = session.Advertise<foxglove::Log>("greetings");
  if (!session.WaitForSubscribers("greetings", 1, std::chrono::seconds(30))) return 1;

  for (int i = 1; i <= 5; ++i) {
    auto log = std::make_unique<foxglove::Log>();
    log->set_message("Hello number " + std::to_string(i));
    if (greetings(std::move(log)) != hgros::PublishStatus::kOk) return 1;
    std::this_thread::sleep_for(std::chrono::seconds(i < 5 ? 1 : 0));
  }
} catch (const hgros::Error& error) {  // Configuration, endpoints, types: what, where, and how to mend it.
  std::fprintf(stderr, "%s\n", error.what());
  return 2;
}
