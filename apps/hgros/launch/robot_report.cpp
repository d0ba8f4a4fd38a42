#include "launch/robot_report.hpp"

#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <string_view>
#include <system_error>
#include <utility>

#include "arguments/command.hpp"
#include "hgros/base/names.hpp"
#include "launch/robot_socket.hpp"

namespace hgros::cli {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kReportSuffix = ".report";
constexpr std::size_t kMostReports = 32;  // Of a domain. The newest ones stay.

fs::path FolderOfReports() {
  const auto variable = [](const char* name) {
    const char* value = std::getenv(name);
    return fs::path(value == nullptr ? "" : value);
  };
  fs::path state = variable("XDG_STATE_HOME");
  if (!state.is_absolute()) state = variable("HOME") / ".local/state";
  return state.is_absolute() ? state / "hgros/robots" / DomainName() : fs::path();
}

// Empty: there is no folder. `ending` is ".new" while it is written.
fs::path PathOfReport(const std::string& robot, std::string_view ending = {}) {
  const fs::path folder = FolderOfReports();
  return folder.empty() ? folder : folder / (robot + std::string(kReportSuffix) + std::string(ending));
}
fs::path PathOfNewReport(const std::string& robot) { return PathOfReport(robot, ".new"); }

}  // namespace

std::unique_ptr<MessageStream> BeginReport(const std::string& robot) {
  const fs::path folder = FolderOfReports();
  std::error_code fault;
  if (!folder.empty()) fs::create_directories(folder, fault);
  if (folder.empty() || fault) return nullptr;
  const int file = open(PathOfNewReport(robot).c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOFOLLOW, 0600);
  return file < 0 ? nullptr : std::make_unique<MessageStream>(file);
}

void KeepReport(const std::string& robot) {
  std::error_code fault;
  fs::rename(PathOfNewReport(robot), PathOfReport(robot), fault);
  const std::vector<std::string> all = RobotsWithReport();
  for (std::size_t i = kMostReports; i < all.size(); ++i) RemoveReport(all[i]);
}

void RemoveReport(const std::string& robot) {
  std::error_code fault;
  fs::remove(PathOfReport(robot), fault);
  fs::remove(PathOfNewReport(robot), fault);
}

std::vector<std::string> RobotsWithReport() {
  std::vector<std::pair<fs::file_time_type, std::string>> found;
  std::error_code fault;
  for (fs::directory_iterator at(FolderOfReports(), fault), end; !fault && at != end; at.increment(fault)) {
    std::string name = at->path().filename().string();
    if (!name.ends_with(kReportSuffix)) continue;
    name.resize(name.size() - kReportSuffix.size());
    std::error_code gone;
    const fs::file_time_type written = at->last_write_time(gone);
    if (!gone) found.emplace_back(written, std::move(name));
  }
  std::ranges::sort(found, std::greater<>());
  std::vector<std::string> robots;
  for (auto& [written, name] : found) robots.push_back(std::move(name));
  return robots;
}

std::optional<RobotReply::End> AskReport(const std::string& robot, const RobotRequest& request,
                                         const std::function<void(const RobotReply& reply)>& hear) {
  if (!request.has_status() && !request.has_logs() && !request.has_wait()) return std::nullopt;
  const int file = open(PathOfReport(robot).c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return std::nullopt;
  MessageStream stream(file);
  while (stream.Read()) {
  }
  struct stat status {};
  (void)fstat(file, &status);
  RobotReply::End fault;
  fault.set_code(kFailed);
  const std::vector<std::string> names(request.logs().names().begin(), request.logs().names().end());
  std::vector<RobotReply::Unit> units;
  RobotReply reply;
  while (stream.Next(reply)) {
    const auto& line = reply.line();
    const bool wanted = names.empty() || std::ranges::find(names, line.process()) != names.end() ||
                        std::ranges::find(names, line.line().component()) != names.end();
    if (reply.has_unit()) units.push_back(reply.unit());
    const bool heard = reply.has_unit() ? request.has_status() : reply.has_line() && request.has_logs() && wanted;
    if (heard && hear) hear(reply);
    if (!reply.has_end()) continue;
    for (const std::string& name : names) {
      fault.set_sentence(UnknownAmong(units, name));
      if (!fault.sentence().empty()) return fault;
    }
    reply.mutable_end()->set_ended_s(status.st_mtim.tv_sec);
    return reply.end();
  }
  fault.set_sentence("The report of the robot \"" + robot + "\" is damaged.");
  return fault;
}

std::string UnknownAmong(const std::vector<RobotReply::Unit>& units, const std::string& name) {
  std::vector<std::string> names;
  for (const RobotReply::Unit& unit : units) {
    names.push_back(unit.name());
    for (const RobotReply::Component& one : unit.components()) names.push_back(one.name());
  }
  if (std::ranges::find(names, name) != names.end()) return {};
  const std::string nearest = NearestName(name, names);
  return "The robot has no component, process or program \"" + name + "\"." +
         (nearest.empty() ? "" : " Did you mean \"" + nearest + "\"?");
}

}  // namespace hgros::cli
