#include "component/component_guard.hpp"

#include <gmock/gmock.h>

#include <atomic>
#include <chrono>
#include <future>
#include <string>
#include <thread>
#include <vector>

#include "support/await.hpp"
#include "support/seed.hpp"

namespace hgros::test {
namespace {

using testing::HasSubstr;

TEST(ComponentGuardTest, TellsOnceThatSavingDoesNotReturn) {
  std::atomic<int> told = 0;
  std::string sentence;
  ComponentGuard guard(
      true, {}, [](const std::string&) {},
      [&](const std::string& said) {
        sentence = said;
        ++told;
      });
  std::promise<void> returns;
  std::promise<void> begun;
  std::jthread saving([&] {
    EXPECT_TRUE(guard.TryAlone(std::chrono::steady_clock::now() + kPatience, [&] {
      begun.set_value();
      returns.get_future().wait();
    }));
  });
  begun.get_future().wait();
  std::atomic<int> ran = 0;
  const auto callback = [&] { guard.Run("node", [&] { ++ran; }); };
  std::jthread one(callback);
  std::jthread other(callback);
  EXPECT_TRUE(Await([&] { return told > 0; }));
  EXPECT_EQ(ran, 0);
  returns.set_value();
  one.join();
  other.join();
  EXPECT_EQ(ran, 2);
  EXPECT_EQ(told, 1);
  EXPECT_THAT(sentence, HasSubstr("Saving it has taken more than 1 s so far."));
}

TEST(ComponentGuardTest, NamesTheNodeOfALateCallback) {
  std::vector<std::string> told;
  ComponentGuard guard(
      false, std::chrono::milliseconds(1), [](const std::string&) {},
      [&](const std::string& sentence) { told.push_back(sentence); });
  guard.Run("detector/image", [&] {
    Linger(std::chrono::milliseconds(2));
    guard.NoteHanging();
  });
  guard.Run("detector/image", [] { Linger(std::chrono::milliseconds(2)); });
  ASSERT_EQ(told.size(), 2U);
  EXPECT_THAT(told[0],
              testing::MatchesRegex("Callback of node \"detector/image\" has run for .*s\\. Its deadline is 1\\.0 "
                                    "ms\\."));
  EXPECT_THAT(told[1], HasSubstr("Callback of node \"detector/image\" took "));
}

// On several threads, so that one runs at any time; each of them also runs one inside another one.
TEST(ComponentGuardTest, SavesBetweenCallbacksThatFollowEachOtherWithoutAPause) {
  ComponentGuard guard(
      true, {}, [](const std::string&) {}, [](const std::string&) {});
  std::atomic<bool> ends = false;
  std::atomic<int> ran = 0;
  std::vector<std::jthread> threads;
  for (int i = 0; i < 3; ++i) {
    threads.emplace_back([&] {
      while (!ends) {
        guard.Run("node", [&] {
          Linger(std::chrono::milliseconds(2));
          guard.Run("node", [&] { ++ran; });
        });
      }
    });
  }
  for (int i = 0; i < Rounds(1, 2); ++i) {
    const int before = ran;
    ASSERT_TRUE(Await([&] { return ran > before + 10; }));
    int saved = -1;
    EXPECT_TRUE(guard.TryAlone(std::chrono::steady_clock::now() + std::chrono::seconds(2), [&] {
      saved = ran;
      std::this_thread::yield();
      EXPECT_EQ(ran, saved);
    }));
  }
  ends = true;
}

TEST(ComponentGuardTest, OthersBeginBesideACallbackThatIsTooLongForASave) {
  ComponentGuard guard(
      true, {}, [](const std::string&) {}, [](const std::string&) {});
  std::atomic<bool> begun = false;
  std::atomic<bool> ends = false;
  std::jthread planner([&] {
    guard.Run("node", [&] {
      begun = true;
      ends.wait(false);
    });
  });
  ASSERT_TRUE(Await([&] { return begun.load(); }));
  const auto now = std::chrono::steady_clock::now();
  std::jthread saving(
      [&] { EXPECT_TRUE(guard.TryAlone(now + std::chrono::seconds(2), [] {})) << "others had to wait for it"; });
  ASSERT_TRUE(Await([&] { return std::chrono::steady_clock::now() > now + std::chrono::milliseconds(1100); }));
  guard.Run("node", [] {});
  ends = true;
  ends.notify_all();
}

}  // namespace
}  // namespace hgros::test
