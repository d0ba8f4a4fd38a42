#include "placement/component_trial.hpp"

#include <fcntl.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <set>
#include <system_error>
#include <utility>

#include "hgros/base/error.hpp"
#include "hgros/component/component.hpp"
#include "hgros/component/components.hpp"
#include "placement/trial.pb.h"
#include "terminal/console.hpp"
#include "terminal/pause.hpp"

namespace hgros::cli {
namespace {

constexpr auto kPatience = std::chrono::seconds(10);  // For loading a library, and for each component.
constexpr std::uint32_t kMostStepBytes = 16U << 20U;

// --- in the process that constructs ---

void Tell(int out, const TrialStep& step) {
  const std::string bytes = step.SerializeAsString();
  std::string framed(4, '\0');
  const auto size = static_cast<std::uint32_t>(bytes.size());
  memcpy(framed.data(), &size, 4);
  framed += bytes;
  for (std::size_t written = 0; written < framed.size();) {
    const ssize_t more = write(out, framed.data() + written, framed.size() - written);
    if (more < 0 && errno == EINTR) continue;
    if (more <= 0) _exit(1);  // Nobody listens.
    written += static_cast<std::size_t>(more);
  }
}

void TellBegin(int out, const std::string& type) {
  TrialStep step;
  step.set_begins(type);
  Tell(out, step);
}

void TellFault(int out, const std::string& what) {
  TrialStep step;
  step.set_fault(what);
  Tell(out, step);
}

void Write(const std::vector<ComponentChannel>& channels,
           google::protobuf::RepeatedPtrField<TrialStep::Channel>& written) {
  for (const ComponentChannel& one : channels) {
    TrialStep::Channel& to = *written.Add();
    to.set_name(one.name);
    to.set_channel(one.channel);
    to.set_type(one.type);
    to.set_node(one.node);
  }
}

void Write(const std::vector<ComponentService>& services,
           google::protobuf::RepeatedPtrField<TrialStep::Service>& written) {
  for (const ComponentService& one : services) {
    TrialStep::Service& to = *written.Add();
    to.set_name(one.name);
    to.set_service(one.service);
    to.set_request(one.request);
    to.set_reply(one.reply);
  }
}

void Write(const ComponentDescription& description, TrialStep::Made& made) {
  Write(description.inputs, *made.mutable_inputs());
  Write(description.outputs, *made.mutable_outputs());
  Write(description.services, *made.mutable_services());
  Write(description.calls, *made.mutable_calls());
  for (const ComponentTimer& one : description.timers) {
    TrialStep::Timer& to = *made.add_timers();
    to.set_name(one.name);
    to.set_period_ns(one.period.count());
  }
  for (const ParamDeclaration& one : description.params) {
    TrialStep::Param& to = *made.add_params();
    to.set_path(one.path);
    to.set_description(one.info.description);
    to.set_unit(one.info.unit);
    if (one.info.least) to.set_least(*one.info.least);
    if (one.info.most) to.set_most(*one.info.most);
    for (const std::string& choice : one.info.choices) to.add_choices(choice);
    to.set_read_only(one.info.read_only);
    to.set_type(one.type);
    to.set_fallback(one.fallback);
  }
  made.set_state(description.state);
}

void Construct(int out, const std::string& type) {
  try {
    Session session(Config::Parse("discovery: {domain: none, local: false}\ncontrol: off\n"),
                    {.name = "trial", .log = [](LogLevel, std::string_view) {}});
    Components components(session, {.log = [](std::string_view, LogLevel, std::string_view) {},
                                    .on_change = {},
                                    .all_inline = false,
                                    .offer_params = false});
    TrialStep step;
    Write(components.Add({.name = type, .type = type}), *step.mutable_made());
    components.End(type);  // A destructor may fail, too.
    Tell(out, step);
  } catch (const std::exception& error) {
    TellFault(out, error.what());
  }
}

// Constructs the types that are not in `known`.
[[noreturn]] void RunTrial(int out, const std::filesystem::path& library, const std::vector<std::string>& types,
                           const std::set<std::string>& known) {
  (void)prctl(PR_SET_PDEATHSIG, SIGKILL);
  for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGPIPE}) (void)signal(number, SIG_DFL);
  (void)dup2(STDERR_FILENO, STDOUT_FILENO);  // What a library prints is not the command's output.
  const int nothing = open("/dev/null", O_RDONLY | O_CLOEXEC);
  if (nothing >= 0) (void)dup2(nothing, STDIN_FILENO);
  (void)unsetenv("HGROS_DOMAIN");
  try {
    TellBegin(out, {});
    for (const std::string& type : LoadComponents(library)) {
      if (known.contains(type) || (!types.empty() && std::ranges::find(types, type) == types.end())) continue;
      TellBegin(out, type);
      Construct(out, type);
    }
    TrialStep step;
    step.set_done(true);
    Tell(out, step);
  } catch (const std::exception& error) {
    TellFault(out, error.what());
  }
  _exit(0);
}

// --- in the process that asked ---

std::vector<ComponentChannel> Read(const google::protobuf::RepeatedPtrField<TrialStep::Channel>& channels) {
  std::vector<ComponentChannel> read;
  for (const TrialStep::Channel& one : channels) read.push_back({one.name(), one.channel(), one.type(), one.node()});
  return read;
}

std::vector<ComponentService> Read(const google::protobuf::RepeatedPtrField<TrialStep::Service>& services) {
  std::vector<ComponentService> read;
  for (const TrialStep::Service& one : services) {
    read.push_back({one.name(), one.service(), one.request(), one.reply()});
  }
  return read;
}

ComponentDescription Read(const std::string& type, const TrialStep::Made& made) {
  ComponentDescription description;
  description.type = type;
  description.inputs = Read(made.inputs());
  description.outputs = Read(made.outputs());
  description.services = Read(made.services());
  description.calls = Read(made.calls());
  for (const TrialStep::Timer& one : made.timers()) {
    description.timers.push_back({one.name(), Duration(one.period_ns())});
  }
  for (const TrialStep::Param& one : made.params()) {
    ParamInfo info{one.description(), one.unit(), {}, {}, {one.choices().begin(), one.choices().end()},
                   one.read_only()};
    if (one.has_least()) info.least = one.least();
    if (one.has_most()) info.most = one.most();
    description.params.push_back({one.path(), std::move(info), one.type(), one.fallback()});
  }
  description.state = made.state();
  return description;
}

// How a process ended that should have gone on: "It called exit(3)".
std::string EndText(int status) {
  if (WIFSIGNALED(status)) {
    const char* name = sigabbrev_np(WTERMSIG(status));
    return "it was ended by SIG" + std::string(name != nullptr ? name : std::to_string(WTERMSIG(status)));
  }
  return "it ended the process with exit code " + std::to_string(WEXITSTATUS(status));
}

// The beginning of a fault; `type` is empty while the library is loaded.
std::string Named(const std::string& type) {
  return type.empty() ? "Loading the library " : "Component \"" + type + "\": its constructor or destructor ";
}

// A child process and the pipe from it. Ends it.
class Trial {
 public:
  Trial(const std::filesystem::path& library, const std::vector<std::string>& types,
        const std::set<std::string>& known) {
    std::array<int, 2> ends{};
    if (pipe2(ends.data(), O_CLOEXEC) != 0) Refuse("a pipe");
    child_ = fork();
    if (child_ < 0) Refuse("a process");
    if (child_ == 0) {
      close(ends[0]);
      RunTrial(ends[1], library, types, known);
    }
    close(ends[1]);
    in_ = ends[0];
    (void)fcntl(in_, F_SETFL, O_NONBLOCK);
  }
  Trial(const Trial&) = delete;
  Trial& operator=(const Trial&) = delete;
  ~Trial() {
    close(in_);
    if (child_ > 0) (void)Kill();
  }

  enum class Heard { kStep, kEnd, kLate };
  // Throws OutputClosed if the user has ended the command.
  [[nodiscard]] Heard Next(TrialStep& step, Pause& pause) {
    const auto deadline = std::chrono::steady_clock::now() + kPatience;
    std::string size;
    if (const Heard heard = Fill(size, 4, deadline, pause); heard != Heard::kStep) return heard;
    std::uint32_t bytes = 0;
    memcpy(&bytes, size.data(), 4);
    if (bytes > kMostStepBytes) return Heard::kEnd;
    std::string body;
    if (const Heard heard = Fill(body, bytes, deadline, pause); heard != Heard::kStep) return heard;
    return step.ParseFromString(body) ? Heard::kStep : Heard::kEnd;
  }
  // Its wait status, once it has ended.
  int Wait() {
    int status = 0;
    while (waitpid(child_, &status, 0) < 0 && errno == EINTR) {
    }
    child_ = -1;
    return status;
  }
  // The same; ends it if it does not end soon.
  int End(Pause& pause) {
    const auto deadline = std::chrono::steady_clock::now() + kPatience;
    for (int status = 0; std::chrono::steady_clock::now() < deadline;) {
      if (waitpid(child_, &status, WNOHANG) == child_) {
        child_ = -1;
        return status;
      }
      if (pause.For(std::chrono::milliseconds(5)) == Pause::End::kInterrupted) throw OutputClosed();
    }
    return Kill();
  }
  int Kill() {
    (void)kill(child_, SIGKILL);
    return Wait();
  }

 private:
  [[noreturn]] static void Refuse(const std::string& what) {
    throw Error("The system refused " + what + " to load a library in: " + std::generic_category().message(errno) +
                ".");
  }
  Heard Fill(std::string& text, std::size_t wanted, std::chrono::steady_clock::time_point deadline, Pause& pause) {
    while (text.size() < wanted) {
      switch (pause.UntilReadable(in_, deadline)) {
        case Pause::End::kInterrupted: throw OutputClosed();
        case Pause::End::kDeadline: return Heard::kLate;
        case Pause::End::kWoken: break;
      }
      std::array<char, 4096> buffer{};
      const ssize_t more = read(in_, buffer.data(), std::min(buffer.size(), wanted - text.size()));
      if (more < 0 && (errno == EINTR || errno == EAGAIN)) continue;
      if (more <= 0) return Heard::kEnd;
      text.append(buffer.data(), static_cast<std::size_t>(more));
    }
    return Heard::kStep;
  }

  pid_t child_ = -1;
  int in_ = -1;
};

}  // namespace

TriedLibrary TryComponents(const std::filesystem::path& library, const std::vector<std::string>& types, Pause& pause) {
  TriedLibrary tried{library, {}, {}};
  std::set<std::string> known;
  for (bool goes_on = true; goes_on;) {
    Trial trial(library, types, known);
    goes_on = false;
    std::string current;
    const auto note = [&](std::string fault) {
      if (current.empty()) {
        tried.fault = std::move(fault);
        return;
      }
      tried.components.push_back({current, {}, std::move(fault)});
      goes_on = true;  // With the other types, in another process.
    };
    for (bool done = false; !done;) {
      TrialStep step;
      switch (trial.Next(step, pause)) {
        case Trial::Heard::kEnd:
          note(Named(current) + "does not return: " + EndText(trial.End(pause)) + ".");
          done = true;
          break;
        case Trial::Heard::kLate:
          (void)trial.Kill();
          note(Named(current) + "took longer than " + std::to_string(kPatience.count()) + " s.");
          done = true;
          break;
        case Trial::Heard::kStep:
          if (step.has_begins()) {
            current = step.begins();
            if (!current.empty()) known.insert(current);
          } else if (step.has_made()) {
            tried.components.push_back({current, Read(current, step.made()), {}});
          } else if (step.has_fault()) {
            note(step.fault());
            goes_on = false;
            done = current.empty();
          } else {
            done = true;
          }
      }
    }
  }
  std::ranges::sort(tried.components, {}, &TriedComponent::type);
  return tried;
}

}  // namespace hgros::cli
