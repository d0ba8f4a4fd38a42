#include "discovery/registry/session_file.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <string>
#include <thread>
#include <vector>

#include "discovery/listening.hpp"
#include "discovery/registry/own_file.hpp"

namespace hgros::discovery {
namespace {

TEST(SessionFile, SurvivesCleanUpWhileItsLivingOwnerReplacesIt) {
  const ScratchFolder scratch;
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

}  // namespace
}  // namespace hgros::discovery
