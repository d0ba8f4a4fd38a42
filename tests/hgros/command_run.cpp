#include "hgros/command_run.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <iterator>
#include <sstream>
#include <utility>

#include "support/at_once.hpp"
#include "support/path.hpp"

extern char** environ;  // NOLINT(readability-redundant-declaration): POSIX has no header for it.

namespace hgros::cli {

namespace {

// The tests run without a domain, which hides the others. One at a time: all threads have one environment.
std::unique_ptr<Session> MakeSession(const std::string& name, const std::string& domain, const std::string& config) {
  static std::mutex making;
  const std::scoped_lock lock(making);
  const char* before = std::getenv("HGROS_DOMAIN");
  const std::string kept = before == nullptr ? "" : before;
  setenv("HGROS_DOMAIN", domain.c_str(), 1);
  auto session =
      std::make_unique<Session>(Config::Parse(config), SessionOptions{name, [](LogLevel, std::string_view) {}});
  setenv("HGROS_DOMAIN", kept.c_str(), 1);
  return session;
}

}  // namespace

CommandRun::CommandRun(std::vector<std::string> arguments, const std::map<std::string, std::string>& environment,
                       int output, const std::string& program) {
  int out[2];
  int err[2];
  if (pipe2(out, O_CLOEXEC) != 0 || pipe2(err, O_CLOEXEC) != 0) throw Error("no pipe");
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, output >= 0 ? output : out[1], STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, err[1], STDERR_FILENO);
  arguments.insert(arguments.begin(), program);
  std::vector<char*> words;
  for (std::string& argument : arguments) words.push_back(argument.data());
  words.push_back(nullptr);
  std::vector<std::string> settings;
  for (char** one = environ; *one != nullptr; ++one) {
    const std::string text(*one);
    if (!environment.contains(text.substr(0, text.find('=')))) settings.push_back(text);
  }
  for (const auto& [name, value] : environment) settings.push_back(name + "=" + value);
  std::vector<char*> all;
  for (std::string& setting : settings) all.push_back(setting.data());
  all.push_back(nullptr);
  const int failed = posix_spawn(&pid_, program.c_str(), &actions, nullptr, words.data(), all.data());
  posix_spawn_file_actions_destroy(&actions);
  close(out[1]);
  close(err[1]);
  if (failed != 0) throw Error("the command cannot be started");
  out_end_ = out[0];
  out_reader_ = std::thread([this, end = out[0]] { Read(end, out_); });
  err_reader_ = std::thread([this, end = err[0]] {
    Read(end, err_);
    close(end);
  });
}

CommandRun::~CommandRun() {
  if (!ended_) {
    (void)kill(pid_, SIGKILL);
    (void)Wait();
  }
  out_reader_.join();
  err_reader_.join();
  close(out_end_);
}

void CommandRun::Read(int descriptor, std::string& text) {
  char buffer[4096];
  for (ssize_t count = 0; (count = read(descriptor, buffer, sizeof buffer)) > 0;) {
    const std::scoped_lock lock(mutex_);
    text.append(buffer, static_cast<std::size_t>(count));
  }
}

void CommandRun::Signal(int number) const { (void)kill(pid_, number); }

void CommandRun::End(int signal) {
  Signal(signal);
  EXPECT_EQ(Wait(), 128 + signal) << out() << err();
}

int CommandRun::Wait(std::chrono::nanoseconds patience) {
  const bool in_time = test::Await(
      [this] {
        int status = 0;
        if (waitpid(pid_, &status, WNOHANG) != pid_) return false;
        status_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
        return true;
      },
      patience);
  ended_ = in_time;
  if (!in_time) return -1;
  if (out_reader_.joinable()) out_reader_.join();
  if (err_reader_.joinable()) err_reader_.join();
  out_reader_ = std::thread([] {});
  err_reader_ = std::thread([] {});
  return status_;
}

bool CommandRun::Prints(const std::string& text, std::chrono::nanoseconds patience) const {
  const auto contains = [&, seen = std::size_t{0}]() mutable {
    const std::scoped_lock lock(mutex_);
    const bool found = out_.find(text, seen) != std::string::npos;
    seen = out_.size() - std::min(out_.size(), text.size());
    return found;
  };
  return test::Await(contains, patience);
}

std::string CommandRun::out() const {
  const std::scoped_lock lock(mutex_);
  return out_;
}

std::string CommandRun::err() const {
  const std::scoped_lock lock(mutex_);
  return err_;
}

std::vector<std::string> Patiently(std::vector<std::string> arguments) {
  constexpr const char* kSeconds = "40";
  const auto given = std::ranges::find(arguments, "--timeout");
  if (given == arguments.end()) {
    arguments.insert(arguments.end(), {"--timeout", kSeconds});
  } else {
    *std::next(given) = kSeconds;
  }
  return arguments;
}

CommandEnd RunInShell(const std::string& script, std::map<std::string, std::string> environment) {
  environment["HGROS"] = test::Path("hgros");
  CommandRun run({"-c", script}, environment, -1, "/bin/sh");
  const int status = run.Wait();
  return {status, run.out(), run.err()};
}

CommandEnd RunToEnd(std::vector<std::string> arguments, const std::map<std::string, std::string>& environment) {
  CommandRun run(std::move(arguments), environment);
  const int status = run.Wait();
  return {status, run.out(), run.err()};
}

CommandEnd RunUntil(const std::vector<std::string>& arguments, const std::map<std::string, std::string>& environment,
                    const testing::Matcher<const CommandEnd&>& ends) {
  CommandEnd end;
  (void)test::Await([&] { return ends.Matches(end = RunToEnd(arguments, environment)); });
  EXPECT_THAT(end, ends);
  return end;
}

void TwoAtATime(std::size_t count, const std::function<void(std::size_t)>& act) {
  const auto every_second = [&](std::size_t i) {
    for (; i < count; i += 2) act(i);
  };
  test::AtOnce({[&] { every_second(0); }, [&] { every_second(1); }});
}

std::map<std::string, std::string> OwnDomain() { return {{"HGROS_DOMAIN", "cli" + std::to_string(RandomId())}}; }

RobotForCommands::RobotForCommands(const std::string& name, const std::string& domain, const std::string& config)
    : domain_(domain.empty() ? OwnDomain()["HGROS_DOMAIN"] : domain), session_(MakeSession(name, domain_, config)) {}

CommandEnd RobotForCommands::Run(std::vector<std::string> arguments) const {
  AwaitAnnounced();
  return RunToEnd(std::move(arguments), environment());
}

CommandEnd RobotForCommands::RunUntil(const std::vector<std::string>& arguments,
                                      const testing::Matcher<const CommandEnd&>& ends) const {
  AwaitAnnounced();
  return cli::RunUntil(arguments, environment(), ends);
}

void RobotForCommands::AwaitAnnounced() const {
  const auto uses = [who = session_->id()](const Session& session) {
    std::multiset<std::string> names;
    for (const KnownChannel& channel : session.Channels()) {
      for (const auto* users : {&channel.publishers, &channel.subscribers}) {
        for (const ChannelUser& user : *users) {
          if (user.session == who) names.insert(channel.name);
        }
      }
    }
    return names;
  };
  const std::scoped_lock lock(announcing_);
  if (uses(*session_) == announced_) return;
  const std::unique_ptr<Session> observer = MakeSession("observer", domain_, {});
  const Subscription any = observer->FromAnyRaw("observed", Invoke::kSerial, [](const RawMessage&) {});
  if (!test::Await([&] { return uses(*observer).size() >= uses(*session_).size(); })) {
    throw Error("the robot is not announced");
  }
  announced_ = uses(*session_);
}

std::vector<std::string> LinesOf(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

}  // namespace hgros::cli
