// A server in another process that is killed during a call.
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>

#include "services/services_fixture.hpp"
#include "support/path.hpp"

namespace hgros::test {
namespace {

class ServerProcess {
 public:
  explicit ServerProcess(const std::string& yaml) {
    int ends[2];
    if (pipe(ends) != 0) std::abort();
    const std::string worker = Path("worker");
    pid_ = fork();
    if (pid_ == 0) {
      dup2(ends[1], STDOUT_FILENO);
      close(ends[0]);
      close(ends[1]);
      execl(worker.c_str(), worker.c_str(), yaml.c_str(), nullptr);
      _exit(127);
    }
    close(ends[1]);
    output_ = fdopen(ends[0], "r");
  }
  ServerProcess(const ServerProcess&) = delete;
  ServerProcess& operator=(const ServerProcess&) = delete;
  ~ServerProcess() {
    Kill();
    std::fclose(output_);
  }

  // The next line of its output; empty if it has ended.
  [[nodiscard]] std::string Line() {
    std::string line;
    for (int c = std::fgetc(output_); c != EOF && c != '\n'; c = std::fgetc(output_))
      line.push_back(static_cast<char>(c));
    return line;
  }
  [[nodiscard]] pid_t pid() const { return pid_; }
  void Kill() {
    if (pid_ <= 0) return;
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
    pid_ = -1;
  }

 private:
  pid_t pid_ = -1;
  std::FILE* output_ = nullptr;
};

class KilledServer : public DomainFixture {
 protected:
  static std::string YamlOfCaller(const std::string& endpoint = "tcp://127.0.0.1:*") {
    return "network: {publisher: {ip: '" + endpoint + "'}, heartbeat_ms: 100, peer_timeout_ms: 2000}\n" +
           "discovery: {local: false}\n";
  }
  /// Of a server that publishes there, and subscribes to the caller.
  static std::string YamlOf(const Robot& caller, const std::string& endpoint = "tcp://127.0.0.1:*") {
    return "network: {publisher: {ip: '" + endpoint + "'}, subscribers: [{ip: '" + caller->PublisherEndpoints().at(0) +
           "'}], heartbeat_ms: 100}\ndiscovery: {local: false}\n";
  }
};

class KilledServerProcess : public KilledServer, public testing::WithParamInterface<std::string> {};

TEST_P(KilledServerProcess, FailsItsCallsLongBeforeTheirTimeout) {
  const Bus bus;
  const auto endpoint = [&](const char* side) {
    return GetParam() == "ipc" ? bus.Endpoint(side) : "tcp://127.0.0.1:*";
  };
  const bool shares_memory = GetParam() == "sharedmemory";
  Robot robot(shares_memory ? "" : YamlOfCaller(endpoint("caller")), "caller");
  ServerProcess server(shares_memory ? "" : YamlOf(robot, endpoint("server")));
  std::string line = server.Line();
  if (line.starts_with("at ")) {
    robot->AddSubscriberEndpoint({line.substr(3), {}, true});
    line = server.Line();
  }
  ASSERT_EQ(line, "ready");
  const auto sum = robot->Call<Sum, Total>("add", Sum{20, 3}, kLong).Wait();
  ASSERT_TRUE(sum) << sum.failure().reason;
  EXPECT_EQ(sum->value, 23);

  const auto call_stuck = [&] { return robot->Call<Sum, Total>("stuck", Sum{}, kLong * 10); };
  std::vector<CallFuture<Total>> calls;
  calls.push_back(call_stuck());
  ASSERT_EQ(server.Line(), "begun");  // From here on calls are sent at once. Unsent ones would fail with kNoServer.
  while (calls.size() < 100) calls.push_back(call_stuck());
  server.Kill();
  for (const auto& call : calls) {
    const auto result = call.Wait();
    ASSERT_FALSE(result);
    EXPECT_EQ(result.failure().kind, Kind::kServerGone) << result.failure().reason;
    EXPECT_NE(result.failure().reason.find("Session server:"), std::string::npos) << result.failure().reason;
  }
  // Once its last transport is gone, the registry shows that there is no other server.
  if (shares_memory) {
    EXPECT_TRUE(Await([&] {
      const auto kind = robot->Call<Sum, Total>("add", Sum{}, kLong).Wait().failure().kind;
      EXPECT_TRUE(kind == Kind::kServerGone || kind == Kind::kNoServer);
      return kind == Kind::kNoServer;
    }));
  }
}

// The caller notices the end of a killed server on another host only after a peer timeout.
TEST_F(KilledServer, IsNotSaidToServeBesideTheOneThatReplacesIt) {
  Robot robot(YamlOfCaller(), "caller");
  std::unique_ptr<ServerProcess> server;
  for (int lives = 1; lives <= 3; ++lives) {
    server = std::make_unique<ServerProcess>(YamlOf(robot));
    const std::string line = server->Line();
    ASSERT_TRUE(line.starts_with("at ")) << line;
    robot->AddSubscriberEndpoint({line.substr(3), {}, true});
    if (lives == 1) {
      ASSERT_TRUE((robot->Call<Sum, Total>("add", Sum{20, 3}, kLong).Wait()));
    }
    const auto is_server = [&](const PeerInfo& peer) { return peer.pid == server->pid(); };
    ASSERT_TRUE(Await([&] { return std::ranges::any_of(robot->Peers(), is_server); }));
    if (lives < 3) server->Kill();
  }
  ASSERT_TRUE(Await([&] { return robot->Peers().size() == 1; }));
  const auto answers = [&] { return bool(robot->Call<Sum, Total>("add", Sum{20, 3}, kLong).Wait()); };
  ASSERT_TRUE(Await(answers));
  EXPECT_FALSE(robot.Said("served by more than one session"));
}

// Where it published, another one does: nobody waits until it was silent for long enough.
TEST_F(KilledServer, IsNotWaitedForWhenAnotherTakesItsPlace) {
  Robot robot(
      "network: {publisher: {ip: 'tcp://127.0.0.1:*'}, peer_timeout_ms: 600000}\n"
      "discovery: {local: false}\n",
      "caller");
  const auto answers = [&] { return bool(robot->Call<Sum, Total>("add", Sum{20, 3}, std::chrono::seconds(1)).Wait()); };
  std::string endpoint = "tcp://127.0.0.1:*";
  std::unique_ptr<ServerProcess> server;
  for (int lives = 1; lives <= 3; ++lives) {
    server = std::make_unique<ServerProcess>(YamlOf(robot, endpoint));
    const std::string line = server->Line();
    ASSERT_TRUE(line.starts_with("at ")) << line;
    if (lives == 1) {
      endpoint = line.substr(3);
      robot->AddSubscriberEndpoint({endpoint, {}, true});
    }
    ASSERT_TRUE(Await(answers)) << "life " << lives;
    EXPECT_TRUE(Await([&] { return robot->Peers().size() == 1; }));
    if (lives < 3) server->Kill();
  }
}

INSTANTIATE_TEST_SUITE_P(Placed, KilledServerProcess, testing::Values("sharedmemory", "ipc", "tcp"), TransportName);

}  // namespace
}  // namespace hgros::test
