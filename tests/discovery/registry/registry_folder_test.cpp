#include "discovery/registry/registry_folder.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <string>

#include "discovery/listening.hpp"
#include "hgros/base/error.hpp"

namespace hgros::discovery {
namespace {

namespace fs = std::filesystem;

std::string MakeFault(const RegistryOptions& options) {
  try {
    RegistryFolder(options).Make();
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

class RegistryFolderTest : public testing::Test {
 protected:
  ScratchFolder scratch;
  RegistryOptions options{scratch.path() / "hgros", "robot"};
  fs::path folder = options.folder / options.domain;
};

TEST_F(RegistryFolderTest, IsCreatedForThisUserOnly) {
  EXPECT_EQ(MakeFault(options), "");
  EXPECT_EQ(MakeFault(options), "") << "once more";
  for (const fs::path& path : {options.folder, folder}) {
    struct stat status {};
    ASSERT_EQ(lstat(path.c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 07777, 0700U);
  }
}

TEST_F(RegistryFolderTest, RefusesFolderThatOthersMayWriteTo) {
  ASSERT_EQ(MakeFault(options), "");
  for (const fs::path& path : {folder, options.folder}) {
    ASSERT_EQ(chmod(path.c_str(), 0720), 0);
    EXPECT_NE(MakeFault(options).find("others may write to it"), std::string::npos);
    EXPECT_NE(MakeFault(options).find(path.string()), std::string::npos);
    ASSERT_EQ(chmod(path.c_str(), 0700), 0);
  }
}

TEST_F(RegistryFolderTest, RefusesSymbolicLinksAndFiles) {
  fs::create_directory(scratch.path() / "elsewhere");
  fs::create_directory_symlink(scratch.path() / "elsewhere", options.folder);
  EXPECT_NE(MakeFault(options).find("symbolic link"), std::string::npos);
  EXPECT_TRUE(fs::is_empty(scratch.path() / "elsewhere") || fs::exists(scratch.path() / "elsewhere" / "robot"));
  fs::remove(options.folder);
  std::ofstream(options.folder) << "a file";
  EXPECT_NE(MakeFault(options), "");
}

TEST_F(RegistryFolderTest, RefusesFolderOfAnotherUser) {
  if (geteuid() != 0) GTEST_SKIP() << "giving folders away needs root";
  ASSERT_EQ(MakeFault(options), "");
  ASSERT_EQ(chown(folder.c_str(), 12345, 12345), 0);
  EXPECT_NE(MakeFault(options).find("it belongs to user 12345"), std::string::npos) << MakeFault(options);
}

TEST_F(RegistryFolderTest, RefusesMissingParentFolder) {
  options.folder = scratch.path() / "missing" / "hgros";
  EXPECT_NE(MakeFault(options).find("parent does not exist"), std::string::npos);
}

TEST(Domain, NameMustBeUsableAsAFolderName) {
  for (const char* const good : {"default", "Robot_1", "a", "1.2-x"}) EXPECT_NO_THROW(RequireDomain(good)) << good;
  for (const std::string& bad :
       {std::string(), std::string("."), std::string(".."), std::string(".a"), std::string("a/b"), std::string("a b"),
        std::string("ä"), std::string("a\0b", 3), std::string(kMaxDomainLength + 1, 'a')}) {
    EXPECT_FALSE(IsDomain(bad)) << bad;
    EXPECT_THROW(RequireDomain(bad), Error) << bad;
  }
}

}  // namespace
}  // namespace hgros::discovery
