#include "transport/shm/memory/memory.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cstdint>
#include <fstream>
#include <string>

namespace hgros::shm {
namespace {

TEST(ShmMemory, SegmentIsZeroedSealedAndReadOnlyForOthers) {
  const Segment made = MakeSegment("hgros-test", 5000, Access::kOwnerOnly, Pages::kAtOnce);
  ASSERT_NE(made.mapping, nullptr) << made.fault;
  EXPECT_EQ(made.mapping->bytes().size(), 8192u);
  made.mapping->bytes()[4999] = std::byte{7};
  EXPECT_NE(ftruncate(made.handle.fd(), 0), 0);
  EXPECT_NE(ftruncate(made.handle.fd(), 1 << 20), 0);
  std::string fault;
  const auto read = MapForeign(made.handle, 0, false, fault);
  ASSERT_NE(read, nullptr) << fault;
  EXPECT_EQ(read->bytes()[4999], std::byte{7});
  if ((fcntl(made.handle.fd(), F_GET_SEALS) & 0x10) != 0) {
    EXPECT_EQ(MapForeign(made.handle, 0, true, fault), nullptr);
  }
}

void ExpectRefused(const Handle& handle, std::size_t size_bytes, const std::string& why) {
  std::string fault;
  EXPECT_EQ(MapForeign(handle, size_bytes, false, fault), nullptr);
  EXPECT_NE(fault.find(why), std::string::npos) << fault;
}

TEST(ShmMemory, RefusesFilesThatAreNotSealedMemory) {
  ExpectRefused(Handle(), 1, "not a memory file");
  int ends[2];
  ASSERT_EQ(pipe(ends), 0);
  ExpectRefused(Handle(ends[0]), 1, "not a memory file");
  ExpectRefused(Handle(ends[1]), 1, "not a memory file");
  ExpectRefused(Handle(open("/proc/self/exe", O_RDONLY | O_CLOEXEC)), 1, "not a memory file");
  const Handle loose(memfd_create("loose", MFD_CLOEXEC | MFD_ALLOW_SEALING));
  ASSERT_EQ(ftruncate(loose.fd(), 4096), 0);
  ExpectRefused(loose, 1, "not a memory file");
  ASSERT_EQ(fcntl(loose.fd(), F_ADD_SEALS, F_SEAL_SHRINK), 0);
  ExpectRefused(loose, 1, "not a memory file");
  ASSERT_EQ(fcntl(loose.fd(), F_ADD_SEALS, F_SEAL_GROW), 0);
  ExpectRefused(loose, 4097, "4096 bytes instead of 4097");
  const Handle empty(memfd_create("empty", MFD_CLOEXEC | MFD_ALLOW_SEALING));
  ASSERT_EQ(fcntl(empty.fd(), F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW), 0);
  ExpectRefused(empty, 0, "0 bytes");
}

TEST(ShmMemory, ASegmentWithHolesIsRefusedBeforeItUsesUpMemory) {
  const Handle sparse(memfd_create("sparse", MFD_CLOEXEC | MFD_ALLOW_SEALING));
  ASSERT_EQ(ftruncate(sparse.fd(), off_t{1} << 40), 0);
  ASSERT_EQ(fcntl(sparse.fd(), F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW), 0);
  ExpectRefused(sparse, 0, "holes");
  std::string fault;
  const auto page = MapForeign(sparse, 5000, false, fault);  // Only the size of the page is mapped.
  ASSERT_NE(page, nullptr) << fault;
  EXPECT_EQ(page->bytes().size(), 8192u);
}

TEST(ShmMemory, SaysWhetherOnlyRoomIsMissing) {
  constexpr std::size_t kSize = 256 << 20;
  const Segment made = MakeSegment("hgros-test", kSize, Access::kOwnerOnly, Pages::kAtOnce);
  ASSERT_NE(made.mapping, nullptr) << made.fault;
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_AS, &before), 0);
  std::uint64_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  const rlimit tight{pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE)) + kSize / 2, before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_AS, &tight), 0);
  std::string fault;
  bool no_room = false;
  const auto mapping = MapForeign(made.handle, 0, false, fault, &no_room);
  ASSERT_EQ(setrlimit(RLIMIT_AS, &before), 0);
  EXPECT_EQ(mapping, nullptr);
  EXPECT_TRUE(no_room) << fault;
  no_room = false;
  EXPECT_EQ(MapForeign(Handle(), 1, false, fault, &no_room), nullptr);
  EXPECT_FALSE(no_room) << "it is no memory file";
  EXPECT_NE(MapForeign(made.handle, 0, false, fault, &no_room), nullptr);
}

}  // namespace
}  // namespace hgros::shm
