#include "viewer/scene/type_mismatch.hpp"

#include <algorithm>
#include <string_view>

namespace hgros::viewer {
namespace {

// "foxglove.PoseInFrame or foxglove.Odometry"
std::string SchemasOf(const DisplayType& type) {
  std::string list;
  for (const std::string& schema : type.schemas) list += (list.empty() ? "" : " or ") + schema;
  return list;
}

}  // namespace

std::string WhyNotShown(const DisplayType& type, const std::string& channel, const std::string& carried) {
  if (type.schemas.empty() || carried.empty() || std::ranges::find(type.schemas, carried) != type.schemas.end()) {
    return {};
  }
  const bool vowel = std::string_view("AEIOU").find(type.name.front()) != std::string_view::npos;
  return "\"" + channel + "\" carries " + carried + "; " + (vowel ? "an " : "a ") + type.name + " shows " +
         SchemasOf(type) + ".";
}

}  // namespace hgros::viewer
