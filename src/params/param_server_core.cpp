#include "params/param_server_core.hpp"

#include <chrono>
#include <condition_variable>
#include <exception>
#include <utility>

#include "hgros/base/error.hpp"
#include "hgros/base/forced_unwind.hpp"
#include "hgros/base/names.hpp"
#include "hgros/base/system_limits.hpp"
#include "hgros/yaml/document.hpp"
#include "params/yaml_edit.hpp"
#include "params/yaml_writing.hpp"

namespace hgros {
namespace {

constexpr auto kTimeToDeclare = std::chrono::seconds(5);
constexpr std::size_t kManyEvents = 64;  // That wait for listeners.
constexpr auto kListenerPatience = std::chrono::seconds(1);

// A step that removes a parameter has no value.
void RequireThere(const ParamNodePtr& root, const ParamPath& path, bool removes) {
  if (param_tree::Find(root, path) != nullptr) return;
  const std::string name = path.ToString();
  const std::string nearest = NearestName(name, param_tree::ListBelow(ParamView(root)));
  throw ParamError(
      "There is no parameter " + name + "." + (nearest.empty() ? std::string() : " Did you mean " + nearest + "?"), {},
      removes ? "" : "To create it, pass IfMissing::kCreate.");
}

// Whether `text` is an argument of a command line or the environment, as it was written.
bool IsArgument(const ParamNode& node) {
  const bool whole = node.kind == ParamNode::Kind::kText || !node.text.empty();
  return whole && node.origin.source != nullptr && node.origin.line == 0 && !node.origin.at_run_time;
}

}  // namespace

ParamServer::Core::Core(ParamSources sources, LogSink log)
    : sources_(std::move(sources)), log_(std::move(log)), loaded_(ReadSources(&unknown_)), root_(loaded_) {
  if (unknown_.empty() || sources_.section) return;
  try {
    waits_ = StartThread<std::jthread>("the thread that waits for declarations", [this](const std::stop_token& stop) {
      std::mutex mutex;
      std::condition_variable_any never;
      std::unique_lock lock(mutex);
      never.wait_for(lock, stop, kTimeToDeclare, [] { return false; });
      if (!stop.stop_requested()) SayUndeclared();
    });
  } catch (const Error&) {  // There is no thread left: this is said at the end.
  }
}

ParamServer::Core::~Core() {
  waits_ = {};
  if (!sources_.section && std::uncaught_exceptions() == 0)
    SayUndeclared();  // Otherwise the program had no time to declare all.
}

ParamNodePtr ParamServer::Core::ReadSources(std::vector<ParamOverride>* unknown) const {
  ParamNodePtr root = sources_.section ? sources_.section : param_tree::EmptyRoot();
  for (const std::filesystem::path& file : sources_.files) {
    const ParamNodePtr all = param_tree::FromDocument(yaml::Document::Load(file));
    root = param_tree::Merged(root, sources_.section ? all : param_tree::WithoutSession(all));
  }
  const ParamNodePtr in_files = root;
  for (const ParamOverride& said : sources_.overrides) {
    const ParamPath path = ParamPath::Parse(said.path);
    RequireFree(path);
    if (unknown != nullptr && param_tree::Find(in_files, path) == nullptr) unknown->push_back(said);
    root = param_tree::With(root, path, param_tree::FromArgument(said.value, said.said));
  }
  return root;
}

void ParamServer::Core::RequireFree(const ParamPath& path) const {
  if (!sources_.section) param_tree::RequireNotSession(path);
}

// A program that declares nothing reads its parameters without declarations. Environment variables may be meant for
// other programs, so one without a similar parameter is not reported.
void ParamServer::Core::SayUndeclared() {
  std::vector<ParamOverride> unknown;
  std::vector<std::string> declared;
  {
    const std::scoped_lock lock(mutex_);
    unknown.swap(unknown_);
    for (const DeclaredParams::Entry& entry : declared_.entries()) {
      declared.push_back(entry.path.ToString());
    }
  }
  if (declared.empty()) return;
  std::string list;
  for (const ParamOverride& one : unknown) {
    const std::string nearest = NearestName(one.path, declared);
    if (nearest.empty() && one.said.starts_with(kEnvironmentPrefix)) continue;
    list += (list.empty() ? "" : ", ") + one.said;
    if (!nearest.empty()) list += " (did you mean " + nearest + "?)";
  }
  if (!list.empty()) {
    log_.Write(LogLevel::kWarning, "Parameters are set that this program has not declared so far: " + list + ".");
  }
}

ParamNodePtr ParamServer::Core::root() const {
  const std::scoped_lock lock(mutex_);
  return root_;
}

ParamNodePtr ParamServer::Core::Declare(DeclaredParams::Entry entry) {
  RequireFree(entry.path);
  DeclaredParams::RequireRange(entry);
  DeclaredParams::RequireGood(entry, ParamView(entry.fallback, entry.path));
  const std::scoped_lock lock(mutex_);
  std::erase_if(unknown_, [&](const ParamOverride& one) { return ParamPath::Parse(one.path).Overlaps(entry.path); });
  if (const DeclaredParams::Entry* const known = declared_.Find(entry.path)) {
    entry.check(ParamView(root_).At(entry.path));
    if (known->info == entry.info && known->fallback->SameValue(*entry.fallback)) return root_;
    throw ParamError("The parameter " + entry.path.ToString() + " is declared twice with different settings.", {},
                     "Declare it in one place.");
  }
  ParamNodePtr root = root_;
  if (const ParamNodePtr given = param_tree::Find(root, entry.path); given == nullptr) {
    root = param_tree::With(root, entry.path, entry.fallback);
  } else if (IsArgument(*given) && !given->quoted && DeclaredParams::TypeOf(entry) == "text") {
    ParamNode text = ParamNode::Text(given->text, true);
    text.origin = given->origin;
    root = param_tree::With(root, entry.path, std::make_shared<const ParamNode>(std::move(text)));
  }
  DeclaredParams::RequireGood(entry, ParamView(root).At(entry.path));
  declared_.Add(std::move(entry));
  root_ = std::move(root);
  ++version_;
  return root_;
}

std::vector<ParamDeclaration> ParamServer::Core::Declarations() const {
  const std::scoped_lock lock(mutex_);
  std::vector<ParamDeclaration> declarations;
  for (const DeclaredParams::Entry& entry : declared_.entries()) {
    declarations.push_back(
        {entry.path.ToString(), entry.info, DeclaredParams::TypeOf(entry), yaml_writing::Inline(*entry.fallback)});
  }
  return declarations;
}

std::string ParamServer::Core::Ask(const ParamEvent& event) const {
  std::string refusal;
  validators_.Tell({event, refusal});
  return refusal;
}

ParamResult ParamServer::Core::Change(const std::vector<Step>& steps, IfMissing if_missing) {
  ParamResult result = Commit(steps, if_missing);
  TellListeners();
  return result;
}

ParamResult ParamServer::Core::Commit(const std::vector<Step>& steps, IfMissing if_missing) {
  for (;;) {
    std::unique_lock lock(mutex_);
    const ParamNodePtr before = root_;
    const DeclaredParams declared = declared_;
    const std::uint64_t version = version_;
    lock.unlock();

    ParamNodePtr after = before;
    ParamEvent event{ParamView(before), ParamView(before), {}};
    try {
      for (const Step& step : steps) {
        RequireFree(step.path);
        if (if_missing == IfMissing::kRefuse) RequireThere(after, step.path, step.value == nullptr);
        after = param_tree::With(after, step.path, step.value);
      }
      for (const Step& step : steps) after = declared.WithFallbacks(after, step.path);
      event.after = ParamView(after);
      for (param_tree::Difference& difference : param_tree::Differences(before, after)) {
        event.paths.push_back(std::move(difference.path));
      }
      if (!event.paths.empty()) {
        declared.RequireAllowed(event);
        if (!after->entries.empty()) (void)WrittenYaml(after, "parameters");
      }
    } catch (const ParamError& e) {
      return {e.what()};
    } catch (const ConfigError& e) {  // Nobody could read or save them any more.
      return {"All parameters together would be no YAML that can be read: " + std::string(e.what())};
    }
    // If only the source of a value differs, it is stored without calling validators or listeners.
    if (!event.paths.empty()) {
      if (std::string refusal = Ask(event); !refusal.empty()) return {std::move(refusal)};
    }

    lock.lock();
    if (version_ != version) continue;  // Another change came first: try again.
    root_ = after;
    ++version_;
    if (!event.paths.empty()) events_.push_back(std::move(event));
    return {};
  }
}

void ParamServer::Core::TellListeners() {
  std::unique_lock lock(mutex_);
  const auto here = std::this_thread::get_id();
  const std::uint64_t own = told_ + events_.size();
  if (teller_ == here) return;
  if (teller_ != std::thread::id()) {
    // Not for ever: the listener that runs may wait for this thread.
    ++waiting_;
    room_.wait_for(lock, kListenerPatience,
                   [this] { return teller_ == std::thread::id() || events_.size() < kManyEvents; });
    --waiting_;
    if (teller_ != std::thread::id()) return;
  }
  teller_ = here;
  while (!events_.empty() && (told_ < own || waiting_ == 0)) {
    const ParamEvent event = std::move(events_.front());
    events_.pop_front();
    lock.unlock();
    listeners_.Tell(event);
    lock.lock();
    ++told_;
    if (events_.size() < kManyEvents && waiting_ > 0) room_.notify_all();
  }
  teller_ = std::thread::id();
  room_.notify_all();
}

Listening ParamServer::Core::AddValidator(ParamPath path, ParamValidator validator) {
  return validators_.Add([this, path = std::move(path), validator = std::move(validator)](const Question& question) {
    if (!question.refusal.empty() || !question.event.Touches(path)) return;
    try {
      const std::optional<std::string> refusal = validator(question.event);
      if (refusal) question.refusal = refusal->empty() ? "A validator refused without a reason." : *refusal;
    } catch (const std::exception& e) {
      question.refusal = e.what();
    } catch (const ForcedUnwind&) {
      EndAfterForcedUnwind(log_, "A parameter validator");
    } catch (...) {
      question.refusal = "A validator threw something that is not a std::exception.";
    }
  });
}

Listening ParamServer::Core::OnChange(ParamPath path, ParamListener listener) {
  return listeners_.Add([this, path = std::move(path), listener = std::move(listener)](const ParamEvent& event) {
    if (!event.Touches(path)) return;
    try {
      listener(event);
    } catch (const std::exception& e) {
      log_.WriteLimited(LogLevel::kError, "listener", std::string("A parameter listener threw: ") + e.what());
    } catch (const ForcedUnwind&) {
      EndAfterForcedUnwind(log_, "A parameter listener");
    } catch (...) {
      log_.WriteLimited(LogLevel::kError, "listener",
                        "A parameter listener threw something that is not a std::exception.");
    }
  });
}

ParamResult ParamServer::Core::Reload() {
  ParamResult result;
  {
    const std::scoped_lock files(files_mutex_);
    ParamNodePtr now;
    try {
      now = ReadSources();
    } catch (const Error& e) {
      return {e.what()};
    }
    std::vector<Step> steps;
    for (param_tree::Difference& difference : param_tree::Differences(loaded_, now)) {
      steps.push_back({std::move(difference.path), std::move(difference.after)});
    }
    if (!steps.empty()) result = Commit(steps, IfMissing::kCreate);
    if (result.ok()) loaded_ = std::move(now);
  }
  TellListeners();
  return result;
}

}  // namespace hgros
