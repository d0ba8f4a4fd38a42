#include "hgros/base/cause.hpp"

#include <utility>

#include "hgros/base/thread_cause.hpp"
#include "hgros/base/thread_local.hpp"

namespace hgros {

constinit HGROS_THREAD_LOCAL const Cause* thread_cause = nullptr;

Cause Cause::Here() noexcept { return thread_cause == nullptr ? Cause{} : *thread_cause; }

// 32-bit FNV-1a with the constants of draft-eastlake-fnv.
std::uint32_t Cause::OriginOf(std::string_view channel) noexcept {
  std::uint32_t hash = 0x811c9dc5U;
  for (const char c : channel) {
    hash ^= static_cast<unsigned char>(c);
    hash *= 0x01000193U;
  }
  return hash == 0 ? 1 : hash;
}

CauseScope::CauseScope(const Cause& cause) noexcept : cause_(cause), outer_(std::exchange(thread_cause, &cause_)) {}

CauseScope::~CauseScope() { thread_cause = outer_; }

}  // namespace hgros
