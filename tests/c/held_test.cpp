#include "c/held.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <thread>

#include "support/await.hpp"

namespace hgros::c {
namespace {

using test::Await;

// An object that takes its time to be destroyed.
class Slow {
 public:
  explicit Slow(std::function<void()> at_end) : at_end_(std::move(at_end)) {}
  Slow(const Slow&) = delete;
  Slow& operator=(const Slow&) = delete;
  ~Slow() { at_end_(); }

 private:
  const std::function<void()> at_end_;
};

TEST(CHeld, EndWaitsForAnotherThreadThatDestroysTheObject) {
  std::atomic<bool> destroying{false};
  std::atomic<bool> destroyed{false};
  std::atomic<bool> ends{false};
  test::Door door;
  Held<Slow> held(std::make_unique<Slow>([&] {
    destroying = true;
    door.Pass();
    destroyed = true;
  }));
  std::thread first([&] { held.End(); });
  EXPECT_TRUE(Await([&] { return destroying.load(); }));
  std::thread second([&] {
    ends = true;
    held.End();
    EXPECT_TRUE(destroyed);
  });
  EXPECT_TRUE(Await([&] { return ends.load(); }));
  test::Linger(std::chrono::milliseconds(20));
  door.Open();
  first.join();
  second.join();
}

TEST(CHeld, EndMayBeCalledWhileItsThreadDestroysTheObject) {
  Held<Slow>* again = nullptr;
  Held<Slow> held(std::make_unique<Slow>([&] { again->End(); }));
  again = &held;
  held.End();
}

}  // namespace
}  // namespace hgros::c
