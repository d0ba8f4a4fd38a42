#pragma once

#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

#include "hgros/base/memory_room.hpp"
#include "support/await.hpp"

namespace hgros::resilience {

/// A memory control group below our own, if one can be made.
class SmallGroup {
 public:
  explicit SmallGroup(std::uint64_t limit_bytes) {
    const auto place = FindMemoryGroup();
    if (place.folder.empty()) {
      why_not = "no memory control group is mounted";
      return;
    }
    folder = place.folder + "/hgros-test-" + std::to_string(getpid());
    if (place.unified) std::ofstream(place.folder + "/cgroup.subtree_control") << "+memory" << std::flush;
    std::error_code error;
    made_ = std::filesystem::create_directory(folder, error);
    const std::string limit = folder + (place.unified ? "/memory.max" : "/memory.limit_in_bytes");
    if (!made_ || !std::filesystem::exists(limit) || !(std::ofstream(limit) << limit_bytes << std::flush)) {
      why_not = "no memory control group can be made below " + place.folder;
    }
  }
  SmallGroup(const SmallGroup&) = delete;
  SmallGroup& operator=(const SmallGroup&) = delete;
  // While a process in the group is still ending, its folder cannot be removed.
  ~SmallGroup() {
    (void)(!made_ || test::Await([this] { return rmdir(folder.c_str()) == 0; }));
  }

  std::string folder;
  std::string why_not;

 private:
  bool made_ = false;
};

}  // namespace hgros::resilience
