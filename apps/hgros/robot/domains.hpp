#pragma once

#include <sys/types.h>

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hgros/session/session.hpp"

namespace hgros::cli {

class Robot;

/// A domain with its sessions on this host.
struct DomainOnHost {
  std::string name;
  std::filesystem::path folder;
  std::size_t sessions = 0;
  std::size_t stale = 0;            ///< Files of sessions that have ended.
  std::optional<uid_t> other_user;  ///< Whose sessions these are, if they are not those of the user of this command.
};

/// The domains of all users that the registry folders of this host have.
[[nodiscard]] std::vector<DomainOnHost> DomainsOnHost();
/// The domain of this command, which has this session.
[[nodiscard]] std::string DomainOf(const Session& session);
/// One sentence, or two: that no sessions are in the domain `own`, and in which domains there are some. Visible.
[[nodiscard]] std::string NoSessions(const std::string& own);
/// Says that the robot has none of `what`, such as "nodes", or that no sessions are there at all.
void SayNone(Robot& robot, std::string_view what);

}  // namespace hgros::cli
