// Files in a registry's folder that are not valid announcements.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "discovery/listening.hpp"
#include "discovery/registry/announcement_file.hpp"
#include "discovery/registry/own_file.hpp"
#include "discovery/registry/session_file.hpp"
#include "hgros/announcement.pb.h"
#include "hgros/base/own_descriptor.hpp"
#include "hgros/discovery/registry.hpp"

namespace hgros::discovery {
namespace {

using test::Await;
namespace fs = std::filesystem;

class HostileFile : public testing::Test {
 protected:
  HostileFile() : registry(OpenRegistry(options, listening, log.log)) {}
  ~HostileFile() override {
    registry.reset();
    EXPECT_EQ(listening.broken(), "");
  }

  /// Expects that the file is ignored, and logged once with these words, while other sessions come and go.
  void ExpectIgnored(const fs::path& path, const std::string& words) {
    for (int i = 0; i < 3; ++i) {
      Listening other_listening;
      const auto other = OpenRegistry(options, other_listening, other_log.log);
      const Announcement own = NewAnnouncement();
      other->Announce(own);
      EXPECT_TRUE(listening.AwaitPeer(own));
      EXPECT_EQ(registry->List(), std::vector{own});
    }
    EXPECT_TRUE(listening.AwaitCount(0));
    EXPECT_TRUE(Await([&] { return log.Count({path.string(), words}) == 1; })) << log.text();
    EXPECT_EQ(log.Count({path.string()}), 1U) << log.text();
    EXPECT_TRUE(fs::exists(fs::symlink_status(path))) << "the registry must not remove it";
  }
  /// A living session whose file contains `content`.
  void ExpectContentIgnored(const std::string& content, const std::string& words) {
    const SessionId session = SessionId::Random();
    OwnFile file(folder, session);
    ASSERT_TRUE(file.Put(content));
    ExpectIgnored(file.path(), words);
  }
  [[nodiscard]] fs::path NewName() const { return folder / FileName(SessionId::Random()); }
  /// Moves the file at `from` to the place of a session's file.
  [[nodiscard]] fs::path MoveIn(const fs::path& from) const {
    const fs::path name = NewName();
    fs::rename(from, name);
    return name;
  }

  ScratchFolder scratch;
  RegistryOptions options{scratch.path() / "hgros", "robot"};
  fs::path folder = options.folder / options.domain;
  KeptLog log;
  KeptLog other_log;  // The other registry logs the same.
  Listening listening;
  std::unique_ptr<Discovery> registry;
};

TEST_F(HostileFile, FolderIsIgnored) {
  fs::create_directory(scratch.path() / "folder");
  ExpectIgnored(MoveIn(scratch.path() / "folder"), "not a regular file");
}

TEST_F(HostileFile, SymbolicLinkIsIgnored) {
  OwnFile elsewhere(scratch.path(), SessionId::Random());
  ASSERT_TRUE(elsewhere.Put(EncodeFile(NewAnnouncement())));
  fs::create_symlink(elsewhere.path(), scratch.path() / "link");
  ExpectIgnored(MoveIn(scratch.path() / "link"), "symbolic link");
}

TEST_F(HostileFile, PipeIsIgnored) {
  ASSERT_EQ(mkfifo((scratch.path() / "pipe").c_str(), 0600), 0);
  ExpectIgnored(MoveIn(scratch.path() / "pipe"), "not a regular file");
}

TEST_F(HostileFile, FileWritableByOthersIsIgnored) {
  std::ofstream(scratch.path() / "file") << "anything";
  ASSERT_EQ(chmod((scratch.path() / "file").c_str(), 0666), 0);
  ExpectIgnored(MoveIn(scratch.path() / "file"), "others may write");
}

TEST_F(HostileFile, FileOfAnotherUserIsIgnored) {
  if (geteuid() != 0) GTEST_SKIP() << "giving files away needs root";
  std::ofstream(scratch.path() / "file") << "anything";
  ASSERT_EQ(chown((scratch.path() / "file").c_str(), 12345, 12345), 0);
  ExpectIgnored(MoveIn(scratch.path() / "file"), "belongs to user 12345");
}

TEST_F(HostileFile, HugeFileIsIgnored) { ExpectContentIgnored(std::string(kMaxFileBytes + 1, 'x'), "more than"); }

TEST_F(HostileFile, GarbageIsIgnored) {
  ExpectContentIgnored("\xff\xff\xff garbage", "not an announcement");
  ExpectContentIgnored("", "not an announcement");
}

TEST_F(HostileFile, FileOfAnotherVersionIsIgnored) {
  wire::AnnouncementFile file;
  ASSERT_TRUE(file.ParseFromString(EncodeFile(NewAnnouncement())));
  file.set_version(kFileVersion + 1);
  ExpectContentIgnored(file.SerializeAsString(), "version 2");
}

TEST_F(HostileFile, FileThatNamesAnotherSessionIsIgnored) {
  const Announcement other = NewAnnouncement();
  ExpectContentIgnored(EncodeFile(other), "announces session " + other.session.ToString());
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
  std::ofstream(scratch.path() / "one") << "anything";
  std::ofstream(scratch.path() / "two") << EncodeFile(NewAnnouncement());
  const fs::path one = MoveIn(scratch.path() / "one");
  const fs::path two = MoveIn(scratch.path() / "two");
  EXPECT_TRUE(Await([&] { return !fs::exists(one) && !fs::exists(two); }));
  std::ofstream(folder / UnfinishedFileName(SessionId::Random())) << "half of it";
  EXPECT_TRUE(Await([&] { return IsEmptyOrGone(folder); }));
  EXPECT_TRUE(listening.here().empty());
  EXPECT_EQ(log.text(), "");
}

TEST_F(HostileFile, SessionEndsWhenTheLockIsReleasedAfterClosing) {
  const Announcement own = NewAnnouncement();
  const fs::path elsewhere = scratch.path() / "file";
  std::ofstream(elsewhere) << EncodeFile(own);
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
