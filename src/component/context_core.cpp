#include "component/context_core.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "hgros/base/error.hpp"
#include "hgros/base/names.hpp"
#include "hgros/session/session_parts.hpp"
#include "hgros/session/type_gate.hpp"

namespace hgros {
namespace {

std::string Quoted(std::string_view text) { return "\"" + std::string(text) + "\""; }

// "There is the nearest one", or all of them if they are few.
std::string Offer(const std::string& name, const std::set<std::string>& known, std::string_view noun) {
  if (known.empty()) return "It has no " + std::string(noun) + ".";
  const std::vector<std::string> candidates(known.begin(), known.end());
  if (const std::string nearest = NearestName(name, candidates); !nearest.empty()) {
    return "Did you mean " + Quoted(nearest) + "?";
  }
  std::string list = "It has:";
  for (const std::string& one : candidates) list += (one == candidates.front() ? " " : ", ") + one;
  return list + ".";
}

// The paths of all values below `view`; a map without values has none.
void AddLeaves(const ParamView& view, std::vector<std::string>& paths) {
  if (!view.exists()) return;
  if (view.node()->kind != ParamNode::Kind::kMap) {
    paths.push_back(view.path().ToString());
    return;
  }
  for (const std::string& key : view.keys()) AddLeaves(view[key], paths);
}

bool IsAtOrBelow(std::string_view path, std::string_view above) {
  return path.starts_with(above) &&
         (path.size() == above.size() || path[above.size()] == '.' || path[above.size()] == '[');
}

}  // namespace

// A component's parameters may have any name, also that of a section of the session.
ParamSources ContextCore::SourcesOf(const ComponentSetup& setup) {
  ParamSources sources = setup.params;
  if (!sources.section) sources.section = std::make_shared<const ParamNode>(ParamNode::Map({}));
  return sources;
}

ContextCore::ContextCore(Means means, const ComponentType& type, ComponentSetup setup)
    : means_(std::move(means)),
      setup_(std::move(setup)),
      params_(std::in_place, SourcesOf(setup_), Sink()),
      log_(Sink()),
      guard_(std::make_shared<ComponentGuard>(
          type.state != nullptr, setup_.deadline, [this](const std::string& what) { NoteException(what); },
          [this](const std::string& sentence) { NoteLate(sentence); })),
      transforms_(means_.transforms),
      context_(*this) {
  status_.name = description_.name = setup_.name;
  description_.type = setup_.type;
  if (type.state == nullptr) return;
  description_.state = type.state->name;
  description_.fingerprints[type.state->name] = type.state->fingerprint;
}

LogSink ContextCore::Sink() const {
  if (means_.options.log) {
    return [name = setup_.name, log = means_.options.log](LogLevel level, std::string_view text) {
      log(name, level, text);
    };
  }
  return [name = setup_.name, &log = means_.session.log()](LogLevel level, std::string_view text) {
    log.Write(level, name + ": " + std::string(text));
  };
}

std::string ContextCore::NameHere(std::string_view name) {
  std::string here(name);
  const std::scoped_lock lock(mutex_);
  if (!constructed_) names_.insert(here);
  const auto found = setup_.remap.find(here);
  return found == setup_.remap.end() ? here : found->second;
}

std::string ContextCore::AddOutput(std::string_view channel, const std::string& type, std::uint64_t fingerprint) {
  std::string here = NameHere(channel);
  const std::scoped_lock lock(mutex_);
  if (constructed_) return here;
  description_.outputs.push_back({std::string(channel), here, type, {}});
  description_.fingerprints[type] = fingerprint;
  return here;
}

std::string ContextCore::AddCalled(std::string_view service, const TypeInfo& request, const TypeInfo& reply) {
  std::string here = NameHere(service);
  const std::scoped_lock lock(mutex_);
  if (constructed_) return here;
  description_.calls.push_back({std::string(service), here, request.name, reply.name});
  description_.fingerprints[request.name] = request.fingerprint;
  description_.fingerprints[reply.name] = reply.fingerprint;
  return here;
}

NodeOverride ContextCore::SetUpNode(std::string_view channel, std::string& name) {
  const std::string wanted = name.empty() ? std::string(channel) : name;
  std::string own = wanted;
  {
    const std::scoped_lock lock(mutex_);
    for (int i = 2; !nodes_.insert(own).second; ++i) own = wanted + "#" + std::to_string(i);
  }
  name = setup_.name + "/" + own;
  const auto found = setup_.nodes.find(own);
  NodeOverride set = found == setup_.nodes.end() ? NodeOverride{} : found->second;
  if (means_.options.all_inline) set.executor = Executor::Inline();
  return set;
}

void ContextCore::SetUp(std::string_view channel, NodeOptions& options) {
  const NodeOverride set = SetUpNode(channel, options.name);
  options.queue = set.queue.value_or(options.queue);
  options.executor = set.executor.value_or(options.executor);
  if (options.executor.kind() == Executor::Kind::kPolled) {
    throw Error("Node \"" + options.name + "\" of a component cannot be polled.", {}, "Choose another executor.");
  }
}

void ContextCore::AddInput(const ComponentInput& input, AnyCallback callback, NodeOptions options) {
  const std::string here = NameHere(input.channel);
  SetUp(input.channel, options);
  {
    const std::scoped_lock lock(mutex_);
    if (!constructed_) {
      const std::string type = input.type.any ? std::string() : input.type.name;
      description_.inputs.push_back({std::string(input.channel), here, type, options.name});
      if (!input.type.any) description_.fingerprints[input.type.name] = input.type.fingerprint;
    }
  }
  AnyCallback guarded;
  std::shared_ptr<InputGate> gate;
  if (!guard_->counts()) {  // The usual case, with the least code in the way of a message.
    guarded = [guard = guard_, callback = std::move(callback)](const AnyMessage& message, const MessageInfo& info) {
      guard->Note([&] { callback(message, info); });
    };
  } else if (description_.state.empty()) {
    guarded = [guard = guard_, node = options.name, call = std::move(callback)](const auto& message, const auto& info) {
      guard->Run(node, [&] { call(message, info); });
    };
  } else {
    const auto asked = gates_.Ask({options.name, here, &input.type, input.invoke, options.queue, options.executor},
                                  std::move(callback), guard_);
    if (asked.ends) EndInput(*asked.ends);
    if (!asked.fresh) return;
    gate = asked.fresh;
    guarded = [gate](const AnyMessage& message, const MessageInfo& info) { gate->Take(message, info); };
  }
  // Before the gate, so that a move hands over none of another type.
  if (IsRunTimeType(input.type)) guarded = OnlyOf(input.type, std::move(guarded));
  const std::string node = options.name;
  Add(inputs_, {node,
                [this, here, &type = input.type, invoke = input.invoke, where = input.where,
                 callback = std::move(guarded), options = std::move(options), gate = std::move(gate)]() -> Kept {
                  auto made = std::make_shared<Subscription>(
                      SessionParts(session()).Subscribe(here, type, invoke, callback, options, where));
                  if (gate) gate->Join(*made);
                  return made;
                }});
}

void ContextCore::AddService(const ServedByComponent& served, AnyHandler handler, NodeOptions options) {
  const std::string here = NameHere(served.service);
  SetUp(served.service, options);
  {
    const std::scoped_lock lock(mutex_);
    if (!constructed_) {
      description_.services.push_back(
          {std::string(served.service), here, served.request_body.name, served.reply_body.name});
      for (const TypeInfo* one : {&served.request_body, &served.reply_body}) {
        description_.fingerprints[one->name] = one->fingerprint;
      }
    }
  }
  AnyHandler guarded = [this, node = options.name, handler = std::move(handler)](const AnyMessage& request) {
    while (true) {
      if (place_ != Place::kHere) AwaitHere();
      AnyMessage reply;
      bool handled = false;
      guard_->Run(node, [&] {
        handled = place_ == Place::kHere;
        if (handled) reply = handler(request);
      });
      if (handled) return reply;
    }
  };
  const SessionParts::ServiceTypes types{served.request, served.reply, served.request_body, served.reply_body};
  const std::string node = options.name;
  Add(services_,
      {node,
       [this, here, types, invoke = served.invoke, where = served.where, guarded = std::move(guarded),
        options = std::move(options)]() -> Kept {
         return std::make_shared<Service>(SessionParts(session()).Serve(here, types, guarded, invoke, options, where));
       }});
}

void ContextCore::AddTimer(std::string_view timer, Duration period, TimerCallback callback, NodeTimerOptions options) {
  std::string name(timer);
  const NodeOverride set = SetUpNode(timer, name);
  if (set.queue) options.queue = set.queue;
  options.executor = set.executor.value_or(options.executor);
  {
    const std::scoped_lock lock(mutex_);
    if (!constructed_) description_.timers.push_back({std::string(timer), period});
  }
  Add(timers_, {name, [this, name, period, options, callback = std::move(callback)]() -> Kept {
                  const auto guarded = [this, name, callback](const Tick& tick) {
                    guard_->Run(name, [&] {
                      if (place_ == Place::kHere) callback(tick);
                    });
                  };
                  return std::make_shared<NodeTimer>(session().CreateTimer(name, period, guarded, options));
                }});
}

// Outside the lock: an inline subscription may run its callback at once, for latched messages. What is made while the
// stage ends is ended by End(), which waits for it.
void ContextCore::Add(Stage& stage, Wire wire) {
  {
    const std::scoped_lock lock(mutex_);
    if (stage.ended) return;
    if (!stage.begun) {
      stage.waiting.push_back(std::move(wire));
      return;
    }
    ++stage.in_progress;
  }
  const auto end = [&](Kept kept) {
    const std::scoped_lock lock(mutex_);
    if (kept) stage.kept.emplace_back(wire.node, std::move(kept));
    --stage.in_progress;
    wired_.notify_all();
  };
  try {
    end(wire.make());
  } catch (...) {
    end(nullptr);
    throw;
  }
}

void ContextCore::Begin(Stage& stage) {
  std::vector<Wire> waiting;
  {
    const std::scoped_lock lock(mutex_);
    stage.begun = true;
    waiting.swap(stage.waiting);
  }
  try {
    for (const Wire& wire : waiting) Add(stage, wire);
  } catch (...) {
    End(stage);  // Not a part of it.
    throw;
  }
}

void ContextCore::End(Stage& stage) {
  decltype(stage.kept) kept;  // Ends outside the lock, the last one first: it waits for callbacks.
  {
    std::unique_lock lock(mutex_);
    stage.ended = true;
    stage.waiting.clear();
    wired_.wait(lock, [&stage] { return stage.in_progress == 0; });
    kept.swap(stage.kept);
  }
  while (!kept.empty()) kept.pop_back();
}

void ContextCore::Join() {
  JoinInputs();
  JoinServices();
  SetState(ComponentState::kJoined);
}

void ContextCore::JoinInputs() { Begin(inputs_); }
void ContextCore::JoinServices() { Begin(services_); }

void ContextCore::StartTimers() {
  if (status().state < ComponentState::kFinished) Begin(timers_);
}

void ContextCore::EndTimers() { End(timers_); }

void ContextCore::EndInputs() {
  if (place_ == Place::kHeld) SetPlace(Place::kElsewhere);  // Calls that wait do not keep the end waiting.
  for (const auto& gate : gates()) gate->Close();
  End(inputs_);
  EndServices();
}

void ContextCore::EndServices() { End(services_); }

bool ContextCore::NoteFault(std::string_view param, const ParamError& fault) {
  const std::scoped_lock lock(mutex_);
  if (!constructed_) faulty_params_.emplace(param, fault);
  return !constructed_;
}

std::vector<Error> ContextCore::EndConstruction(bool returned) {
  std::set<std::string> names;
  std::set<std::string> nodes;
  std::set<std::string> declared;
  std::vector<Error> faults;
  {
    const std::scoped_lock lock(mutex_);
    constructed_ = true;
    description_.params = params_->Declarations();
    names = names_;
    nodes = nodes_;
    for (const auto& [param, fault] : faulty_params_) {
      declared.insert(param);
      faults.push_back(fault);
    }
    if (status_.state == ComponentState::kFailed) faults.emplace_back(status_.sentence);
  }
  if (!returned) return faults;  // Otherwise its names are not all known.
  for (const auto& [from, to] : setup_.remap) {
    if (names.contains(from)) continue;
    faults.emplace_back(
        "remap names the channel or service " + Quoted(from) + ", which " + setup_.type + " does not use.", "",
        Offer(from, names, "channels and services"));
  }
  for (const auto& [node, override] : setup_.nodes) {
    if (nodes.contains(node)) continue;
    faults.emplace_back("nodes names " + Quoted(node) + ", which is no node of " + setup_.type + ".", "",
                        Offer(node, nodes, "nodes"));
  }
  for (const ParamDeclaration& one : description_.params) declared.insert(one.path);
  std::vector<std::string> set;
  AddLeaves(params_->Snapshot(), set);
  for (const std::string& path : set) {
    if (std::ranges::any_of(declared, [&](const std::string& one) { return IsAtOrBelow(path, one); })) continue;
    const ParamView view = params_->Snapshot().At(path);
    faults.emplace_back(setup_.type + " has no parameter " + Quoted(path) + ".", view.node()->origin.ToString(),
                        Offer(path, declared, "parameters"));
  }
  if (means_.options.on_params) {
    changes_ = params_->OnChange({}, [this](const ParamEvent& event) { means_.options.on_params(setup_.name, event); });
  }
  return faults;
}

}  // namespace hgros
