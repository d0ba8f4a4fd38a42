#include "hgros/base/session_name.hpp"

namespace hgros {

std::string SessionName(SessionId id, std::string_view process, std::int64_t pid, std::string_view host) {
  std::string name = id.ToString() + " (";
  name.append(process).append(", process ").append(std::to_string(pid));
  if (!host.empty()) name.append(" on ").append(host);
  return name + ")";
}

}  // namespace hgros
