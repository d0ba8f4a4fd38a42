#include <poll.h>

#include <cstdint>
#include <cstring>

#include "c/c_fixture.hpp"

namespace hgros::test {
namespace {

using CMessages = CTest;

bool IsReadable(const SubscriptionHandle& queue) {
  pollfd one{hgros_queue_descriptor(queue.get()), POLLIN, 0};
  return poll(&one, 1, 0) == 1;
}

hgros_subscription_stats StatsOf(const SubscriptionHandle& subscription) {
  auto stats = Sized<hgros_subscription_stats>();
  EXPECT_EQ(hgros_subscription_get_stats(subscription.get(), &stats), HGROS_OK);
  return stats;
}

TEST_F(CMessages, CallbackGetsBytesSchemaAndSender) {
  const auto other = OpenOther();
  for (const SessionHandle* const from : {static_cast<const SessionHandle*>(&session), &other}) {
    std::atomic<int> count{0};
    std::string got;
    std::string type;
    auto info = Sized<hgros_message_info>();
    const auto take = [&](const hgros_message* message) {
      got = TextOf(message);
      type = hgros_schema_type_name(hgros_message_schema(message));
      EXPECT_EQ(hgros_message_get_info(message, &info), HGROS_OK);
      ++count;
    };
    const auto owned = Subscribe(session, "words", take);
    const auto publisher = Publisher(*from, "words", text);
    ASSERT_EQ(hgros_session_wait_for_subscribers(from->get(), "words", 1, kPatienceNs), HGROS_OK);
    ASSERT_EQ(Publish(publisher, "hello"), HGROS_OK);
    ASSERT_TRUE(Await([&] { return count == 1; }));
    EXPECT_EQ(got, "hello");
    EXPECT_EQ(type, "text");
    EXPECT_EQ(info.publisher, hgros_session_id(from->get()));
    EXPECT_EQ(info.sequence, 1U);
    EXPECT_EQ(info.remote, from == &other ? 1 : 0);
    EXPECT_NE(info.key, 0U);
  }
}

TEST_F(CMessages, QueueIsTakenInOrderAndItsDescriptorSaysWhen) {
  const auto queue = Queue(session, "words");
  const auto publisher = Publisher(session, "words", text);
  EXPECT_FALSE(IsReadable(queue));
  EXPECT_EQ(Take(queue, 0), "<timed out>");
  EXPECT_EQ(Publish(publisher, "a"), HGROS_OK);
  EXPECT_EQ(Publish(publisher, "b"), HGROS_OK);
  EXPECT_TRUE(IsReadable(queue));
  EXPECT_EQ(Take(queue, 0), "a");
  EXPECT_EQ(Take(queue, 0), "b");
  EXPECT_FALSE(IsReadable(queue));
  EXPECT_EQ(StatsOf(queue).run, 2U);
  std::jthread later([&] {
    Linger(std::chrono::milliseconds(20));
    EXPECT_EQ(Publish(publisher, "late"), HGROS_OK);
  });
  EXPECT_EQ(Take(queue, -1), "late") << "waits for a message of another thread";
  EXPECT_EQ(Take(queue, 1'000'000), "<timed out>");
}

TEST_F(CMessages, KeepLastDropsTheOldestAndCountsAndLatchedMessagesReachALateQueue) {
  auto options = Sized<hgros_subscribe_options>();
  options.keep_last = 2;
  const auto queue = Opened<hgros_subscription_close>(hgros_subscribe_queue, session.get(), "words", &options);
  const auto publisher = Publisher(session, "words", text, 2);
  for (const char* word : {"a", "b", "c", "d"}) EXPECT_EQ(Publish(publisher, word), HGROS_OK);
  EXPECT_EQ(Take(queue, 0), "c");
  EXPECT_EQ(Take(queue, 0), "d");
  EXPECT_EQ(StatsOf(queue).dropped, 2U);
  const auto late = Queue(session, "words");
  EXPECT_EQ(Take(late, 0), "c");
  EXPECT_EQ(Take(late, 0), "d");
}

TEST_F(CMessages, LosslessQueueMakesThePublisherWaitAndLosesNothing) {
  const auto queue = Queue(session, "words", 2);
  const auto publisher = Publisher(session, "words", text);
  EXPECT_EQ(Publish(publisher, "0"), HGROS_OK);
  EXPECT_EQ(Publish(publisher, "1"), HGROS_OK);
  EXPECT_EQ(Publish(publisher, "2"), HGROS_FULL);
  EXPECT_NE(LastError().find("words"), std::string::npos) << LastError();
  EXPECT_EQ(hgros_publish_wait(publisher.get(), "2", 1, 1'000'000), HGROS_TIMED_OUT);
  std::thread publishing([&] {
    for (char digit = '2'; digit <= '9'; ++digit) {
      EXPECT_EQ(hgros_publish_wait(publisher.get(), &digit, 1, -1), HGROS_OK);
    }
  });
  for (char digit = '0'; digit <= '9'; ++digit) EXPECT_EQ(Take(queue), std::string(1, digit));
  publishing.join();
}

TEST_F(CMessages, KeptMessageOutlivesCallbackSubscriptionAndSession) {
  const std::uint64_t before = hgros_message_leases();
  std::atomic<hgros_message*> kept{nullptr};
  const auto keep = [&](const hgros_message* message) {
    hgros_message* mine = nullptr;
    EXPECT_EQ(hgros_message_keep(message, &mine), HGROS_OK);
    kept = mine;
  };
  auto subscription = Subscribe(session, "words", keep);
  EXPECT_EQ(Publish(Publisher(session, "words", text), "kept"), HGROS_OK);
  ASSERT_TRUE(Await([&] { return kept.load() != nullptr; }));
  subscription.reset();
  session.reset();
  EXPECT_EQ(hgros_message_leases(), before + 1);
  EXPECT_EQ(TextOf(kept), "kept");
  hgros_message_free(kept);
  EXPECT_EQ(hgros_message_leases(), before);
}

TEST_F(CMessages, LoanIsFilledPublishedOnceAndThenClosedAndASizeThatNoMemoryHasIsRefused) {
  const auto publisher = Publisher(session, "words", text);
  const auto queue = Queue(session, "words", 1);
  EXPECT_EQ(Publish(publisher, "first"), HGROS_OK);
  hgros_loan* loan = nullptr;
  ASSERT_EQ(hgros_loan_open(publisher.get(), 5, &loan), HGROS_OK);
  std::size_t size = 0;
  std::memcpy(hgros_loan_data(loan, &size), "loans", 5);
  EXPECT_EQ(size, 5U);
  EXPECT_EQ(hgros_loan_publish(loan, 0), HGROS_FULL);
  EXPECT_EQ(Take(queue, 0), "first");
  EXPECT_EQ(hgros_loan_publish(loan, 0), HGROS_OK) << "a refused loan can be published again";
  EXPECT_EQ(hgros_loan_data(loan, &size), nullptr) << "nobody may write a published message";
  EXPECT_EQ(hgros_loan_publish(loan, 0), HGROS_INVALID_ARGUMENT);
  hgros_loan_free(loan);
  EXPECT_EQ(Take(queue, 0), "loans");
  EXPECT_EQ(hgros_publish(publisher.get(), "x", SIZE_MAX), HGROS_NO_MEMORY);
  EXPECT_EQ(LastError(), "There is no memory for it: its size is larger than any memory.");
}

TEST_F(CMessages, BorrowedBytesAreReleasedOnceTheLastReaderIsDone) {
  static const std::string bytes = "mine";
  std::atomic<int> released{0};
  const auto publisher = Publisher(session, "words", text);
  const auto queue = Queue(session, "words", 1);
  const auto publish = [&](hgros_publisher* with, std::int64_t timeout_ns) {
    return hgros_publish_borrowed(
        with, bytes.data(), bytes.size(), &released, [](void* user) { ++*static_cast<std::atomic<int>*>(user); },
        timeout_ns);
  };
  EXPECT_EQ(Publish(publisher, "first"), HGROS_OK);
  EXPECT_EQ(publish(publisher.get(), 0), HGROS_FULL);
  EXPECT_EQ(publish(publisher.get(), 1'000'000), HGROS_TIMED_OUT);
  EXPECT_EQ(released, 0) << "without room they stay the caller's";
  EXPECT_EQ(Take(queue, 0), "first");
  EXPECT_EQ(publish(publisher.get(), 0), HGROS_OK);
  EXPECT_EQ(released, 0) << "the message waits in the queue";
  hgros_message* message = nullptr;
  ASSERT_EQ(hgros_queue_take(queue.get(), 0, &message), HGROS_OK);
  EXPECT_EQ(hgros_message_data(message, nullptr), bytes.data()) << "not copied inside the process";
  hgros_message_free(message);
  EXPECT_EQ(released, 1);
  EXPECT_EQ(publish(nullptr, 0), HGROS_INVALID_ARGUMENT);
  EXPECT_EQ(released, 2) << "also if it fails";
}

TEST_F(CMessages, AnotherTypeInThisSessionIsRefusedNamingBoth) {
  const auto publisher = Publisher(session, "words", text);
  const auto numbers = TextSchema("number");
  hgros_publisher* second = nullptr;
  EXPECT_EQ(hgros_publisher_open(session.get(), "words", numbers.get(), nullptr, &second), HGROS_TYPE_MISMATCH);
  EXPECT_EQ(second, nullptr);
  EXPECT_NE(LastError().find("number"), std::string::npos) << LastError();
  EXPECT_NE(LastError().find("text"), std::string::npos) << LastError();
  auto options = Sized<hgros_subscribe_options>();
  options.schema = numbers.get();
  hgros_subscription* queue = nullptr;
  EXPECT_EQ(hgros_subscribe_queue(session.get(), "words", &options, &queue), HGROS_TYPE_MISMATCH);
}

TEST_F(CMessages, AnotherSessionsMessagesOfAnotherTypeAreCountedAndReported) {
  const auto numbers = TextSchema("number");
  const auto queue = Queue(session, "words", 0, numbers.get());
  std::atomic<bool> told{false};
  const auto check_event = [](void* user, int32_t event, const hgros_peer* peer, const char* channel,
                              const char* reason) {
    if (event != HGROS_PEER_TYPE_MISMATCH) return;
    EXPECT_STREQ(channel, "words");
    EXPECT_STREQ(peer->process, "other");
    EXPECT_NE(std::string(reason).find("text"), std::string::npos) << reason;
    EXPECT_NE(std::string(reason).find("number"), std::string::npos) << reason;
    *static_cast<std::atomic<bool>*>(user) = true;
  };
  const auto watching = Opened<hgros_watch_close>(hgros_watch_peers, session.get(), check_event, &told, nullptr);
  const auto other = OpenOther();
  const auto publisher = Publisher(other, "words", text);
  ASSERT_TRUE(Await([&] {
    EXPECT_EQ(Publish(publisher, "no number"), HGROS_OK);
    EXPECT_EQ(Take(queue, 0), "<timed out>");
    return StatsOf(queue).mismatched > 0 && told;
  })) << StatsOf(queue).mismatched;
  EXPECT_TRUE(Await([&] { return log.Contain("number") && log.Contain("text"); }));
}

TEST_F(CMessages, TypesOfTheLibraryAreKnownByTheirNames) {
  hgros_schema* schema = nullptr;
  ASSERT_EQ(hgros_schema_known("foxglove.Log", &schema), HGROS_OK) << LastError();
  const SchemaHandle known(schema);
  std::size_t size = 0;
  ASSERT_NE(hgros_schema_descriptor_set(schema, &size), nullptr);
  const auto same = Opened<hgros_schema_free>(hgros_schema_create, "foxglove.Log", HGROS_ENCODING_PROTOBUF, 0U,
                                              hgros_schema_descriptor_set(schema, nullptr), size);
  EXPECT_NE(hgros_schema_fingerprint(same.get()), 0U);
  EXPECT_EQ(hgros_schema_fingerprint(same.get()), hgros_schema_fingerprint(schema));
  EXPECT_EQ(hgros_schema_known("foxglove.Lof", &schema), HGROS_NOT_FOUND);
  EXPECT_EQ(schema, nullptr);
  EXPECT_EQ(hgros_schema_create("foxglove.Log", HGROS_ENCODING_PROTOBUF, 0, "junk", 4, &schema), HGROS_ERROR);
}

TEST_F(CMessages, FourMegabytesInALoanReachAnotherSessionWithoutACopy) {
  constexpr std::size_t kBytes = 4 << 20;
  const auto other = OpenOther();
  const auto queue = Queue(other, "images");
  const auto publisher = Publisher(session, "images", text);
  ASSERT_EQ(hgros_session_wait_for_subscribers(session.get(), "images", 1, -1), HGROS_OK);
  hgros_loan* loan = nullptr;
  ASSERT_EQ(hgros_loan_open(publisher.get(), kBytes, &loan), HGROS_OK);
  std::memset(hgros_loan_data(loan, nullptr), 'x', kBytes);
  ASSERT_EQ(hgros_loan_publish(loan, 0), HGROS_OK);
  hgros_loan_free(loan);
  const auto owned = Opened<hgros_message_free>(hgros_queue_take, queue.get(), -1);
  EXPECT_EQ(TextOf(owned.get()), std::string(kBytes, 'x'));
  const auto counters = Opened<hgros_message_free>(hgros_session_snapshot, session.get());
  EXPECT_STREQ(hgros_schema_type_name(hgros_message_schema(counters.get())), "hgros.Snapshot");
  EXPECT_NE(TextOf(counters.get()).find("images"), std::string::npos);
}

}  // namespace
}  // namespace hgros::test
