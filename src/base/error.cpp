#include "hgros/base/error.hpp"

namespace hgros {
namespace {

std::string Join(std::string_view what, std::string_view where, std::string_view mend) {
  std::string text;
  if (!where.empty()) text.append(where).append(": ");
  text.append(what);
  if (!mend.empty()) text.append(" ").append(mend);
  return text;
}

}  // namespace

std::string FilePosition::ToString() const {
  std::string text = file;
  if (line > 0) text += ":" + std::to_string(line);
  if (line > 0 && column > 0) text += ":" + std::to_string(column);
  return text;
}

Error::Error(std::string_view what, std::string_view where, std::string_view mend)
    : std::runtime_error(Join(what, where, mend)), where_(where), mend_(mend) {}

ConfigError::ConfigError(std::string_view what, const FilePosition& position, std::string_view mend)
    : Error(what, position.ToString(), mend) {}

}  // namespace hgros
