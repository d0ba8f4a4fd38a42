#include "c/c_fixture.hpp"

namespace hgros::test {
namespace {

// The pointer of a program: what its callback and its release do, and the status that the release got.
struct Program {
  hgros_session* session = nullptr;
  hgros_transforms* transforms = nullptr;
  hgros_params* params = nullptr;
  hgros_subscription* subscription = nullptr;
  hgros_watch* watch = nullptr;
  std::function<hgros_status(Program&)> at_release;
  std::atomic<int> calls{0};
  std::atomic<bool> released{false};
  hgros_status status = HGROS_ERROR;

  static void Release(void* user) {
    auto& self = *static_cast<Program*>(user);
    self.status = self.at_release(self);
    self.released = true;
  }
};

hgros_status CloseTransforms(Program& of) { return hgros_transforms_close(of.transforms); }
hgros_status CloseSession(Program& of) {
  hgros_session_close(of.session);
  return HGROS_OK;
}

// A session that is closed in a callback stays until the process ends, and so does what it uses.
struct Fixture {
  LogLines log;
  Program program;
  SchemaHandle text = TextSchema();
};

Fixture& NewFixture(std::function<hgros_status(Program&)> at_release) {
  static auto& all = *new std::vector<std::unique_ptr<Fixture>>;
  Fixture& made = *all.emplace_back(std::make_unique<Fixture>());
  Program& program = made.program;
  program.at_release = std::move(at_release);
  program.session = Open(DomainYaml(), made.log).release();
  EXPECT_EQ(hgros_transforms_open(program.session, &program.transforms), HGROS_OK) << LastError();
  return made;
}

hgros_publisher* PublisherOf(Fixture& fixture) {
  hgros_publisher* publisher = nullptr;
  EXPECT_EQ(hgros_publisher_open(fixture.program.session, "words", fixture.text.get(), nullptr, &publisher), HGROS_OK);
  return publisher;
}

// The callback closes its own subscription, so it runs once, and its pointer is let go on the thread that has run it.
void SubscribeAndCloseInside(Fixture& fixture, std::int32_t executor) {
  Program& program = fixture.program;
  auto options = Sized<hgros_subscribe_options>();
  options.executor = executor;
  const auto close_itself = [](void* user, const hgros_message*) {
    auto& of = *static_cast<Program*>(user);
    ++of.calls;
    hgros_subscription_close(of.subscription);
  };
  ASSERT_EQ(hgros_subscribe(program.session, "words", &options, close_itself, &program, &Program::Release,
                            &program.subscription),
            HGROS_OK);
  const PublisherHandle publisher(PublisherOf(fixture));
  ASSERT_EQ(Publish(publisher, "go"), HGROS_OK);
  ASSERT_TRUE(Await([&] { return program.released.load(); }));
}

class CRelease : public testing::TestWithParam<std::int32_t> {};

TEST_P(CRelease, OfACallbackThatRanIsInsideIt) {
  Fixture& fixture = NewFixture(CloseTransforms);
  SubscribeAndCloseInside(fixture, GetParam());
  EXPECT_EQ(fixture.program.status, HGROS_WOULD_DEADLOCK);
  EXPECT_EQ(Publish(PublisherHandle(PublisherOf(fixture)), "again"), HGROS_OK);
  EXPECT_EQ(hgros_session_wait_idle(fixture.program.session, -1), HGROS_OK);
  EXPECT_EQ(fixture.program.calls, 1);
  EXPECT_EQ(hgros_transforms_close(fixture.program.transforms), HGROS_OK);
  hgros_session_close(fixture.program.session);
}

TEST_P(CRelease, OfACallbackThatRanMayCloseTheSession) {
  Fixture& fixture = NewFixture(CloseSession);
  SubscribeAndCloseInside(fixture, GetParam());
  EXPECT_TRUE(fixture.log.Contain("callback")) << "the log says where it was closed";
  hgros_transform found;
  EXPECT_EQ(hgros_transforms_lookup(fixture.program.transforms, "a", "b", &found), HGROS_CLOSED);
  EXPECT_EQ(hgros_transforms_close(fixture.program.transforms), HGROS_OK);
}

TEST(CReleaseElsewhere, CallbackMayCloseTheSessionBeforeItReturns) {
  Fixture& fixture = NewFixture(CloseSession);
  Program& program = fixture.program;
  const auto close_session = [](void* user, const hgros_message*) {
    EXPECT_EQ(CloseTransforms(*static_cast<Program*>(user)), HGROS_WOULD_DEADLOCK);
    Program::Release(user);
  };
  ASSERT_EQ(hgros_subscribe(program.session, "words", nullptr, close_session, &program, nullptr, &program.subscription),
            HGROS_OK);
  const PublisherHandle publisher(PublisherOf(fixture));
  EXPECT_EQ(Publish(publisher, "go"), HGROS_OK);
  ASSERT_TRUE(Await([&] { return program.released.load(); }));
  EXPECT_TRUE(fixture.log.Contain("callback")) << "the log says which callback closed it";
  EXPECT_EQ(Publish(publisher, "more"), HGROS_CLOSED);
  hgros_subscription_close(program.subscription);
  hgros_transform found;
  EXPECT_EQ(hgros_transforms_lookup(program.transforms, "a", "b", &found), HGROS_CLOSED);
  EXPECT_EQ(hgros_transforms_close(program.transforms), HGROS_OK);
}

INSTANTIATE_TEST_SUITE_P(Executors, CRelease,
                         testing::Values(HGROS_EXECUTOR_WORKERS, HGROS_EXECUTOR_INLINE, HGROS_EXECUTOR_DEDICATED));

TEST(CReleaseElsewhere, OnAThreadOfTheProgramClosesAnything) {
  Fixture& fixture = NewFixture([](Program& of) {
    const hgros_status status = CloseTransforms(of);
    (void)CloseSession(of);
    return status;
  });
  Program& program = fixture.program;
  ASSERT_EQ(hgros_subscribe(
                program.session, "words", nullptr, [](void*, const hgros_message*) {}, &program, &Program::Release,
                &program.subscription),
            HGROS_OK);
  hgros_subscription_close(program.subscription);
  EXPECT_TRUE(program.released);
  EXPECT_EQ(program.status, HGROS_OK);
  EXPECT_FALSE(fixture.log.Contain("callback"));
  delete &fixture;
}

TEST(CReleaseElsewhere, OfAnEndedCallMayCloseTheSession) {
  Fixture& fixture = NewFixture(CloseSession);
  Program& program = fixture.program;
  LogLines log;
  const auto server = Open("data_graph: {threads: 2}", log, "server");
  const auto service = Opened<hgros_service_close>(hgros_serve_queue, server.get(), "ask", fixture.text.get(),
                                                   fixture.text.get(), nullptr);
  ASSERT_EQ(hgros_call_later(
                program.session, "ask", fixture.text.get(), "x", 1, fixture.text.get(), 300'000'000,
                [](void*, hgros_status, const char*, const hgros_message*) {}, &program, &Program::Release, nullptr),
            HGROS_OK);
  EXPECT_TRUE(Await([&] { return program.released.load(); }));
  hgros_transform found;
  EXPECT_EQ(hgros_transforms_lookup(program.transforms, "a", "b", &found), HGROS_CLOSED);
  EXPECT_EQ(hgros_transforms_close(program.transforms), HGROS_OK);
}

TEST(CReleaseElsewhere, OfBorrowedBytesMayCloseTheSession) {
  Fixture& fixture = NewFixture(CloseSession);
  Program& program = fixture.program;
  std::atomic<bool> sent{false};
  const auto wait_until_sent = [](void* user, const hgros_message*) {
    EXPECT_TRUE(Await([&] { return static_cast<std::atomic<bool>*>(user)->load(); }));
  };
  ASSERT_EQ(hgros_subscribe(program.session, "words", nullptr, wait_until_sent, &sent, nullptr, &program.subscription),
            HGROS_OK);
  hgros_publisher* const publisher = PublisherOf(fixture);
  ASSERT_EQ(hgros_publish_borrowed(publisher, "x", 1, &program, &Program::Release, 0), HGROS_OK);
  sent = true;
  EXPECT_TRUE(Await([&] { return program.released.load(); }));
  EXPECT_EQ(hgros_publish(publisher, "x", 1), HGROS_CLOSED);
  hgros_publisher_close(publisher);
  hgros_subscription_close(program.subscription);
  EXPECT_EQ(hgros_transforms_close(program.transforms), HGROS_OK);
}

TEST(CReleaseElsewhere, OfBorrowedBytesInAQueueMayCloseTheQueue) {
  Fixture& fixture = NewFixture([](Program& of) {
    hgros_subscription_close(of.subscription);
    return HGROS_OK;
  });
  Program& program = fixture.program;
  ASSERT_EQ(hgros_subscribe_queue(program.session, "words", nullptr, &program.subscription), HGROS_OK);
  const PublisherHandle publisher(PublisherOf(fixture));
  ASSERT_EQ(hgros_publish_borrowed(publisher.get(), "x", 1, &program, &Program::Release, 0), HGROS_OK);
  std::atomic<bool> ended{false};
  std::thread ending([&] {
    hgros_session_end(program.session);
    ended = true;
  });
  ASSERT_TRUE(Await([&] { return ended.load(); }, std::chrono::seconds(10))) << "the release waits for its own thread";
  ending.join();
  EXPECT_TRUE(program.released);
  EXPECT_EQ(hgros_transforms_close(program.transforms), HGROS_OK);
  hgros_session_close(program.session);
}

TEST(CReleaseElsewhere, OfAWatchOfParametersIsInsideThem) {
  Program program;
  program.at_release = [](Program& of) { return hgros_params_close(of.params); };
  ASSERT_EQ(hgros_params_open(nullptr, nullptr, 0, &program.params), HGROS_OK) << LastError();
  ASSERT_EQ(hgros_params_watch(
                program.params, "a",
                [](void* user, const char*, const char*) { hgros_watch_close(static_cast<Program*>(user)->watch); },
                &program, &Program::Release, &program.watch),
            HGROS_OK);
  std::thread setter([&] { EXPECT_EQ(hgros_params_set_number(program.params, "a", 1), HGROS_OK) << LastError(); });
  EXPECT_TRUE(Await([&] { return program.released.load(); }));
  setter.join();
  EXPECT_EQ(program.status, HGROS_WOULD_DEADLOCK);
  EXPECT_EQ(hgros_params_close(program.params), HGROS_OK);
}

}  // namespace
}  // namespace hgros::test
