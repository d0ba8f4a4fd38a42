// For any text, the reader of robot files returns a robot or throws ConfigError, in bounded time. The reader that keeps
// all faults finds one if and only if the other one throws. Whatever is accepted is consistent.
#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <set>
#include <string>
#include <string_view>

#include "hgros/base/error.hpp"
#include "hgros/placement/robot_file.hpp"

namespace {

void Require(bool condition) {
  if (!condition) std::abort();
}

std::optional<std::string> Variable(const std::string& name) {
  if (name == "A") return "1";
  if (name == "B") return "{x: ${A}}";
  return std::nullopt;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  if (text.find("include") != std::string_view::npos) return 0;  // Not files of this machine.
  static const int file = memfd_create("fuzz", MFD_CLOEXEC);
  Require(ftruncate(file, 0) == 0 && pwrite(file, text.data(), text.size(), 0) == static_cast<ssize_t>(text.size()));
  const std::filesystem::path path = "/proc/self/fd/" + std::to_string(file);
  const hgros::RobotFileOptions options{Variable, {{"components.a.params.x", "3", "--set"}}, false};
  bool accepted = true;
  try {
    const hgros::RobotFile robot = hgros::RobotFile::Load(path, options);
    std::set<std::string> placed;
    for (const hgros::RobotProcess& process : robot.processes) {
      for (const std::string& name : process.components) {
        Require(placed.insert(name).second);
        Require(robot.FindComponent(name) != nullptr && robot.FindComponent(name)->process == process.name);
      }
    }
    Require(placed.size() == robot.components.size());
    Require(!robot.components.empty() || !robot.programs.empty());
    for (const hgros::RobotProgram& program : robot.programs) Require(!program.command.empty());
  } catch (const hgros::ConfigError&) {
    accepted = false;
  }
  Require(accepted == hgros::RobotFile::Check(path, options).faults.empty());
  return 0;
}
