#include "trial/component_trial.hpp"

#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <functional>
#include <set>
#include <system_error>
#include <utility>

#include "hgros/base/error.hpp"
#include "hgros/component/component.hpp"
#include "processes/message_stream.hpp"
#include "processes/process_end.hpp"
#include "terminal/console.hpp"
#include "terminal/pause.hpp"
#include "trial/description_message.hpp"

namespace hgros::cli {
namespace {

constexpr auto kPatience = std::chrono::seconds(10);  // For loading a library, and for each component.

// --- in the process that constructs ---

// Where it tells what it does.
class Teller {
 public:
  explicit Teller(int out) : stream_(out) {}

  void Tell(const TrialStep& step) {
    stream_.Add(step);
    if (!stream_.Write()) _exit(1);  // Nobody listens.
  }
  void Begin(const std::string& name) {
    TrialStep step;
    step.set_begins(name);
    Tell(step);
  }
  void Load(const std::string& library) {
    TrialStep step;
    step.set_loads(library);
    Tell(step);
  }
  void Fault(const Error& fault) {
    TrialStep step;
    step.mutable_fault()->set_what(fault.sentence());
    step.mutable_fault()->set_where(fault.where());
    step.mutable_fault()->set_mend(fault.mend());
    Tell(step);
  }

 private:
  MessageStream stream_;
};

// A session that finds no others, and the components that are tried in it.
class DryRun {
 public:
  explicit DryRun(Teller& teller) : teller_(teller) {}

  void Construct(const ComponentSetup& setup) {
    try {
      TrialStep step;
      *step.mutable_made() = MessageOf(components_.Add(setup));
      components_.End(setup.name);  // A destructor may fail, too.
      teller_.Tell(step);
    } catch (const ComponentError& error) {
      for (const Error& fault : error.faults()) teller_.Fault(fault);
    } catch (const std::exception& error) {
      teller_.Fault(Error(error.what()));
    }
  }

 private:
  Teller& teller_;
  Session session_{Config::Parse("discovery: {domain: none, local: false}\ncontrol: off\n"),
                   {.name = "trial", .log = [](LogLevel, std::string_view) {}}};
  Components components_{session_,
                         {.log = [](std::string_view, LogLevel, std::string_view) {},
                          .on_change = {},
                          .all_inline = false,
                          .offer_params = false}};
};

using TriedNames = std::set<std::string>;

void TryTypes(Teller& teller, const std::filesystem::path& library, const std::vector<std::string>& types,
              const TriedNames& known) {
  teller.Load(library.string());
  for (const std::string& type : LoadComponents(library)) {
    if (known.contains(type) || (!types.empty() && std::ranges::find(types, type) == types.end())) continue;
    teller.Begin(type);
    DryRun(teller).Construct({.name = type, .type = type});
  }
}

void TryEach(Teller& teller, const std::vector<ComponentSetup>& setups, const ComponentCatalog& catalog,
             const TriedNames& known) {
  DryRun dry_run(teller);
  for (const ComponentSetup& setup : setups) {
    if (known.contains(setup.name)) continue;
    teller.Begin(setup.name);
    try {
      teller.Load(catalog.Find(setup.type).file.string());
      (void)catalog.Load(setup.type);
    } catch (const Error& error) {
      teller.Fault(Error("Component \"" + setup.name + "\": " + error.sentence(), error.where(), error.mend()));
      continue;
    } catch (const std::exception& error) {
      teller.Fault(Error("Component \"" + setup.name + "\": " + error.what()));
      continue;
    }
    teller.Load({});
    dry_run.Construct(setup);
  }
}

// In a process of its own: leaves out the names in `known`.
using Body = std::function<void(Teller& teller, const TriedNames& known)>;

[[noreturn]] void RunTrial(int out, const Body& body, const TriedNames& known) {
  (void)prctl(PR_SET_PDEATHSIG, SIGKILL);
  (void)setpgid(0, 0);  // With all that it starts.
  for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGPIPE}) (void)signal(number, SIG_DFL);
  (void)dup2(STDERR_FILENO, STDOUT_FILENO);  // What a library prints is not the command's output.
  const int nothing = open("/dev/null", O_RDONLY | O_CLOEXEC);
  if (nothing >= 0) (void)dup2(nothing, STDIN_FILENO);
  (void)unsetenv("HGROS_DOMAIN");
  static int told_to = -1;  // Processes that a library forks do not hold it: its end is that of this one.
  told_to = out;
  (void)pthread_atfork(nullptr, nullptr, [] { close(told_to); });
  Teller teller(out);
  try {
    body(teller, known);
    TrialStep step;
    step.set_done(true);
    teller.Tell(step);
  } catch (const std::exception& error) {
    teller.Fault(Error(error.what()));
  }
  _exit(0);
}

// --- in the process that asked ---

// A child process and the pipe from it. Ends it.
class Trial {
 public:
  Trial(const Body& body, const TriedNames& known) : Trial(Begin(body, known)) {}
  Trial(const Trial&) = delete;
  Trial& operator=(const Trial&) = delete;
  ~Trial() {
    if (child_ > 0) (void)Kill();
  }

  enum class Heard { kStep, kEnd, kLate };
  // Throws OutputClosed if the user has ended the command.
  [[nodiscard]] Heard Next(TrialStep& step, Pause& pause) {
    const auto deadline = std::chrono::steady_clock::now() + kPatience;
    while (!stream_.Next(step)) {
      switch (pause.UntilReadable(stream_.descriptor(), deadline)) {
        case Pause::End::kInterrupted: throw OutputClosed();
        case Pause::End::kDeadline: return Heard::kLate;
        case Pause::End::kWoken: break;
      }
      if (!stream_.Read()) return stream_.Next(step) ? Heard::kStep : Heard::kEnd;
    }
    return Heard::kStep;
  }
  // Its wait status; ends it if it does not end soon.
  int End(Pause& pause) {
    const auto deadline = std::chrono::steady_clock::now() + kPatience;
    while (!HasEnded() && std::chrono::steady_clock::now() < deadline) {
      if (pause.For(std::chrono::milliseconds(5)) == Pause::End::kInterrupted) throw OutputClosed();
    }
    return Kill();
  }
  // What a library has started ends, too.
  int Kill() {
    (void)kill(child_, SIGKILL);
    (void)kill(-child_, SIGKILL);
    int status = 0;
    while (waitpid(child_, &status, 0) < 0 && errno == EINTR) {
    }
    child_ = -1;
    return status;
  }

 private:
  struct Begun {
    pid_t child;
    int in;
  };
  explicit Trial(Begun begun) : child_(begun.child), stream_(begun.in) {}

  [[nodiscard]] static Begun Begin(const Body& body, const TriedNames& known) {
    std::array<int, 2> ends{};
    if (pipe2(ends.data(), O_CLOEXEC) != 0) Refuse("a pipe");
    const pid_t child = fork();
    if (child < 0) Refuse("a process");
    if (child == 0) {
      close(ends[0]);
      RunTrial(ends[1], body, known);
    }
    close(ends[1]);
    (void)setpgid(child, child);
    (void)fcntl(ends[0], F_SETFL, O_NONBLOCK);
    return {child, ends[0]};
  }
  // It is not reaped yet, so that its number stays its own.
  [[nodiscard]] bool HasEnded() const {
    siginfo_t info{};
    const int failed = waitid(P_PID, static_cast<id_t>(child_), &info, WEXITED | WNOWAIT | WNOHANG);
    return failed == 0 && info.si_pid != 0;
  }
  [[noreturn]] static void Refuse(const std::string& what) {
    throw Error("The system refused " + what + " to load a library in: " + std::generic_category().message(errno) +
                ".");
  }

  pid_t child_ = -1;
  MessageStream stream_;
};

// Runs trials until one has ended by itself: after a component that does not return, another goes on with the rest.
class Trials {
 public:
  explicit Trials(Body body) : body_(std::move(body)) {}

  void Run(Pause& pause) {
    while (!ended_) RunOne(pause);
  }
  [[nodiscard]] std::vector<TriedComponent>& tried() noexcept { return tried_; }
  // Why no component could be tried.
  [[nodiscard]] const std::string& fault() const noexcept { return fault_; }

 private:
  void RunOne(Pause& pause) {
    Trial trial(body_, known_);
    name_.clear();
    loads_.clear();
    TrialStep step;
    while (true) {
      switch (trial.Next(step, pause)) {
        case Trial::Heard::kEnd:
          return NoteFault(Error(Doing() + "does not return: " + EndText(trial.End(pause)) + "."));
        case Trial::Heard::kLate:
          (void)trial.Kill();
          return NoteFault(Error(Doing() + "took longer than " + std::to_string(kPatience.count()) + " s."));
        case Trial::Heard::kStep: break;
      }
      if (step.has_begins()) {
        name_ = step.begins();
        loads_.clear();
        known_.insert(name_);
      } else if (step.has_loads()) {
        loads_ = step.loads();
      } else if (step.has_made()) {
        tried_.push_back({name_, DescriptionFrom(step.made()), {}});
      } else if (step.has_fault()) {
        NoteFault(Error(step.fault().what(), step.fault().where(), step.fault().mend()));
        if (ended_) return;
      } else {
        ended_ = true;
        return;
      }
    }
  }

  // The beginning of a fault.
  [[nodiscard]] std::string Doing() const {
    const std::string component = name_.empty() ? std::string() : "Component \"" + name_ + "\": ";
    if (loads_.empty()) return component + "its constructor or destructor ";
    return component + (name_.empty() ? "Loading the library " : "loading its library " + loads_ + " ");
  }

  void NoteFault(const Error& fault) {
    if (name_.empty()) {
      fault_ = fault.what();
      ended_ = true;
    } else {
      if (tried_.empty() || tried_.back().name != name_) tried_.push_back({name_, {}, {}});
      tried_.back().faults.push_back(fault);
    }
  }

  const Body body_;
  std::vector<TriedComponent> tried_;
  std::string fault_;
  TriedNames known_;
  std::string name_;   // What is constructed now,
  std::string loads_;  // or the library that is loaded.
  bool ended_ = false;
};

}  // namespace

TriedLibrary TryLibrary(const std::filesystem::path& library, const std::vector<std::string>& types, Pause& pause) {
  Trials trials([&](Teller& teller, const TriedNames& known) { TryTypes(teller, library, types, known); });
  trials.Run(pause);
  std::ranges::sort(trials.tried(), {}, &TriedComponent::name);
  return {library, std::move(trials.tried()), trials.fault()};
}

std::vector<TriedComponent> TryComponents(const std::vector<ComponentSetup>& setups, const ComponentCatalog& catalog,
                                          Pause& pause) {
  Trials trials([&](Teller& teller, const TriedNames& known) { TryEach(teller, setups, catalog, known); });
  trials.Run(pause);
  if (!trials.fault().empty()) throw Error(trials.fault());
  return std::move(trials.tried());
}

}  // namespace hgros::cli
