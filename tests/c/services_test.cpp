#include "c/c_fixture.hpp"

namespace hgros::test {
namespace {

struct Ended {
  std::atomic<int> calls{0};
  std::atomic<int> released{0};
  std::atomic<hgros_status> status{-1};
  std::string reply;
  static void Note(void* user, hgros_status status, const char* sentence, const hgros_message* reply) {
    auto& self = *static_cast<Ended*>(user);
    self.reply = reply == nullptr ? sentence : TextOf(reply);
    self.status = status;
    ++self.calls;
  }
  static void Release(void* user) { ++static_cast<Ended*>(user)->released; }
};

class CServices : public CTest {
 protected:
  // Replies with the request, or fails with it if it begins with "!". "?" gets no reply.
  static void Echo(void* /*user*/, const hgros_message* request, hgros_reply* reply) {
    const std::string asked = TextOf(request);
    if (asked == "?") return;
    if (asked.starts_with("!")) {
      EXPECT_EQ(hgros_reply_fail(reply, asked.substr(1).c_str()), HGROS_OK);
      return;
    }
    EXPECT_EQ(hgros_reply_set(reply, asked.data(), asked.size()), HGROS_OK);
    EXPECT_EQ(hgros_reply_set(reply, "twice", 5), HGROS_INVALID_ARGUMENT);
  }
  ServiceHandle Serve(const SessionHandle& on) {
    return Opened<hgros_service_close>(hgros_serve, on.get(), "echo", text.get(), text.get(), nullptr, &Echo, nullptr,
                                       nullptr);
  }
  // Serves "slow", whose replies are empty and come once the door is open.
  ServiceHandle ServeBehind(Door& door, const SessionHandle& on) {
    const auto answer = [](void* user, const hgros_message*, hgros_reply* reply) {
      static_cast<Door*>(user)->Pass();
      EXPECT_EQ(hgros_reply_set(reply, nullptr, 0), HGROS_OK);
    };
    return Opened<hgros_service_close>(hgros_serve, on.get(), "slow", text.get(), text.get(), nullptr, answer, &door,
                                       nullptr);
  }
  hgros_status Later(const char* name, Ended& ended, hgros_pending_call** call) {
    return hgros_call_later(session.get(), name, text.get(), "later", 5, nullptr, -1, &Ended::Note, &ended,
                            &Ended::Release, call);
  }
  // The reply, or the name of the status.
  std::string Call(const SessionHandle& from, const std::string& request, const hgros_schema* schema = nullptr) {
    hgros_message* reply = nullptr;
    const hgros_status status = hgros_call(from.get(), "echo", schema == nullptr ? text.get() : schema, request.data(),
                                           request.size(), text.get(), kPatienceNs, &reply);
    const MessageHandle owned(reply);
    return status == HGROS_OK ? TextOf(reply) : "<" + std::string(hgros_status_name(status)) + ">";
  }
};

TEST_F(CServices, AnswerInTheSameSessionAndInAnother) {
  const auto service = Serve(session);
  const auto other = OpenOther();
  EXPECT_EQ(Call(session, "here"), "here");
  ASSERT_EQ(hgros_wait_for_service(other.get(), "echo", kPatienceNs), HGROS_OK) << LastError();
  EXPECT_EQ(Call(other, "there"), "there");
}

TEST_F(CServices, HandlerThatFailsOrForgetsItsReplyTellsTheCaller) {
  const auto service = Serve(session);
  EXPECT_EQ(Call(session, "!The arm is folded."), "<handler failed>");
  EXPECT_NE(LastError().find("The arm is folded."), std::string::npos) << LastError();
  EXPECT_EQ(Call(session, "?"), "<handler failed>");
  EXPECT_NE(LastError().find("no reply"), std::string::npos) << LastError();
}

TEST_F(CServices, MissingServerAndWrongTypeAreToldApart) {
  EXPECT_EQ(Call(session, "x"), "<no server>");
  EXPECT_EQ(hgros_wait_for_service(session.get(), "echo", 1), HGROS_TIMED_OUT);
  EXPECT_EQ(hgros_wait_for_service(session.get(), "", 1), HGROS_ERROR);
  const auto service = Serve(session);
  const auto numbers = TextSchema("number");
  EXPECT_EQ(Call(session, "x", numbers.get()), "<type mismatch>");
  EXPECT_NE(LastError().find("number"), std::string::npos) << LastError();
  EXPECT_NE(LastError().find("text"), std::string::npos) << LastError();
  hgros_service* second = nullptr;
  EXPECT_EQ(hgros_serve(session.get(), "echo", text.get(), text.get(), nullptr, &Echo, nullptr, nullptr, &second),
            HGROS_ERROR);
}

TEST_F(CServices, ReplyComesToACallbackOnceAndNeedsNoHandle) {
  const auto service = Serve(session);
  for (const bool handle : {true, false}) {
    SCOPED_TRACE(handle);
    Ended ended;
    hgros_pending_call* call = nullptr;
    ASSERT_EQ(Later("echo", ended, handle ? &call : nullptr), HGROS_OK) << LastError();
    ASSERT_TRUE(Await([&] { return ended.calls == 1; }));
    EXPECT_EQ(ended.status, HGROS_OK);
    EXPECT_EQ(ended.reply, "later");
    hgros_call_cancel(call);
    hgros_call_free(call);
    EXPECT_TRUE(Await([&] { return ended.released == 1; }));
    EXPECT_EQ(ended.calls, 1);
  }
}

TEST_F(CServices, HandlerWithoutAPlaceForItsServiceIsNotServed) {
  Ended ended;
  EXPECT_EQ(
      hgros_serve(session.get(), "echo", text.get(), text.get(), nullptr, &Echo, &ended, &Ended::Release, nullptr),
      HGROS_INVALID_ARGUMENT);
  EXPECT_EQ(ended.released, 1);
  EXPECT_EQ(Call(session, "x"), "<no server>");
}

TEST_F(CServices, CancelledCallTellsItsCallback) {
  Door door;
  const auto service = ServeBehind(door, session);
  Ended ended;
  hgros_pending_call* call = nullptr;
  ASSERT_EQ(Later("slow", ended, &call), HGROS_OK);
  hgros_call_cancel(call);
  EXPECT_TRUE(Await([&] { return ended.released == 1; }));
  EXPECT_EQ(ended.calls, 1);
  EXPECT_EQ(ended.status, HGROS_CANCELLED);
  hgros_call_free(call);
  door.Open();
}

TEST_F(CServices, EndOfTheSessionEndsItsCalls) {
  Door door;
  const auto other = OpenOther();
  const auto service = ServeBehind(door, other);
  Ended ended;
  hgros_pending_call* call = nullptr;
  ASSERT_EQ(Later("slow", ended, &call), HGROS_OK);
  session.reset();
  EXPECT_EQ(ended.calls, 1);
  EXPECT_EQ(ended.status, HGROS_CLOSED);
  hgros_call_free(call);
  EXPECT_EQ(ended.released, 1);
  door.Open();
}

}  // namespace
}  // namespace hgros::test
