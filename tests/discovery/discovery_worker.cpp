// A process that announces sessions until its standard input ends, or it is killed.
//
//   discovery_worker FOLDER DOMAIN SESSIONS [fork]
// Writes "ready" to standard output when all are announced and see each other. With "fork" it forks a child that does
// not call exec and lives until standard input ends; then it writes "ready PID", with the child's pid.
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string_view>
#include <vector>

#include "hgros/discovery/registry.hpp"
#include "support/await.hpp"

namespace {

class Deaf final : public hgros::DiscoveryListener {
  void OnCame(const hgros::Announcement&) override {}
  void OnChanged(const hgros::Announcement&) override {}
  void OnGone(const hgros::Announcement&, std::string_view) override {}
};

void AwaitEndOfInput() {
  char byte = 0;
  while (read(STDIN_FILENO, &byte, 1) > 0) {
  }
}

}  // namespace

int main(int count, char** arguments) {
  if (count < 4) return 2;
  const hgros::RegistryOptions options{arguments[1], arguments[2]};
  const auto sessions = static_cast<std::size_t>(std::atoi(arguments[3]));
  Deaf listener;
  hgros::Log log;
  std::vector<std::unique_ptr<hgros::Discovery>> registries;
  for (std::size_t i = 0; i < sessions; ++i) {
    registries.push_back(hgros::OpenRegistry(options, listener, log));
    registries.back()->Announce(hgros::AnnouncementOfThisProcess(hgros::SessionId::Random(), 1));
  }
  for (const auto& registry : registries) {
    if (!hgros::test::Await([&] { return registry->List().size() + 1 >= sessions; })) return 1;
  }
  pid_t child = 0;
  if (count > 4) {
    child = fork();
    if (child == 0) {
      AwaitEndOfInput();
      _exit(0);
    }
  }
  std::printf("ready %d\n", static_cast<int>(child));
  (void)std::fflush(stdout);
  AwaitEndOfInput();
  return 0;
}
