#include "viewer/data/channels/type_conflict.hpp"

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <map>
#include <set>
#include <utility>

#include "viewer/data/cut_text.hpp"

namespace hgros::viewer {
namespace {

constexpr std::size_t kMostNamed = 4;  ///< Programs that use one type.

/// A type as one of its users knows it. A user with an unknown version (0) agrees with every version.
using Version = std::pair<std::string, std::uint64_t>;

struct Users {
  std::set<std::string> publish;
  std::set<std::string> subscribe;
};

std::string Listed(const std::set<std::string>& names) {
  std::string list;
  std::size_t named = 0;
  for (const std::string& name : names) {
    if (++named > kMostNamed) return list + " and " + std::to_string(names.size() - kMostNamed) + " more";
    list += (list.empty() ? "" : ", ") + std::string(CutText(name));
  }
  return list;
}

std::string Named(const Version& type, bool with_version) {
  std::string text(CutText(type.first));
  if (!with_version || type.second == 0) return text;
  char version[32];
  std::snprintf(version, sizeof version, " (schema %016llx)", static_cast<unsigned long long>(type.second));
  return text + version;
}

}  // namespace

std::string TypeConflict(const KnownChannel& channel) {
  std::map<Version, Users> types;
  std::set<std::string> names;
  const auto add = [&](const std::vector<ChannelUser>& users, std::set<std::string> Users::*side) {
    for (const ChannelUser& user : users) {
      if (user.type_name.empty()) continue;
      names.insert(user.type_name);
      (types[{user.type_name, user.fingerprint}].*side).insert(user.process.empty() ? "(no name)" : user.process);
    }
  };
  add(channel.publishers, &Users::publish);
  add(channel.subscribers, &Users::subscribe);
  const auto versions = std::ranges::count_if(types, [](const auto& type) { return type.first.second != 0; });
  if (names.size() < 2 && versions < 2) return {};
  std::string text;
  for (const auto& [type, users] : types) {
    text += (text.empty() ? "" : "; ") + Named(type, names.size() < 2) + " is";
    if (!users.publish.empty()) text += " published by " + Listed(users.publish);
    if (!users.publish.empty() && !users.subscribe.empty()) text += ", and";
    if (!users.subscribe.empty()) text += " subscribed to by " + Listed(users.subscribe);
  }
  return "Its users do not agree on the type: " + text + ". " +
         (names.size() < 2 ? "Messages pass only between compatible schemas."
                           : "No messages pass between different types.");
}

}  // namespace hgros::viewer
