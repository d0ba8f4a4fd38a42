// Structs of options: their versions, and what is refused.
#include "c/c_fixture.hpp"

namespace hgros::test {
namespace {

using COptions = CTest;

TEST_F(COptions, StructsOfAnEarlierVersionAreReadAsFarAsTheyGo) {
  hgros_subscribe_options options{};
  options.keep_last = 1;
  options.keep_all = 7;  // Behind the end of the earlier struct.
  options.size = offsetof(hgros_subscribe_options, keep_all);
  hgros_subscription* queue = nullptr;
  ASSERT_EQ(hgros_subscribe_queue(session.get(), "c", &options, &queue), HGROS_OK) << LastError();
  const SubscriptionHandle owned(queue);
  hgros_subscription_stats stats{};
  stats.queued = 99;
  stats.size = offsetof(hgros_subscription_stats, queued);
  EXPECT_EQ(hgros_subscription_get_stats(queue, &stats), HGROS_OK);
  EXPECT_EQ(stats.queued, 99U) << "fields beyond the size are not written";
  options.size = 0;
  EXPECT_EQ(hgros_subscribe_queue(session.get(), "c", &options, &queue), HGROS_INVALID_ARGUMENT);
  EXPECT_NE(LastError().find("sizeof"), std::string::npos) << LastError();
}

// What a program compiled with a later version passes.
template <class T>
struct Later {
  T known{};
  std::uint64_t unknown = 0;

  Later() { known.size = sizeof *this; }
};

TEST_F(COptions, FieldsOfALaterVersionAreRefusedUnlessTheyAreZero) {
  Later<hgros_subscribe_options> options;
  hgros_subscription* queue = nullptr;
  ASSERT_EQ(hgros_subscribe_queue(session.get(), "c", &options.known, &queue), HGROS_OK) << LastError();
  const SubscriptionHandle owned(queue);
  Later<hgros_subscription_stats> stats;
  stats.unknown = 99;
  EXPECT_EQ(hgros_subscription_get_stats(queue, &stats.known), HGROS_OK);
  EXPECT_EQ(stats.unknown, 0U);
  options.unknown = std::uint64_t{1} << 63U;
  EXPECT_EQ(hgros_subscribe_queue(session.get(), "c", &options.known, &queue), HGROS_INVALID_ARGUMENT);
  EXPECT_NE(LastError().find("byte " + std::to_string(sizeof options - 1)), std::string::npos) << LastError();
  options.known.size = std::size_t{1} << 40U;
  EXPECT_EQ(hgros_subscribe_queue(session.get(), "c", &options.known, &queue), HGROS_INVALID_ARGUMENT) << "garbage";
}

TEST_F(COptions, LogIsReleasedIfTheSessionIsRefusedOrHasNoUseForIt) {
  std::atomic<int> released{0};
  Later<hgros_session_options> options;
  options.known.log = [](void*, int32_t, const char*) {};
  options.known.log_user = &released;
  options.known.log_release = [](void* user) { ++*static_cast<std::atomic<int>*>(user); };
  hgros_session* opened = nullptr;
  EXPECT_EQ(hgros_session_open("", &options.known, nullptr), HGROS_INVALID_ARGUMENT);
  EXPECT_EQ(released, 1);
  options.unknown = 1;
  EXPECT_EQ(hgros_session_open("", &options.known, &opened), HGROS_INVALID_ARGUMENT);
  EXPECT_EQ(released, 2);
  EXPECT_EQ(hgros_session_open_files(nullptr, 1, &options.known, &opened), HGROS_INVALID_ARGUMENT);
  EXPECT_EQ(released, 3);
  options.unknown = 0;
  EXPECT_EQ(hgros_session_open("netwrok: {}", &options.known, &opened), HGROS_CONFIG_ERROR);
  EXPECT_EQ(released, 4);
  options.known.log = nullptr;
  ASSERT_EQ(hgros_session_open(DomainYaml().c_str(), &options.known, &opened), HGROS_OK) << LastError();
  EXPECT_EQ(released, 5);
  hgros_session_close(opened);
  EXPECT_EQ(released, 5);
}

TEST_F(COptions, ThoseWithoutAnEffectAreRefused) {
  const auto refused = [&](const char* field, const hgros_subscribe_options& options) {
    hgros_subscription* queue = nullptr;
    EXPECT_EQ(hgros_subscribe_queue(session.get(), "c", &options, &queue), HGROS_INVALID_ARGUMENT) << field;
    EXPECT_NE(LastError().find(field), std::string::npos) << LastError();
  };
  auto options = Sized<hgros_subscribe_options>();
  options.executor = HGROS_EXECUTOR_DEDICATED;
  refused("executor", options);
  options.executor = 17;
  refused("executor", options);
  options.executor = 0;
  options.keep_all_bytes = 1;
  refused("keep_all_bytes", options);
  auto timing = Sized<hgros_timer_options>();
  timing.first_ns = -1;
  hgros_timer* timer = nullptr;
  EXPECT_EQ(hgros_timer_open(
                session.get(), "t", 1, &timing, [](void*, const hgros_tick*) {}, nullptr, nullptr, &timer),
            HGROS_INVALID_ARGUMENT);
  EXPECT_NE(LastError().find("first_ns"), std::string::npos) << LastError();
}

}  // namespace
}  // namespace hgros::test
