#include "discovery/registry/folder_watch.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

#include "discovery/listening.hpp"

namespace hgros::discovery {
namespace {

TEST(FolderWatch, MayHaveMissedChangesAndDeathsWhenTheSystemHasDroppedEvents) {
  std::size_t most = 0;
  std::ifstream("/proc/sys/fs/inotify/max_queued_events") >> most;
  if (most == 0 || most > 1'000'000) GTEST_SKIP() << "The system keeps " << most << " events.";
  const ScratchFolder scratch;
  Log log;
  FolderWatch watch(log);
  watch.Watch(scratch.path());
  if (watch.fd() < 0) GTEST_SKIP() << "There is no inotify left.";
  // Equal events in a row count as one.
  const auto close_file = [&](const char* name) {
    close(open((scratch.path() / name).c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600));
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

}  // namespace
}  // namespace hgros::discovery
