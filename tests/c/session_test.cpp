#include <poll.h>

#include "c/c_fixture.hpp"

namespace hgros::test {
namespace {

using CSession = CTest;

TEST_F(CSession, NullArgumentsGiveACodeAndASentence) {
  EXPECT_EQ(hgros_session_open("", nullptr, nullptr), HGROS_INVALID_ARGUMENT);
  EXPECT_NE(LastError().find("NULL"), std::string::npos);
  hgros_publisher* publisher = nullptr;
  EXPECT_EQ(hgros_publisher_open(nullptr, "c", nullptr, nullptr, &publisher), HGROS_INVALID_ARGUMENT);
  EXPECT_EQ(LastError(), "session is NULL.");
  hgros_subscription* subscription = nullptr;
  EXPECT_EQ(hgros_subscribe(nullptr, "c", nullptr, nullptr, nullptr, nullptr, &subscription), HGROS_INVALID_ARGUMENT);
  EXPECT_EQ(hgros_publish(nullptr, "x", 1), HGROS_INVALID_ARGUMENT);
  EXPECT_EQ(hgros_loan_open(nullptr, 1, nullptr), HGROS_INVALID_ARGUMENT);
  EXPECT_EQ(hgros_loan_publish(nullptr, 0), HGROS_INVALID_ARGUMENT);
  EXPECT_EQ(hgros_queue_take(nullptr, 0, nullptr), HGROS_INVALID_ARGUMENT);
  hgros_message* kept = nullptr;
  EXPECT_EQ(hgros_message_keep(nullptr, &kept), HGROS_INVALID_ARGUMENT);
  EXPECT_EQ(hgros_message_keep(nullptr, nullptr), HGROS_INVALID_ARGUMENT);
  EXPECT_EQ(hgros_call(nullptr, "s", nullptr, nullptr, 0, nullptr, 0, nullptr), HGROS_INVALID_ARGUMENT);
  EXPECT_EQ(hgros_reply_set(nullptr, nullptr, 0), HGROS_INVALID_ARGUMENT);
  EXPECT_EQ(hgros_params_get_number(nullptr, "p", nullptr), HGROS_INVALID_ARGUMENT);
  EXPECT_EQ(hgros_transforms_lookup(nullptr, "a", "b", nullptr), HGROS_INVALID_ARGUMENT);
  EXPECT_EQ(hgros_simulated_clock_step(nullptr, 1), HGROS_INVALID_ARGUMENT);
  EXPECT_EQ(hgros_peers_get(nullptr, 0, nullptr), HGROS_INVALID_ARGUMENT);
  EXPECT_EQ(hgros_schema_create(nullptr, HGROS_ENCODING_CUSTOM, 0, nullptr, 0, nullptr), HGROS_INVALID_ARGUMENT);
  hgros_session_close(nullptr);
  hgros_subscription_close(nullptr);
  hgros_message_free(nullptr);
  EXPECT_EQ(hgros_message_data(nullptr, nullptr), nullptr);
  EXPECT_EQ(hgros_queue_descriptor(nullptr), -1);
}

TEST_F(CSession, ConfigurationErrorsNameLineAndFix) {
  session.reset();  // Its threads may read the environment.
  hgros_session* opened = nullptr;
  EXPECT_EQ(hgros_session_open("netwrok: {}", nullptr, &opened), HGROS_CONFIG_ERROR);
  ASSERT_EQ(setenv("HGROS_CONFIG", "netwrk: {}", 1), 0);
  EXPECT_EQ(hgros_session_open(nullptr, nullptr, &opened), HGROS_CONFIG_ERROR);
  EXPECT_NE(LastError().find("HGROS_CONFIG:1:1"), std::string::npos) << LastError();
  ASSERT_EQ(unsetenv("HGROS_CONFIG"), 0);
  EXPECT_EQ(opened, nullptr);
  EXPECT_NE(LastError().find("network"), std::string::npos) << LastError();
  EXPECT_NE(LastError().find(":1:1"), std::string::npos) << LastError();
}

TEST_F(CSession, ReadsAndMergesFiles) {
  const ScratchFolder folder;
  const std::string one = folder.Write("one.yaml", yaml + "\n");
  const std::string two = folder.Write("two.yaml", "channels: {words: {latched: 1}}\n");
  const std::string missing = folder / "three.yaml";
  const char* const files[] = {one.c_str(), two.c_str(), missing.c_str()};
  hgros_session* opened = nullptr;
  ASSERT_EQ(hgros_session_open_files(files, 2, nullptr, &opened), HGROS_OK) << LastError();
  session.reset(opened);
  EXPECT_EQ(Publish(Publisher(session, "words", text), "latched by the file"), HGROS_OK);
  EXPECT_EQ(Take(Queue(session, "words"), 0), "latched by the file");
  EXPECT_EQ(hgros_session_open_files(files + 2, 1, nullptr, &opened), HGROS_CONFIG_ERROR) << LastError();
  EXPECT_NE(LastError().find("three.yaml"), std::string::npos) << LastError();
}

TEST_F(CSession, LastErrorBelongsToItsThread) {
  EXPECT_EQ(hgros_publish(nullptr, nullptr, 0), HGROS_INVALID_ARGUMENT);
  std::string there = "unset";
  std::thread([&] { there = LastError(); }).join();
  EXPECT_EQ(there, "");
  EXPECT_EQ(LastError(), "publisher is NULL.");
  EXPECT_STREQ(hgros_status_name(HGROS_FULL), "full");
  EXPECT_STREQ(hgros_status_name(12345), "unknown");
}

TEST_F(CSession, LogSinkGetsLinesOfTheSessionAndIsReleasedWithIt) {
  struct Sink {
    LogLines lines;
    std::atomic<int> released{0};
  } sink;
  auto options = Sized<hgros_session_options>();
  options.log = [](void* user, int32_t level, const char* line) {
    EXPECT_EQ(level, HGROS_LOG_WARNING);
    LogLines::Add(&static_cast<Sink*>(user)->lines, level, line);
  };
  options.log_user = &sink;
  options.log_release = [](void* user) { ++static_cast<Sink*>(user)->released; };
  hgros_session* opened = nullptr;
  ASSERT_EQ(hgros_session_open(DomainYaml().c_str(), &options, &opened), HGROS_OK);
  ASSERT_EQ(hgros_session_set_log_level(opened, HGROS_LOG_WARNING), HGROS_OK);
  EXPECT_EQ(hgros_session_log(opened, HGROS_LOG_INFO, "not written"), HGROS_OK);
  EXPECT_EQ(hgros_session_log(opened, HGROS_LOG_WARNING, "written"), HGROS_OK);
  EXPECT_EQ(hgros_session_log(opened, 17, "x"), HGROS_INVALID_ARGUMENT);
  for (int i = 0; i < 100; ++i) {
    const std::string line = "again " + std::to_string(i);
    EXPECT_EQ(hgros_session_log_limited(opened, HGROS_LOG_WARNING, "again", line.c_str()), HGROS_OK);
  }
  EXPECT_EQ(hgros_session_log_limited(opened, HGROS_LOG_WARNING, nullptr, "x"), HGROS_INVALID_ARGUMENT);
  EXPECT_TRUE(sink.lines.Contain("again 9"));
  EXPECT_FALSE(sink.lines.Contain("again 10"));
  EXPECT_TRUE(sink.lines.Contain("written"));
  EXPECT_FALSE(sink.lines.Contain("not written"));
  hgros_session_close(opened);
  EXPECT_EQ(sink.released, 1);
}

TEST_F(CSession, ClosingItClosesWhatWasMadeFromIt) {
  const auto publisher = Publisher(session, "words", text);
  const auto queue = Queue(session, "words");
  hgros_transforms* transforms = nullptr;
  ASSERT_EQ(hgros_transforms_open(session.get(), &transforms), HGROS_OK);
  std::thread taking([&] { EXPECT_EQ(Take(queue, -1), "<closed>"); });
  std::thread waiting([&] {
    hgros_transform found;
    EXPECT_EQ(hgros_transforms_wait(transforms, "map", "base", 1, -1, &found), HGROS_CLOSED) << LastError();
  });
  Linger(std::chrono::milliseconds(20));
  session.reset();
  taking.join();
  waiting.join();
  EXPECT_EQ(Publish(publisher, "late"), HGROS_CLOSED);
  hgros_loan* loan = nullptr;
  EXPECT_EQ(hgros_loan_open(publisher.get(), 1, &loan), HGROS_CLOSED);
  hgros_transform pose{};
  EXPECT_EQ(hgros_transforms_lookup(transforms, "a", "b", &pose), HGROS_CLOSED);
  EXPECT_EQ(hgros_transforms_close(transforms), HGROS_OK);
}

TEST_F(CSession, EndWakesAllThatWaitAndLeavesTheHandleValid) {
  const auto other = OpenOther();
  const auto publisher = Publisher(session, "words", text);
  const auto queue = Queue(session, "numbers");
  const auto full = Queue(session, "words", 1);
  ASSERT_EQ(Publish(publisher, "fills the queue"), HGROS_OK);
  hgros_transforms* transforms = nullptr;
  ASSERT_EQ(hgros_transforms_open(session.get(), &transforms), HGROS_OK);
  hgros_params* params = nullptr;
  EXPECT_EQ(hgros_params_of(session.get(), "nobody", -1, &params), HGROS_INVALID_ARGUMENT) << "closing would hang";
  ASSERT_EQ(hgros_params_of(session.get(), "nobody", INT64_MAX, &params), HGROS_OK);
  hgros_message* reply = nullptr;
  hgros_transform found;
  double number = 0;
  const std::vector<std::function<hgros_status()>> waits = {
      [&] { return hgros_session_sleep_until(session.get(), INT64_MAX); },
      [&] { return hgros_session_wait_for_subscribers(session.get(), "words", 9, -1); },
      [&] { return hgros_session_wait_for_publishers(session.get(), "words", 9, -1); },
      [&] { return hgros_wait_for_service(session.get(), "nobody", -1); },
      [&] { return hgros_publish_wait(publisher.get(), "x", 1, -1); },
      [&] { return hgros_call(session.get(), "nobody", text.get(), "x", 1, nullptr, -1, &reply); },
      [&] { return hgros_transforms_wait(transforms, "map", "base", 1, -1, &found); },
      [&] { return hgros_params_get_number(params, "speed", &number); },
      [&] { return Take(queue, -1) == "<closed>" ? HGROS_CLOSED : HGROS_ERROR; },
  };
  std::atomic<std::size_t> waiting{0};
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < waits.size(); ++i) {
    threads.emplace_back([&, i] {
      ++waiting;
      EXPECT_EQ(waits[i](), HGROS_CLOSED) << i << ": " << LastError();
    });
  }
  ASSERT_TRUE(Await([&] { return waiting == waits.size(); }));
  Linger(std::chrono::milliseconds(20));
  hgros_session_end(session.get());
  for (std::thread& one : threads) one.join();
  for (const auto& wait : waits) EXPECT_EQ(wait(), HGROS_CLOSED) << LastError();
  EXPECT_EQ(hgros_session_wait_idle(session.get(), -1), HGROS_CLOSED);
  EXPECT_EQ(hgros_session_log(session.get(), HGROS_LOG_INFO, "after the end"), HGROS_OK);
  EXPECT_TRUE(log.Contain("after the end"));
  EXPECT_STREQ(hgros_session_name(session.get()), "robot");
  EXPECT_EQ(Publish(publisher, "late"), HGROS_CLOSED);
  hgros_subscription* late = nullptr;
  EXPECT_EQ(hgros_subscribe_queue(session.get(), "words", nullptr, &late), HGROS_CLOSED);
  pollfd one{hgros_queue_descriptor(full.get()), POLLIN, 0};
  EXPECT_EQ(poll(&one, 1, 0), 1) << "an event loop must notice the end";
  hgros_session_end(session.get());
  EXPECT_EQ(hgros_params_close(params), HGROS_OK);
  EXPECT_EQ(hgros_transforms_close(transforms), HGROS_OK);
}

TEST_F(CSession, CallbackMayEndItButNotWaitUntilItIsIdle) {
  std::atomic<hgros_status> idle{-1};
  const auto end = [&](const hgros_message*) {
    const hgros_status waited = hgros_session_wait_idle(session.get(), -1);
    hgros_session_end(session.get());
    idle = waited;
  };
  const auto owned = Subscribe(session, "words", end);
  std::thread sleeping([&] { EXPECT_EQ(hgros_session_sleep_until(session.get(), INT64_MAX), HGROS_CLOSED); });
  EXPECT_EQ(Publish(Publisher(session, "words", text), "end"), HGROS_OK);
  sleeping.join();
  ASSERT_TRUE(Await([&] { return idle != -1; }));
  EXPECT_EQ(idle, HGROS_WOULD_DEADLOCK);
}

TEST_F(CSession, QueueThatIsEndedWakesItsTaker) {
  const auto queue = Queue(session, "words");
  std::thread taking([&] { EXPECT_EQ(Take(queue, -1), "<closed>"); });
  Linger(std::chrono::milliseconds(20));
  hgros_subscription_end(queue.get());
  taking.join();
  pollfd one{hgros_queue_descriptor(queue.get()), POLLIN, 0};
  EXPECT_EQ(poll(&one, 1, 0), 1) << "an event loop must notice the end";
}

TEST_F(CSession, CallbackMayPublishButNotWait) {
  const auto publisher = Publisher(session, "out", text);
  const auto queue = Queue(session, "out", 1);
  std::atomic<hgros_status> waited{-1};
  const auto relay = [&](const hgros_message* message) {
    EXPECT_EQ(Publish(publisher, TextOf(message)), HGROS_OK);
    waited = hgros_publish_wait(publisher.get(), "x", 1, -1);
  };
  const auto owned = Subscribe(session, "in", relay);
  EXPECT_EQ(Publish(Publisher(session, "in", text), "relayed"), HGROS_OK);
  ASSERT_TRUE(Await([&] { return waited != -1; }));
  EXPECT_EQ(waited, HGROS_WOULD_DEADLOCK);
  EXPECT_EQ(Take(queue, 0), "relayed");
}

TEST_F(CSession, ListsPeersAndChannelsWithTheirUsers) {
  const auto other = OpenOther();
  const auto queue = Queue(session, "words");
  const auto publisher = Publisher(other, "words", text);
  ASSERT_EQ(hgros_session_wait_for_publishers(session.get(), "words", 1, -1), HGROS_OK);
  EXPECT_EQ(hgros_session_wait_for_publishers(session.get(), "words", 2, 0), HGROS_TIMED_OUT);
  hgros_peers* peers = nullptr;
  ASSERT_EQ(hgros_peers_open(session.get(), &peers), HGROS_OK);
  auto peer = Sized<hgros_peer>();
  ASSERT_EQ(hgros_peers_count(peers), 1U);
  EXPECT_EQ(hgros_peers_get(peers, 0, &peer), HGROS_OK);
  EXPECT_STREQ(peer.process, "other");
  EXPECT_EQ(peer.id, hgros_session_id(other.get()));
  EXPECT_EQ(peer.pid, getpid());
  EXPECT_EQ(hgros_peers_get(peers, 1, &peer), HGROS_NOT_FOUND);
  hgros_peers_free(peers);
  std::string publishers;
  ASSERT_TRUE(Await([&] {
    hgros_channels* channels = nullptr;
    EXPECT_EQ(hgros_channels_open(session.get(), &channels), HGROS_OK);
    for (std::size_t i = 0; i < hgros_channels_count(channels); ++i) {
      auto one = Sized<hgros_channel>();
      EXPECT_EQ(hgros_channels_get(channels, i, &one), HGROS_OK);
      if (one.name != std::string("words") || one.publishers == 0) continue;
      EXPECT_STREQ(one.type_name, "text");
      EXPECT_EQ(one.encoding, HGROS_ENCODING_CUSTOM);
      auto user = Sized<hgros_channel_user>();
      EXPECT_EQ(hgros_channels_get_user(channels, i, HGROS_ROLE_PUBLISHER, 0, &user), HGROS_OK);
      publishers = user.process;
      EXPECT_EQ(hgros_channels_get_user(channels, i, HGROS_ROLE_PUBLISHER, 5, &user), HGROS_NOT_FOUND);
      EXPECT_EQ(hgros_channels_get_user(channels, i, 3, 0, &user), HGROS_INVALID_ARGUMENT);
    }
    hgros_channels_free(channels);
    return !publishers.empty();
  }));
  EXPECT_EQ(publishers, "other");
}

}  // namespace
}  // namespace hgros::test
