#include "hgros/base/ids.hpp"

#include <sys/random.h>

#include <charconv>
#include <random>

namespace hgros {

std::uint64_t RandomId() {
  std::uint64_t value = 0;
  while (value == 0) {
    if (getrandom(&value, sizeof value, 0) != static_cast<ssize_t>(sizeof value)) {
      std::random_device device;
      value = (std::uint64_t{device()} << 32) | device();
    }
  }
  return value;
}

SessionId SessionId::Random() { return {RandomId()}; }

std::string SessionId::ToString() const {
  constexpr char kDigits[] = "0123456789abcdef";
  std::string text(16, '0');
  for (std::size_t i = 0; i < 16; ++i) text[i] = kDigits[(value >> (60 - 4 * i)) & 0xf];
  return text;
}

SessionId SessionId::FromString(std::string_view text) noexcept {
  SessionId id;
  if (text.size() != 16 || text.find_first_not_of("0123456789abcdef") != std::string_view::npos) return id;
  std::from_chars(text.data(), text.data() + text.size(), id.value, 16);
  return id;
}

}  // namespace hgros
