// Files in a registry's folder that are not valid announcements.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <deque>
#include <fstream>

#include "discovery/listening.hpp"
#include "discovery/registry/announcement_file.hpp"
#include "discovery/registry/own_file.hpp"
#include "discovery/registry/session_file.hpp"
#include "hgros/base/own_descriptor.hpp"
#include "hgros/discovery/registry.hpp"

namespace hgros::discovery {
namespace {

using test::Await;
namespace fs = std::filesystem;

class HostileFile : public testing::Test, protected OwnDomain {
 protected:
  HostileFile() : registry(OpenRegistry(options, listening, log.log)) {}
  ~HostileFile() override {
    registry.reset();
    EXPECT_EQ(listening.broken(), "");
  }

  /// Moves the file at `from` to the place of a session's file.
  [[nodiscard]] fs::path MoveIn(const fs::path& from) const {
    const fs::path name = folder / FileName(SessionId::Random());
    fs::rename(from, name);
    return name;
  }

  KeptLog log;
  KeptLog other_log;  // The other registry logs the same.
  Listening listening;
  std::unique_ptr<Discovery> registry;
};

TEST_F(HostileFile, IsIgnoredAndLoggedOnceWithTheReasonWhileOthersComeAndGo) {
  std::vector<std::pair<fs::path, std::string>> reasons;
  fs::create_directory(scratch / "folder");
  reasons.emplace_back(MoveIn(scratch / "folder"), "not a regular file");
  OwnFile elsewhere(scratch.path(), SessionId::Random());
  ASSERT_TRUE(elsewhere.Put(EncodeFile(NewAnnouncement())));
  fs::create_symlink(elsewhere.path(), scratch / "link");
  reasons.emplace_back(MoveIn(scratch / "link"), "symbolic link");
  ASSERT_EQ(mkfifo((scratch / "pipe").c_str(), 0600), 0);
  reasons.emplace_back(MoveIn(scratch / "pipe"), "not a regular file");
  ASSERT_EQ(chmod(scratch.Write("file", "anything").c_str(), 0666), 0);
  reasons.emplace_back(MoveIn(scratch / "file"), "others may write");
  if (geteuid() == 0) {  // Giving files away needs root.
    ASSERT_EQ(chown(scratch.Write("file", "anything").c_str(), 12345, 12345), 0);
    reasons.emplace_back(MoveIn(scratch / "file"), "belongs to user 12345");
  }
  // Files of living sessions.
  const Announcement another = NewAnnouncement();
  std::deque<OwnFile> living;
  for (const auto& [content, reason] : std::vector<std::pair<std::string, std::string>>{
           {std::string(kMaxFileBytes + 1, 'x'), "more than"},
           {"\xff\xff\xff garbage", "not an announcement"},
           {"", "not an announcement"},
           {EncodeFile(another), "announces session " + another.session.ToString()}}) {
    ASSERT_TRUE(living.emplace_back(folder, SessionId::Random()).Put(content));
    reasons.emplace_back(living.back().path(), reason);
  }
  for (int i = 0; i < 3; ++i) {
    Listening other_listening;
    const auto other = OpenRegistry(options, other_listening, other_log.log);
    const Announcement own = NewAnnouncement();
    other->Announce(own);
    EXPECT_TRUE(listening.AwaitPeer(own));
    EXPECT_EQ(registry->List(), std::vector{own});
  }
  EXPECT_TRUE(listening.AwaitCount(0));
  for (const auto& one : reasons) {
    const std::string path = one.first.string();
    EXPECT_TRUE(Await([&] { return log.Count({path, one.second}) == 1; })) << one.second << "\n" << log.text();
    EXPECT_EQ(log.Count({path}), 1U) << log.text();
    EXPECT_TRUE(fs::exists(fs::symlink_status(path))) << "the registry must not remove it";
  }
}

TEST_F(HostileFile, FileWithoutASessionNameIsLeftAlone) {
  for (const char* const name : {"README", "0123456789abcde", "0123456789ABCDEF", "0000000000000000", ".hidden"}) {
    std::ofstream(folder / name) << "anything";
    Listening other_listening;
    const auto other = OpenRegistry(options, other_listening, other_log.log);
    EXPECT_TRUE(other->List().empty());
    EXPECT_TRUE(fs::exists(folder / name));
  }
  EXPECT_EQ(log.text() + other_log.text(), "");
}

TEST_F(HostileFile, UnlockedFileIsRemoved) {
  const fs::path one = MoveIn(scratch.Write("one", "anything"));
  const fs::path two = MoveIn(scratch.Write("two", EncodeFile(NewAnnouncement())));
  EXPECT_TRUE(Await([&] { return !fs::exists(one) && !fs::exists(two); }));
  std::ofstream(folder / UnfinishedFileName(SessionId::Random())) << "half of it";
  EXPECT_TRUE(Await([&] { return IsEmptyOrGone(folder); }));
  EXPECT_TRUE(listening.here().empty());
  EXPECT_EQ(log.text(), "");
}

TEST_F(HostileFile, SessionEndsWhenTheLockIsReleasedAfterClosing) {
  const Announcement own = NewAnnouncement();
  const fs::path elsewhere = scratch.Write("file", EncodeFile(own));
  const OwnDescriptor file([&] { return open(elsewhere.c_str(), O_RDWR | O_CLOEXEC); });
  ASSERT_TRUE(TakeLock(file.get()));
  fs::rename(elsewhere, folder / FileName(own.session));
  ASSERT_TRUE(listening.AwaitPeer(own));
  // As when the kernel closes the file of a dead process, but slowly: first the event, then the lock.
  close(open((folder / FileName(own.session)).c_str(), O_WRONLY | O_CLOEXEC));
  test::Linger(std::chrono::milliseconds(20));
  struct flock unlock {};
  unlock.l_type = F_UNLCK;
  ASSERT_EQ(fcntl(file.get(), F_OFD_SETLK, &unlock), 0);
  EXPECT_TRUE(listening.AwaitCount(0));
}

TEST_F(HostileFile, FileIsReadOnceItIsValid) {
  const Announcement own = NewAnnouncement();
  OwnFile file(folder, own.session);
  ASSERT_TRUE(file.Put("garbage"));
  ASSERT_TRUE(Await([&] { return log.Count({file.path().string()}) == 1; }));
  ASSERT_TRUE(file.Put(EncodeFile(own)));
  EXPECT_TRUE(listening.AwaitPeer(own));
}

TEST_F(HostileFile, SessionEndsWhenItsFileCanNoLongerBeTrusted) {
  const Announcement own = NewAnnouncement();
  OwnFile file(folder, own.session);
  ASSERT_TRUE(file.Put(EncodeFile(own)));
  ASSERT_TRUE(listening.AwaitPeer(own));
  // Another process opens the file for writing and closes it. Its owner is still alive.
  close(open(file.path().c_str(), O_WRONLY | O_CLOEXEC));
  const Announcement other = NewAnnouncement();
  OwnFile other_file(folder, other.session);
  ASSERT_TRUE(other_file.Put(EncodeFile(other)));
  ASSERT_TRUE(listening.AwaitPeer(other));
  EXPECT_EQ(listening.gone(own.session), "");
  ASSERT_EQ(chmod(file.path().c_str(), 0666), 0);
  close(open(file.path().c_str(), O_WRONLY | O_CLOEXEC));
  EXPECT_TRUE(listening.AwaitCount(1));
  EXPECT_NE(listening.gone(own.session).find("trusted"), std::string::npos);
}

}  // namespace
}  // namespace hgros::discovery
