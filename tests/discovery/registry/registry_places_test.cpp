#include "discovery/registry/registry_places.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <fstream>

#include "discovery/listening.hpp"
#include "discovery/registry/own_file.hpp"
#include "support/error_of.hpp"

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

  test::ScratchFolder scratch;
  const fs::path users = scratch / "users";
  const fs::path temporary = scratch / "temporary";
  const fs::path custom = scratch / "custom";
  const fs::path in_temporary = temporary / ("hgros-" + kUser);
};

TEST_F(PlacesOfAHost, FolderOfTheLoggedInUserIsUsedWithAndWithoutTheVariable) {
  EXPECT_EQ(With({}).Choose("robot"), in_temporary) << "nobody is logged in";
  MakeFolder(users / kUser);
  EXPECT_EQ(With(users / kUser).Choose("robot"), users / kUser / "hgros");
  EXPECT_EQ(With({}).Choose("robot"), users / kUser / "hgros");
  for (const fs::path& bad : {fs::path("relative"), scratch / "missing"}) {
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
  const fs::path linked = scratch / "linked";
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

TEST_F(PlacesOfAHost, LinksToFoldersWithoutSessionsAreRemoved) {
  const auto links = [&] {
    std::size_t count = 0;
    for (const auto& entry : fs::directory_iterator(in_temporary)) count += entry.is_symlink() ? 1 : 0;
    return count;
  };
  const auto age = [&] {
    const timespec times[2] = {{1000, 0}, {1000, 0}};
    for (const auto& entry : fs::directory_iterator(in_temporary)) {
      ASSERT_EQ(utimensat(AT_FDCWD, entry.path().c_str(), times, AT_SYMLINK_NOFOLLOW), 0);
    }
  };
  EXPECT_EQ(With(custom).Choose("robot"), custom / "hgros");
  auto living = Live(custom / "hgros");
  fs::create_symlink(scratch / "gone", in_temporary / ".place-1-2");  // Of another network.
  age();
  (void)With({}).Choose("other");
  EXPECT_EQ(links(), 1U) << "a session lives there";
  living.reset();
  With(custom).Link(custom / "hgros");
  With({}).RemoveStaleLinks();
  EXPECT_EQ(links(), 1U) << "a session is starting";
  age();
  With({}).RemoveStaleLinks();
  EXPECT_EQ(links(), 0U);
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

TEST_F(PlacesOfAHost, RootSaysOnceThatASessionOfAnotherUserHasStartedLater) {
  if (geteuid() != 0) GTEST_SKIP() << "giving folders away needs root";
  setenv("XDG_RUNTIME_DIR", custom.c_str(), 1);
  const std::string domain = "test-" + SessionId::Random().ToString();
  const std::string user = std::to_string(100'000 + RandomId() % 1'000'000);
  const fs::path place = fs::path("/tmp") / ("hgros-" + user);
  KeptLog log;
  Listening listener;
  auto registry = OpenRegistry({.domain = domain}, listener, log.log);
  registry->Announce(NewAnnouncement("root"));
  test::Linger(std::chrono::milliseconds(300));  // It looks once.
  MakeFolder(place / domain);
  auto living = std::make_unique<OwnFile>(place / domain, SessionId::Random());
  EXPECT_TRUE(living->Put("x"));
  for (const fs::path& path : {living->path(), place / domain, place}) {
    EXPECT_EQ(chown(path.c_str(), static_cast<uid_t>(std::stoul(user)), 0), 0);
  }
  const std::vector<std::string> said{"Sessions of user " + user + " in " + place.string(), "do not find each other"};
  EXPECT_TRUE(test::Await([&] { return log.Count(said) > 0; })) << log.text();
  test::Linger(std::chrono::milliseconds(2500));  // It looks again.
  EXPECT_EQ(log.Count(said), 1U) << log.text();
  KeptLog late;
  const auto second = OpenRegistry({.domain = domain}, listener, late.log);
  EXPECT_EQ(late.Count(said), 1U) << "at once: commands end soon; " << late.text();
  registry.reset();
  living.reset();
  fs::remove_all(place);
  unsetenv("XDG_RUNTIME_DIR");
}

TEST_F(PlacesOfAHost, AFullDiskIsNamedWithTheSameFileEachTime) {
  const fs::path place = custom / "robot";
  MakeFolder(place);
  OwnFile file(place, SessionId::Random());
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit small{4096, before.rlim_max};
  setrlimit(RLIMIT_FSIZE, &small);  // Writing fails as on a full disk.
  const auto put = [&] { return file.Put(std::string(1 << 20, 'x')); };
  const std::string first = test::ErrorOf(put);
  const std::string second = test::ErrorOf(put);
  setrlimit(RLIMIT_FSIZE, &before);
  (void)std::signal(SIGXFSZ, handler);
  EXPECT_NE(first.find(file.path().string() + ": "), std::string::npos) << first;
  EXPECT_EQ(first, second);
}

}  // namespace
}  // namespace hgros::discovery
