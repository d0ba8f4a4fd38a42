#include "hgros/base/system_limits.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "support/error_of.hpp"
#include "support/no_descriptors.hpp"

namespace hgros::test {
namespace {

TEST(SystemLimits, CountsFreeDescriptors) {
  for (const std::size_t left : {0U, 1U, 5U}) {
    const NoDescriptors few(left);
    EXPECT_EQ(FreeDescriptors(100), left);
    EXPECT_EQ(FreeDescriptors(1), left == 0 ? 0 : 1);
  }
}

TEST(SystemLimits, MissingDescriptorsAreAnErrorWithTheirNumbers) {
  const NoDescriptors few(3);
  EXPECT_NO_THROW(RequireDescriptors(3, "Cannot test"));
  const std::string error = ErrorOf([] { RequireDescriptors(4, "Cannot test"); });
  EXPECT_NE(error.find("Cannot test: the limit of open files ("), std::string::npos) << error;
  EXPECT_NE(error.find("3 more can be opened, and 4 are needed. Raise the limit (ulimit -n)."), std::string::npos)
      << error;
}

struct NoThread {
  explicit NoThread(int) { throw std::system_error(std::make_error_code(std::errc::resource_unavailable_try_again)); }
};

TEST(SystemLimits, AThreadStartsOrIsAnError) {
  std::atomic<bool> ran{false};
  StartThread<std::thread>("a test", [&] { ran = true; }).join();
  EXPECT_TRUE(ran);
  EXPECT_NO_THROW(RequireThreads(20, "a test")) << "they end";
  const std::string error = ErrorOf([] { (void)StartThread<NoThread>("a test", 0); });
  EXPECT_NE(error.find("Cannot start a test: the system gives this process no more threads or memory."),
            std::string::npos)
      << error;
  EXPECT_NE(error.find("ulimit -u"), std::string::npos) << error;
}

}  // namespace
}  // namespace hgros::test
