#include "discovery/registry/registry_places.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>
#include <memory>
#include <string>

#include "discovery/listening.hpp"
#include "discovery/registry/own_file.hpp"

namespace hgros::discovery {
namespace {

namespace fs = std::filesystem;

const std::string kUser = std::to_string(geteuid());

/// A host with its own /run/user and /tmp.
class PlacesOfAHost : public testing::Test {
 protected:
  PlacesOfAHost() {
    for (const fs::path& folder : {users, temporary, custom}) MakeFolder(folder);
  }
  static void MakeFolder(const fs::path& folder) {
    fs::create_directories(folder);
    fs::permissions(folder, fs::perms::owner_all);
  }
  [[nodiscard]] RegistryPlaces With(const fs::path& runtime) const {
    return RegistryPlaces({runtime, users, temporary});
  }
  /// A session that lives there.
  static std::unique_ptr<OwnFile> Live(const fs::path& place) {
    MakeFolder(place / "robot");
    auto file = std::make_unique<OwnFile>(place / "robot", SessionId::Random());
    EXPECT_TRUE(file->Put("x"));
    return file;
  }

  ScratchFolder scratch;
  const fs::path users = scratch.path() / "users";
  const fs::path temporary = scratch.path() / "temporary";
  const fs::path custom = scratch.path() / "custom";
  const fs::path in_temporary = temporary / ("hgros-" + kUser);
};

TEST_F(PlacesOfAHost, FolderOfTheLoggedInUserIsUsedWithAndWithoutTheVariable) {
  EXPECT_EQ(With({}).Choose("robot"), in_temporary) << "nobody is logged in";
  MakeFolder(users / kUser);
  EXPECT_EQ(With(users / kUser).Choose("robot"), users / kUser / "hgros");
  EXPECT_EQ(With({}).Choose("robot"), users / kUser / "hgros");
  for (const fs::path& bad : {fs::path("relative"), scratch.path() / "missing"}) {
    EXPECT_EQ(With(bad).Choose("robot"), users / kUser / "hgros") << bad;
  }
  fs::permissions(custom, fs::perms::all);
  EXPECT_EQ(With(custom).Choose("robot"), users / kUser / "hgros") << "others may write to it";
}

TEST_F(PlacesOfAHost, SessionsWithAndWithoutTheVariableMeetInEitherOrder) {
  for (const bool logged_in : {false, true}) {
    if (logged_in) MakeFolder(users / kUser);
    const fs::path without = logged_in ? users / kUser / "hgros" : in_temporary;
    {
      EXPECT_EQ(With(custom).Choose("robot"), custom / "hgros");
      const auto living = Live(custom / "hgros");
      EXPECT_EQ(With({}).Choose("robot"), custom / "hgros") << "joins the living session";
      EXPECT_EQ(With({}).Choose("other"), without) << "another domain";
    }
    EXPECT_EQ(With({}).Choose("robot"), without) << "the session has ended";
    const auto living = Live(without);
    EXPECT_EQ(With(custom).Choose("robot"), without) << "joins the living session";
  }
}

TEST_F(PlacesOfAHost, SessionThatStartedBeforeTheLoginIsJoined) {
  const auto living = Live(With({}).Choose("robot"));
  MakeFolder(users / kUser);
  EXPECT_EQ(With(users / kUser).Choose("robot"), in_temporary);
}

TEST_F(PlacesOfAHost, SessionsThatStartedInTwoFoldersAreReported) {
  const auto one = Live(in_temporary);
  EXPECT_TRUE(With({}).FindElsewhere(in_temporary, "robot").empty());
  MakeFolder(users / kUser);
  const auto two = Live(users / kUser / "hgros");
  const auto elsewhere = With({}).FindElsewhere(in_temporary, "robot");
  ASSERT_EQ(elsewhere.size(), 1U);
  EXPECT_EQ(elsewhere[0].folder, users / kUser / "hgros" / "robot");
  EXPECT_EQ(elsewhere[0].user, geteuid());
}

TEST_F(PlacesOfAHost, OneFolderWithTwoPathsIsNotReported) {
  MakeFolder(users / kUser);
  const fs::path linked = scratch.path() / "linked";
  fs::create_directory_symlink(users, linked);
  const RegistryPlaces places = With(linked / kUser);
  const fs::path chosen = places.Choose("robot");
  EXPECT_EQ(chosen, linked / kUser / "hgros");
  const auto living = Live(chosen);
  EXPECT_TRUE(places.FindElsewhere(chosen, "robot").empty());
}

TEST_F(PlacesOfAHost, LinkStaysWhileItsFirstSessionStarts) {
  EXPECT_EQ(With(custom).Choose("robot"), custom / "hgros");
  (void)With({}).Choose("robot");  // It removes links to folders that do not exist.
  const auto living = Live(custom / "hgros");
  EXPECT_EQ(With({}).Choose("robot"), custom / "hgros");
}

TEST_F(PlacesOfAHost, NameThatAnotherUserHasTakenDoesNotDenyDiscovery) {
  std::ofstream(in_temporary.string()) << "taken";
  fs::create_directory_symlink(scratch.path(), in_temporary.string() + "-1");
  MakeFolder(in_temporary.string() + "-2");
  fs::permissions(in_temporary.string() + "-2", fs::perms::all);
  EXPECT_EQ(With({}).Choose("robot"), in_temporary.string() + "-3");
  EXPECT_EQ(With({}).Choose("robot"), in_temporary.string() + "-3") << "for each session the same";
}

TEST_F(PlacesOfAHost, RootSeesSessionsOfOthers) {
  if (geteuid() != 0) GTEST_SKIP() << "giving folders away needs root";
  const auto living = Live(users / "12345" / "hgros");
  for (const fs::path& path : {living->path(), living->path().parent_path(), users / "12345" / "hgros"}) {
    ASSERT_EQ(chown(path.c_str(), 12345, 12345), 0);
  }
  const auto elsewhere = With({}).FindElsewhere(With({}).Choose("robot"), "robot");
  ASSERT_EQ(elsewhere.size(), 1U);
  EXPECT_EQ(elsewhere[0].user, 12345U);
  EXPECT_TRUE(With({}).FindElsewhere(in_temporary, "other").empty());
}

}  // namespace
}  // namespace hgros::discovery
