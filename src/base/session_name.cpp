#include "hgros/base/session_name.hpp"

#include <unistd.h>

#include <array>

namespace hgros {

std::string SessionName(std::string_view process, std::int64_t pid, std::string_view host) {
  std::string name(process);
  name.append(":").append(std::to_string(pid));
  std::array<char, 256> here{};
  if (!host.empty() && gethostname(here.data(), here.size() - 1) == 0 && host != here.data()) {
    name.append("@").append(host);
  }
  return name;
}

}  // namespace hgros
