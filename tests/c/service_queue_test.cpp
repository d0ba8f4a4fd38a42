#include <poll.h>

#include "c/c_fixture.hpp"

namespace hgros::test {
namespace {

struct Taken {
  hgros_status status = HGROS_OK;
  MessageHandle request;
  std::unique_ptr<hgros_reply, Ends<hgros_reply_free>> reply;
};

class CServiceQueue : public CTest {
 protected:
  ServiceHandle Serve() {
    return Opened<hgros_service_close>(hgros_serve_queue, session.get(), "ask", text.get(), text.get(), nullptr);
  }
  static Taken Take(const ServiceHandle& service, std::int64_t timeout_ns = kPatienceNs) {
    hgros_message* request = nullptr;
    hgros_reply* reply = nullptr;
    Taken taken;
    taken.status = hgros_service_take(service.get(), timeout_ns, &request, &reply);
    taken.request.reset(request);
    taken.reply.reset(reply);
    return taken;
  }
  static bool IsReadable(const ServiceHandle& service) {
    pollfd one{hgros_service_descriptor(service.get()), POLLIN, 0};
    return poll(&one, 1, 0) == 1;
  }
  // Calls on a thread of its own. The reply, or the status with its sentence, is added to `replies`.
  std::thread Caller(const SessionHandle& from, std::string request) {
    return std::thread([this, &from, request = std::move(request)] {
      hgros_message* reply = nullptr;
      const hgros_status status =
          hgros_call(from.get(), "ask", text.get(), request.data(), request.size(), text.get(), kPatienceNs, &reply);
      const MessageHandle owned(reply);
      replies.Add(status == HGROS_OK ? TextOf(reply) : hgros_status_name(status) + (": " + LastError()));
    });
  }

  Texts replies;
};

TEST_F(CServiceQueue, RequestsOfBothSessionsAreTakenAndAnsweredByTheProgram) {
  const auto service = Serve();
  const auto other = OpenOther();
  ASSERT_EQ(hgros_wait_for_service(other.get(), "ask", kPatienceNs), HGROS_OK) << LastError();
  EXPECT_FALSE(IsReadable(service));
  EXPECT_EQ(Take(service, 0).status, HGROS_TIMED_OUT);
  for (const SessionHandle* const from : std::initializer_list<const SessionHandle*>{&session, &other}) {
    std::thread caller = Caller(*from, "hello");
    EXPECT_TRUE(Await([&] { return IsReadable(service); }));
    const Taken taken = Take(service);
    ASSERT_EQ(taken.status, HGROS_OK) << LastError();
    EXPECT_FALSE(IsReadable(service));
    EXPECT_EQ(TextOf(taken.request.get()), "hello");
    EXPECT_EQ(hgros_reply_set(taken.reply.get(), "world", 5), HGROS_OK);
    EXPECT_EQ(hgros_reply_set(taken.reply.get(), "world", 5), HGROS_INVALID_ARGUMENT);
    caller.join();
  }
  EXPECT_EQ(replies.all(), std::vector<std::string>(2, "world"));
}

TEST_F(CServiceQueue, NextRequestIsHandedOutAfterTheReplyTheFailureOrTheDroppedRequest) {
  const auto service = Serve();
  std::thread first = Caller(session, "1");
  Taken one = Take(service);
  std::thread second = Caller(session, "2");
  EXPECT_EQ(Take(service, 20'000'000).status, HGROS_TIMED_OUT);
  EXPECT_EQ(hgros_reply_set(one.reply.get(), "one", 3), HGROS_OK);
  first.join();
  {
    const Taken two = Take(service);
    EXPECT_EQ(TextOf(two.request.get()), "2");
    EXPECT_EQ(hgros_reply_fail(two.reply.get(), "The arm is folded."), HGROS_OK);
  }
  second.join();
  std::thread third = Caller(session, "3");
  EXPECT_EQ(Take(service).status, HGROS_OK);  // The place for the reply is freed at once.
  third.join();
  const auto all = replies.all();
  ASSERT_EQ(all.size(), 3U);
  EXPECT_EQ(all[0], "one");
  EXPECT_NE(all[1].find("handler failed: The arm is folded."), std::string::npos) << all[1];
  EXPECT_NE(all[2].find("dropped the request"), std::string::npos) << all[2];
}

TEST_F(CServiceQueue, EndWakesItsThreadsAndFailsWhatWaits) {
  const auto service = Serve();
  std::thread caller = Caller(session, "1");
  Taken taken = Take(service);
  std::thread taker([&] { EXPECT_EQ(Take(service).status, HGROS_CLOSED); });
  hgros_service_end(service.get());
  taker.join();
  caller.join();
  EXPECT_TRUE(IsReadable(service));
  EXPECT_EQ(hgros_reply_set(taken.reply.get(), "late", 4), HGROS_CLOSED);
  EXPECT_NE(replies.all().at(0).find("server gone"), std::string::npos) << replies.all()[0];
}

TEST_F(CServiceQueue, EndedServiceIsNoLongerFound) {
  const auto service = Serve();
  const auto other = OpenOther();
  ASSERT_EQ(hgros_wait_for_service(other.get(), "ask", kPatienceNs), HGROS_OK) << LastError();
  std::thread first = Caller(other, "1");
  EXPECT_EQ(hgros_reply_set(Take(service).reply.get(), "one", 3), HGROS_OK);
  first.join();
  hgros_service_end(service.get());
  hgros_service_end(service.get());
  EXPECT_TRUE(Await([&] {
    hgros_message* reply = nullptr;
    return hgros_call(other.get(), "ask", text.get(), "2", 1, text.get(), kPatienceNs, &reply) == HGROS_NO_SERVER;
  })) << LastError();
  const auto again = Serve();
  std::thread third = Caller(session, "3");
  EXPECT_EQ(hgros_reply_set(Take(again).reply.get(), "three", 5), HGROS_OK);
  third.join();
  EXPECT_EQ(replies.all(), (std::vector<std::string>{"one", "three"}));
}

TEST_F(CServiceQueue, RequestWhoseCallerGaveUpIsSkippedAndCounted) {
  const auto service = Serve();
  hgros_message* reply = nullptr;
  EXPECT_EQ(hgros_call(session.get(), "ask", text.get(), "late", 4, text.get(), 50'000'000, &reply), HGROS_TIMED_OUT);
  EXPECT_TRUE(Await([&] { return !IsReadable(service); }));
  EXPECT_EQ(Take(service, 0).status, HGROS_TIMED_OUT);
  std::thread caller = Caller(session, "next");
  const Taken taken = Take(service);
  EXPECT_EQ(TextOf(taken.request.get()), "next");
  EXPECT_EQ(hgros_reply_set(taken.reply.get(), "done", 4), HGROS_OK);
  caller.join();
  const auto owned = Opened<hgros_message_free>(hgros_session_snapshot, session.get());
  // hgros.Snapshot: the service's name, then field 2, unhandled_requests: 1.
  EXPECT_NE(TextOf(owned.get())
                .find(std::string("\x0a\x03"
                                  "ask"
                                  "\x10\x01")),
            std::string::npos);
}

TEST_F(CServiceQueue, EndsWithItsSession) {
  const auto service = Serve();
  const auto other = OpenOther();
  ASSERT_EQ(hgros_wait_for_service(other.get(), "ask", kPatienceNs), HGROS_OK) << LastError();
  std::thread caller = Caller(other, "1");
  const Taken taken = Take(service);
  std::thread taker([&] { EXPECT_EQ(Take(service).status, HGROS_CLOSED); });
  hgros_session_end(session.get());
  taker.join();
  session.reset();
  caller.join();
  EXPECT_EQ(hgros_reply_set(taken.reply.get(), "late", 4), HGROS_CLOSED);
  EXPECT_EQ(Take(service).status, HGROS_CLOSED);
}

TEST_F(CServiceQueue, OptionsOfHandlersAreRefusedAndItsThreadCannotBeConfiguredAway) {
  const auto configured = Open("data_graph: {threads: 2, nodes: {ask: {executor: inline}}}", others_log, "other");
  hgros_service* service = nullptr;
  EXPECT_EQ(hgros_serve_queue(configured.get(), "ask", text.get(), text.get(), nullptr, &service), HGROS_ERROR);
  EXPECT_EQ(service, nullptr);
  EXPECT_NE(LastError().find("executor"), std::string::npos) << LastError();
  auto options = Sized<hgros_serve_options>();
  options.concurrent = 1;
  EXPECT_EQ(hgros_serve_queue(session.get(), "ask", text.get(), text.get(), &options, &service),
            HGROS_INVALID_ARGUMENT);
  EXPECT_EQ(service, nullptr);
  const auto ignore = [](void*, const hgros_message*, hgros_reply*) {};
  ASSERT_EQ(hgros_serve(session.get(), "ask", text.get(), text.get(), nullptr, ignore, nullptr, nullptr, &service),
            HGROS_OK);
  const ServiceHandle owned(service);
  EXPECT_EQ(hgros_service_descriptor(service), -1);
  EXPECT_EQ(Take(owned, 0).status, HGROS_INVALID_ARGUMENT);
}

}  // namespace
}  // namespace hgros::test
