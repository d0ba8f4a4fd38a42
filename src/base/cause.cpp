#include "hgros/base/cause.hpp"

#include <utility>

namespace hgros {
namespace {

constinit thread_local const Cause* here = nullptr;

}  // namespace

Cause Cause::Here() noexcept { return here == nullptr ? Cause{} : *here; }

// 32-bit FNV-1a with the constants of draft-eastlake-fnv.
std::uint32_t Cause::OriginOf(std::string_view channel) noexcept {
  std::uint32_t hash = 0x811c9dc5U;
  for (const char c : channel) {
    hash ^= static_cast<unsigned char>(c);
    hash *= 0x01000193U;
  }
  return hash == 0 ? 1 : hash;
}

CauseScope::CauseScope(const Cause& cause) noexcept : cause_(cause), outer_(std::exchange(here, &cause_)) {}

CauseScope::~CauseScope() { here = outer_; }

}  // namespace hgros
