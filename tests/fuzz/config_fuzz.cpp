// For any text, the configuration reader returns a configuration or throws ConfigError, in bounded time. The reader
// that keeps all faults finds one if and only if the other one throws.
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "hgros/base/error.hpp"
#include "hgros/config/check.hpp"
#include "hgros/config/config.hpp"

namespace {

void Require(bool condition) {
  if (!condition) std::abort();
}

template <typename List>
bool SortedWithoutRepeats(const List& list) {
  return std::adjacent_find(list.begin(), list.end(), [](const auto& a, const auto& b) { return !(a < b); }) ==
         list.end();
}

bool HasFaults(std::string_view text) {
  static const int file = memfd_create("fuzz", MFD_CLOEXEC);
  Require(ftruncate(file, 0) == 0 && pwrite(file, text.data(), text.size(), 0) == static_cast<ssize_t>(text.size()));
  const std::filesystem::path path = "/proc/self/fd/" + std::to_string(file);
  return !hgros::CheckConfig(std::span(&path, 1)).faults.empty();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  bool accepted = true;
  try {
    const hgros::Config config = hgros::Config::Parse(text, "fuzz");
    Require(SortedWithoutRepeats(config.closed_channels));
    Require(SortedWithoutRepeats(config.security.allowed_clients));
    Require(config.peer_timeout_ms > config.heartbeat_ms);
    for (const auto* side : {&config.publishers, &config.subscribers}) {
      for (const hgros::EndpointConfig& endpoint : *side) {
        Require(endpoint.endpoint.starts_with("tcp://") || endpoint.endpoint.starts_with("ipc://"));
        Require(SortedWithoutRepeats(endpoint.channels));
      }
    }
  } catch (const hgros::ConfigError& error) {
    Require(error.where().starts_with("fuzz"));
    accepted = false;
  }
  Require(accepted != HasFaults(text));
  return 0;
}
