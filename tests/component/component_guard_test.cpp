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
  const auto callback = [&] { guard.Run([&] { ++ran; }); };
  std::jthread one(callback);
  std::jthread other(callback);
  EXPECT_TRUE(Await([&] { return told > 0; }));
  EXPECT_EQ(ran, 0);
  returns.set_value();
  one.join();
  other.join();
  EXPECT_EQ(ran, 2);
  EXPECT_EQ(told, 1);
  EXPECT_THAT(sentence, HasSubstr("Its Save() has not returned after 1 s."));
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
        guard.Run([&] {
          Linger(std::chrono::milliseconds(2));
          guard.Run([&] { ++ran; });
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
    guard.Run([&] {
      begun = true;
      ends.wait(false);
    });
  });
  ASSERT_TRUE(Await([&] { return begun.load(); }));
  const auto now = std::chrono::steady_clock::now();
  std::jthread saving(
      [&] { EXPECT_TRUE(guard.TryAlone(now + std::chrono::seconds(2), [] {})) << "others had to wait for it"; });
  ASSERT_TRUE(Await([&] { return std::chrono::steady_clock::now() > now + std::chrono::milliseconds(1100); }));
  guard.Run([] {});
  ends = true;
  ends.notify_all();
}

}  // namespace
}  // namespace hgros::test
