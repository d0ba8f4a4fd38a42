// A program that may not open files or start threads any more.
//
//   --lack=files|threads  what it lacks
//   --left=N,N,...        how many more it may have: each time a process of its own, one after the other
//   --when=before|after|wired  whether the limit comes before the session, after it, or after the subscription
//   --do=WHAT             publisher or subscriber (an endpoint; with --when=before it is in the configuration), lan, or
//                         node (a subscription on the workers, which then gets three messages)
//
// Writes "log: LINE" for each line of the session's log, "error: WHAT" for an Error, "got N" messages, "done", and at
// the end of each process "end LEFT STATUS", as of waitpid(). Exit status 77: this machine has no user namespaces.
#include <sched.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <iterator>
#include <sstream>
#include <string>

#include <foxglove/Log.pb.h>

#include "hgros/hgros.hpp"
#include "resilience/worker_program.hpp"
#include "support/await.hpp"

namespace hgros::resilience {
namespace {

using foxglove::Log;

constexpr int kForbidden = 77;

// The limit of threads counts all of the user in a namespace, and does not apply to root.
bool BecomeSomebody() {
  constexpr uid_t kNobody = 65534;
  if (geteuid() == 0 && (setresgid(kNobody, kNobody, kNobody) != 0 || setresuid(kNobody, kNobody, kNobody) != 0)) {
    return false;
  }
  prctl(PR_SET_DUMPABLE, 1);
  return unshare(CLONE_NEWUSER) == 0;
}

std::size_t Count(const char* folder) {
  const std::filesystem::directory_iterator all(folder);
  return static_cast<std::size_t>(std::distance(begin(all), end(all)));
}

class Program {
 public:
  Program(const Arguments& arguments, std::size_t left)
      : lack_(arguments.Text("lack")), left_(left), when_(arguments.Text("when")), what_(arguments.Text("do")) {}

  int Run() {
    if (lack_ == "threads" && !BecomeSomebody()) return kForbidden;
    try {
      Live();
    } catch (const Error& error) {
      Say(std::string("error: ") + error.what());
    }
    Say("done");
    return 0;
  }

 private:
  void Limit() const {
    const bool files = lack_ == "files";
    const auto kind = files ? RLIMIT_NOFILE : RLIMIT_NPROC;
    rlimit limit{};
    getrlimit(kind, &limit);
    // Its own descriptor of the folder is counted too.
    limit.rlim_cur = files ? Count("/proc/self/fd") - 1 + left_ : Count("/proc/self/task") + left_;
    setrlimit(kind, &limit);
  }

  [[nodiscard]] std::string Configured() const {
    std::string config = "data_graph: {threads: 3}\n";
    if (what_ == "lan") return config + "discovery: {lan: true}";
    if (when_ != "before" || what_ == "node") return config;
    return config + (what_ == "publisher" ? "network: {publisher: {ip: \"tcp://127.0.0.1:*\"}}"
                                          : "network: {subscribers: [{ip: \"tcp://127.0.0.1:9\"}]}");
  }

  void Live() {
    if (when_ == "before") Limit();
    Session session(Config::Parse(Configured()), {"limited", [](LogLevel level, std::string_view line) {
                                                    if (level != LogLevel::kDebug) Say("log: " + std::string(line));
                                                  }});
    std::atomic<int> got{0};
    NodeOptions options;
    if (what_ != "node") options.executor = Executor::Inline();
    if (when_ == "after") Limit();
    if (when_ == "after" && what_ == "publisher") session.AddPublisherEndpoint({"tcp://127.0.0.1:*", {}, true});
    if (when_ == "after" && what_ == "subscriber") session.AddSubscriberEndpoint({"tcp://127.0.0.1:9", {}, true});
    const auto node = session.FromAny<Log>(
        "log", Invoke::kSerial, [&](const Log&) { ++got; }, options);
    const auto publish = session.Advertise<Log>("log");
    if (when_ == "wired") Limit();
    for (int i = 0; i < 3; ++i) (void)publish(std::make_unique<Log>());
    (void)test::Await([&] { return got == 3; }, std::chrono::seconds(5));
    Say("got " + std::to_string(got));
  }

  const std::string lack_;
  const std::size_t left_;
  const std::string when_;
  const std::string what_;
};

}  // namespace
}  // namespace hgros::resilience

int main(int count, char** texts) {
  const hgros::resilience::Arguments arguments(count, texts);
  std::istringstream lefts(arguments.Text("left"));
  for (std::string left; std::getline(lefts, left, ',');) {
    const pid_t child = fork();
    if (child == 0) {
      alarm(60);  // It must not hang.
      return hgros::resilience::Program(arguments, std::stoull(left)).Run();
    }
    int status = 0;
    waitpid(child, &status, 0);
    hgros::resilience::Say("end " + left + " " + std::to_string(status));
  }
}
