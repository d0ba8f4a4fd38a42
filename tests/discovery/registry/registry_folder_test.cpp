// The folder of a registry, what watches it, and the files of sessions in it.
#include "discovery/registry/registry_folder.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <fstream>
#include <future>
#include <thread>

#include "discovery/listening.hpp"
#include "discovery/registry/announcement_file.hpp"
#include "discovery/registry/folder_watch.hpp"
#include "discovery/registry/own_announcement.hpp"
#include "discovery/registry/own_file.hpp"
#include "discovery/registry/session_file.hpp"
#include "hgros/base/error.hpp"
#include "support/error_of.hpp"

namespace hgros::discovery {
namespace {

namespace fs = std::filesystem;

std::string MakeFault(const RegistryOptions& options) {
  return test::ErrorOf([&] { RegistryFolder(options).Make(); });
}

class RegistryFolderTest : public testing::Test, protected OwnDomain {};

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
  fs::create_directory(scratch / "elsewhere");
  fs::create_directory_symlink(scratch / "elsewhere", options.folder);
  EXPECT_NE(MakeFault(options).find("symbolic link"), std::string::npos);
  EXPECT_TRUE(fs::is_empty(scratch / "elsewhere") || fs::exists(scratch / "elsewhere" / "robot"));
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
  options.folder = scratch / "missing" / "hgros";
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

TEST(SessionFile, SurvivesCleanUpWhileItsLivingOwnerReplacesIt) {
  const test::ScratchFolder scratch;
  for (const int cleaners : {1, 2, 4}) {
    OwnFile own(scratch.path(), SessionId::Random());
    std::atomic<bool> done = false;
    std::vector<std::thread> threads;
    for (int i = 0; i < cleaners; ++i) {
      threads.emplace_back([&] {
        while (!done) RemoveStaleFile(own.path());
      });
    }
    int lost = 0;
    for (int i = 0; i < 200; ++i) {
      if (!own.Put(std::to_string(i)) || !own.IsInPlace()) ++lost;
    }
    done = true;
    for (std::thread& thread : threads) thread.join();
    EXPECT_EQ(lost, 0) << cleaners;
    EXPECT_TRUE(own.IsInPlace()) << cleaners;
  }
}

TEST(SessionFile, RecognizesItsNames) {
  const SessionId session = SessionId::Random();
  EXPECT_EQ(SessionOfFile(FileName(session)), session);
  EXPECT_EQ(SessionOfFile(UnfinishedFileName(session)), SessionId{});
  EXPECT_TRUE(IsUnfinished(UnfinishedFileName(session)));
  EXPECT_FALSE(IsUnfinished(FileName(session)));
  EXPECT_FALSE(IsUnfinished(".hidden"));
}

TEST(FolderWatch, MayHaveMissedChangesAndDeathsWhenTheSystemHasDroppedEvents) {
  std::size_t most = 0;
  std::ifstream("/proc/sys/fs/inotify/max_queued_events") >> most;
  if (most == 0 || most > 1'000'000) GTEST_SKIP() << "The system keeps " << most << " events.";
  const test::ScratchFolder scratch;
  Log log;
  FolderWatch watch(log);
  watch.Watch(scratch.path());
  if (watch.fd() < 0) GTEST_SKIP() << "There is no inotify left.";
  // Equal events in a row count as one.
  const auto close_file = [&](const char* name) {
    close(open((scratch / name).c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600));
  };
  close_file("one");
  close_file("other");
  const FolderWatch::News all = watch.Read(2);
  EXPECT_EQ(all.events.size(), 2U);
  EXPECT_FALSE(all.missed || all.deaths);
  for (std::size_t i = 0; i <= most / 2; ++i) {
    close_file("one");
    close_file("other");
  }
  const FolderWatch::News news = watch.Read(2);
  EXPECT_TRUE(news.missed);
  EXPECT_TRUE(news.deaths);
}

// Beside a busy disk, a file may take seconds to write. Here, the thread that writes it stands still in the log.
TEST_F(RegistryFolderTest, AChangeDoesNotWaitForAFileThatIsBeingWritten) {
  std::promise<void> writes;
  std::promise<void> goes_on;
  Log log([&](LogLevel, std::string_view) {
    writes.set_value();
    goes_on.get_future().wait();
  });
  const RegistryFolder own_folder(options);
  OwnAnnouncement announced(own_folder, log);
  Announcement own = NewAnnouncement();
  announced.Announce(own, 0);
  fs::remove_all(folder);
  std::thread writer([&] { announced.RestoreIfLost(); });
  writes.get_future().wait();
  own.process = "changed";
  std::promise<void> told;
  std::thread teller([&] {
    announced.Announce(own, 0);
    told.set_value();
  });
  EXPECT_EQ(told.get_future().wait_for(std::chrono::seconds(10)), std::future_status::ready);
  goes_on.set_value();
  writer.join();
  teller.join();
  const auto written = [&] {
    announced.WriteIfDue();
    return !announced.next_write();
  };
  EXPECT_TRUE(test::Await(written));
  EXPECT_EQ(scratch.Read("hgros/robot/" + FileName(own.session)), EncodeFile(own));
}

}  // namespace
}  // namespace hgros::discovery
