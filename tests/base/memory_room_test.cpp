#include "hgros/base/memory_room.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include "support/scratch_folder.hpp"

namespace hgros::memory_room_test {
namespace {

constexpr std::uint64_t kMega = 1u << 20;

/// The kernel's files about a process and its groups, written by hand.
class MemoryGroup : public testing::Test {
 protected:
  void Write(const std::string& path, const std::string& text) const {
    std::filesystem::create_directories((folder / path).parent_path());
    (void)folder.Write(path, text);
  }
  void Unified(const std::string& group, const std::string& limit, std::uint64_t usage, std::uint64_t cached) const {
    Write(group + "/memory.max", limit + "\n");
    Write(group + "/memory.current", std::to_string(usage) + "\n");
    Write(group + "/memory.stat", "anon 5\ninactive_file " + std::to_string(cached) + "\nactive_file 0\nshmem 7\n");
  }
  void Mounted(const std::string& root, const std::string& kind = "cgroup2",
               const std::string& options = "nsdelegate") const {
    Write("mountinfo", "22 1 0:20 / /proc rw - proc proc rw\n35 31 0:32 " + root + " " + (folder / "top").string() +
                           " rw,relatime shared:9 - " + kind + " cgroup rw," + options + "\n");
  }
  /// The process is in this group of the unified hierarchy.
  void InGroup(const std::string& group, const std::string& root = "/") const {
    Write("cgroup", "0::" + group + "\n");
    Mounted(root);
  }
  [[nodiscard]] std::optional<std::uint64_t> Room() const { return MemoryGroupRoom(folder.path().string()); }

  const test::ScratchFolder folder;
};

TEST_F(MemoryGroup, ReturnsNothingWithoutALimit) {
  EXPECT_EQ(Room(), std::nullopt);
  InGroup("/robot");
  EXPECT_EQ(Room(), std::nullopt);
  Unified("top/robot", "max", kMega, 0);
  EXPECT_EQ(Room(), std::nullopt);
}

TEST_F(MemoryGroup, ReturnsTheRoomOfTheFullestGroup) {
  InGroup("/robots/robot");
  Unified("top/robots/robot", "max", 10 * kMega, 0);
  Unified("top/robots", std::to_string(160 * kMega), 100 * kMega, 0);
  EXPECT_EQ(Room(), 40 * kMega) << "an eighth stays free for other needs";
  Unified("top/robots/robot", std::to_string(32 * kMega), 20 * kMega, 0);
  EXPECT_EQ(Room(), 4 * kMega);
  Unified("top/robots/robot", std::to_string(32 * kMega), 31 * kMega, 0);
  EXPECT_EQ(Room(), 0u);
  InGroup("/cached");
  Unified("top/cached", std::to_string(160 * kMega), 160 * kMega, 100 * kMega);
  EXPECT_EQ(Room(), 80 * kMega) << "cached files count as free";
}

TEST_F(MemoryGroup, ReadsGroupsOfCgroupVersionOne) {
  Write("cgroup", "9:cpu:/other\n4:hugetlb,memory:/docker/robot\n0::/\n");
  Mounted("/docker", "cgroup", "memory,hugetlb");
  Write("top/robot/memory.limit_in_bytes", std::to_string(160 * kMega));
  Write("top/robot/memory.usage_in_bytes", std::to_string(100 * kMega));
  Write("top/robot/memory.stat", "inactive_file 5\ntotal_inactive_file " + std::to_string(20 * kMega) +
                                     "\ntotal_active_file " + std::to_string(10 * kMega) + "\n");
  Write("top/memory.limit_in_bytes", "9223372036854771712");
  Write("top/memory.usage_in_bytes", "5");
  EXPECT_EQ(Room(), 70 * kMega);
}

TEST_F(MemoryGroup, ReadsAContainersOwnGroup) {
  InGroup("/docker/robot", "/docker/robot");
  Unified("top", std::to_string(160 * kMega), 100 * kMega, 0);
  EXPECT_EQ(Room(), 40 * kMega);
  InGroup("/");
  EXPECT_EQ(Room(), 40 * kMega);
}

TEST(MemoryRoom, ALimitOfTheAddressSpaceCounts) {
  const std::optional<std::uint64_t> before = FreeMemory();
  ASSERT_TRUE(before);
  EXPECT_GT(*before, kMega);
  rlimit limit{};
  ASSERT_EQ(getrlimit(RLIMIT_AS, &limit), 0);
  std::uint64_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  const rlimit small{pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE)) + 32 * kMega, limit.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_AS, &small), 0);
  const std::optional<std::uint64_t> after = FreeMemory();
  ASSERT_EQ(setrlimit(RLIMIT_AS, &limit), 0);
  EXPECT_LE(after, 32 * kMega);
}

TEST(MemoryRoom, WhatIsWrittenToIsResident) {
  const std::uint64_t before = ResidentBytes();
  EXPECT_GT(before, 0U);
  const std::vector<char> written(64 * kMega, 'x');
  EXPECT_GE(ResidentBytes(), before + 60 * kMega) << written.size();
}

}  // namespace
}  // namespace hgros::memory_room_test
