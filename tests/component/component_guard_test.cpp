#include "component/component_guard.hpp"

#include <gmock/gmock.h>

#include <atomic>
#include <chrono>
#include <future>
#include <string>
#include <thread>

#include "support/await.hpp"

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

}  // namespace
}  // namespace hgros::test
