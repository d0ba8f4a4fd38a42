#include "discovery/process_stat.hpp"

#include <fstream>
#include <sstream>

namespace hgros::discovery {

// The second field, the name, may contain spaces and parentheses.
std::optional<ProcessStat> ReadProcessStat(const std::string& path) {
  std::ifstream file(path);
  std::string text;
  std::getline(file, text);
  const std::size_t name_end = text.rfind(')');
  if (name_end == std::string::npos) return std::nullopt;
  std::istringstream rest(text.substr(name_end + 1));
  ProcessStat stat;
  rest >> stat.state;
  std::string skipped;
  for (int field = 4; field < 22; ++field) rest >> skipped;
  rest >> stat.start_time;
  return stat;
}

}  // namespace hgros::discovery
