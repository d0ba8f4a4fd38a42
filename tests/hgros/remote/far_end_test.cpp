// The part of hgros run on another host, without ssh.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <optional>
#include <string>

#include "processes/message_stream.hpp"
#include "remote/remote.pb.h"
#include "support/await.hpp"
#include "support/path.hpp"

namespace hgros::cli {
namespace {

TEST(FarEnd, EndsWhenItFindsThatNobodyReadsWhatItsProgramPrints) {
  std::array<int, 2> in{};
  std::array<int, 2> out{};
  ASSERT_EQ(pipe2(in.data(), O_CLOEXEC), 0);
  ASSERT_EQ(pipe2(out.data(), O_CLOEXEC), 0);
  const std::string hgros = test::Path("hgros");
  const pid_t far = fork();
  if (far == 0) {
    (void)dup2(in[0], STDIN_FILENO);
    (void)dup2(out[1], STDOUT_FILENO);
    (void)execl(hgros.c_str(), "hgros", "__hosted", nullptr);
    _exit(127);
  }
  close(in[0]);
  close(out[1]);
  for (const int one : {in[1], out[0]}) (void)fcntl(one, F_SETFL, O_NONBLOCK);
  MessageStream to(in[1]);
  std::optional<MessageStream> from(out[0]);
  RemoteOrder order;
  RemoteOrder::Start& start = *order.mutable_start();
  start.set_file("robot.yaml");
  start.set_robot(
      "hosts: {desk: {address: 127.0.0.1, home: true}, base: {address: 127.0.0.2}}\n"
      "components: {a: {type: some/Type}}\n"
      "programs: {q: {host: base, command: [sh, -c, 'echo one; sleep 0.3; echo two; sleep 100d']}}\n");
  start.set_host("base");
  start.set_unit("q");
  to.Add(order);
  EXPECT_TRUE(to.Write());
  std::string printed;
  EXPECT_TRUE(test::Await([&] {
    (void)from->Read();
    RemoteReport report;
    while (from->Next(report)) printed += report.printed() + report.run().fault();
    return printed == "one";
  })) << printed;
  from.reset();
  int status = 0;
  if (!test::Await([&] { return waitpid(far, &status, WNOHANG) == far; })) {
    ADD_FAILURE() << "It stays.";
    (void)kill(far, SIGKILL);
    (void)waitpid(far, &status, 0);
  }
}

}  // namespace
}  // namespace hgros::cli
