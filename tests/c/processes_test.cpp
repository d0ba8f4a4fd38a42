#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>

#include <cstdio>
#include <cstring>

#include "c/c_fixture.hpp"
#include "support/path.hpp"

namespace hgros::test {
namespace {

// A program in C99 that uses the library, as peer.c says.
class Peer {
 public:
  explicit Peer(std::vector<std::string> arguments) {
    int ends[2];
    EXPECT_EQ(pipe(ends), 0);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, ends[1], 1);
    posix_spawn_file_actions_addclose(&actions, ends[0]);
    arguments.insert(arguments.begin(), Path("peer"));
    std::vector<char*> texts;
    for (std::string& one : arguments) texts.push_back(one.data());
    texts.push_back(nullptr);
    EXPECT_EQ(posix_spawn(&pid_, texts.front(), &actions, nullptr, texts.data(), environ), 0);
    posix_spawn_file_actions_destroy(&actions);
    close(ends[1]);
    output_ = fdopen(ends[0], "r");
    EXPECT_EQ(Line(), "ready");
  }
  Peer(const Peer&) = delete;
  Peer& operator=(const Peer&) = delete;
  ~Peer() {
    Kill();
    (void)fclose(output_);
  }

  std::string Line() {
    char line[256];
    if (fgets(line, sizeof line, output_) == nullptr) return "<end>";
    return std::string(line, std::strcspn(line, "\n"));
  }
  void Kill() {
    if (pid_ == 0) return;
    (void)kill(pid_, SIGKILL);
    (void)waitpid(pid_, nullptr, 0);
    pid_ = 0;
  }
  int Exit() {
    int status = -1;
    EXPECT_EQ(waitpid(pid_, &status, 0), pid_);
    pid_ = 0;
    return status;
  }

 private:
  pid_t pid_ = 0;
  FILE* output_ = nullptr;
};

using CProcesses = CTest;

TEST_F(CProcesses, SlowLosslessTakerHoldsThePublisherBackAndMissesNothing) {
  constexpr int kMessages = 60;
  const auto publisher = Publisher(session, "words", text);
  Peer peer({"take", "words", std::to_string(kMessages), "2"});
  ASSERT_EQ(hgros_session_wait_for_subscribers(session.get(), "words", 1, kPatienceNs), HGROS_OK);
  int full = 0;
  for (int i = 0; i < kMessages; ++i) {
    const std::string word = std::to_string(i);
    hgros_status status = Publish(publisher, word);
    if (status == HGROS_FULL) {
      ++full;
      status = hgros_publish_wait(publisher.get(), word.data(), word.size(), kPatienceNs);
    }
    ASSERT_EQ(status, HGROS_OK) << LastError();
  }
  EXPECT_GT(full, 0) << "it takes one message per millisecond";
  for (int i = 0; i < kMessages; ++i) ASSERT_EQ(peer.Line(), std::to_string(i));
  EXPECT_EQ(peer.Exit(), 0);
}

TEST_F(CProcesses, KilledLosslessSubscriberFreesThePublisher) {
  const auto publisher = Publisher(session, "words", text);
  std::atomic<bool> gone{false};
  const auto note_gone = [](void* user, int32_t event, const hgros_peer*, const char*, const char*) {
    if (event == HGROS_PEER_GONE) *static_cast<std::atomic<bool>*>(user) = true;
  };
  const auto watching = Opened<hgros_watch_close>(hgros_watch_peers, session.get(), note_gone, &gone, nullptr);
  Peer peer({"hold", "words"});
  ASSERT_EQ(hgros_session_wait_for_subscribers(session.get(), "words", 1, kPatienceNs), HGROS_OK);
  ASSERT_TRUE(Await([&] { return Publish(publisher, "x") == HGROS_FULL; }));
  peer.Kill();
  EXPECT_EQ(hgros_publish_wait(publisher.get(), "y", 1, kPatienceNs), HGROS_OK) << LastError();
  EXPECT_TRUE(Await([&] { return gone.load(); }));
}

// Another thread is inside while the process forks, so the child finds it counted as a user.
TEST_F(CProcesses, ForkedChildIsRefusedAndMayCloseWhatItInherits) {
  const auto publisher = Publisher(session, "words", text);
  const auto queue = Queue(session, "words");
  hgros_transforms* transforms = nullptr;
  ASSERT_EQ(hgros_transforms_open(session.get(), &transforms), HGROS_OK);
  std::atomic<bool> waits{false};
  std::thread waiting([&] {
    hgros_transform found;
    waits = true;
    EXPECT_EQ(hgros_transforms_wait(transforms, "map", "base", 1, -1, &found), HGROS_CLOSED);
  });
  ASSERT_TRUE(Await([&] { return waits.load(); }));
  Linger(std::chrono::milliseconds(20));
  const pid_t child = fork();
  if (child == 0) {
    hgros_transform found;
    int refused = Publish(publisher, "x") == HGROS_CLOSED ? 1 : 0;
    refused += LastError().find("from which this one was forked") != std::string::npos ? 1 : 0;
    refused += hgros_session_log(session.get(), HGROS_LOG_ERROR, "x") == HGROS_CLOSED ? 1 : 0;
    refused += Take(queue, 0) == "<closed>" ? 1 : 0;
    refused += hgros_transforms_lookup(transforms, "map", "base", &found) == HGROS_CLOSED ? 1 : 0;
    refused += hgros_session_wait_for_subscribers(session.get(), "words", 1, -1) == HGROS_CLOSED ? 1 : 0;
    hgros_session_end(session.get());
    (void)hgros_transforms_close(transforms);
    session.reset();
    _exit(refused);
  }
  int status = -1;
  const bool ended = Await([&] { return waitpid(child, &status, WNOHANG) == child; });
  if (!ended) {
    (void)kill(child, SIGKILL);
    (void)waitpid(child, nullptr, 0);
  }
  EXPECT_TRUE(ended);
  EXPECT_EQ(status, W_EXITCODE(6, 0));
  EXPECT_EQ(Publish(publisher, "the parent goes on"), HGROS_OK);
  hgros_session_end(session.get());
  waiting.join();
  EXPECT_EQ(hgros_transforms_close(transforms), HGROS_OK);
}

TEST_F(CProcesses, ServiceOfAnotherProcessAnswersUntilItIsKilled) {
  Peer peer({"serve", "shout"});
  const auto call = [&](hgros_message** reply) {
    return hgros_call(session.get(), "shout", text.get(), "hello", 5, nullptr, kPatienceNs, reply);
  };
  hgros_message* reply = nullptr;
  ASSERT_TRUE(Await([&] { return call(&reply) == HGROS_OK; })) << LastError();
  EXPECT_EQ(TextOf(reply), "HELLO");
  EXPECT_STREQ(hgros_schema_type_name(hgros_message_schema(reply)), "text");
  hgros_message_free(reply);
  peer.Kill();
  ASSERT_TRUE(Await([&] {
    const hgros_status status = call(&reply);
    hgros_message_free(reply);
    return status == HGROS_NO_SERVER;
  })) << LastError();
}

}  // namespace
}  // namespace hgros::test
