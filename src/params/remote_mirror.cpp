#include "params/remote_mirror.hpp"

#include <algorithm>
#include <utility>

#include "hgros/base/error.hpp"
#include "hgros/base/ids.hpp"
#include "params/param_wire.hpp"

namespace hgros {
namespace {

constexpr std::size_t kMostServers = 16;

}  // namespace

RemoteMirror::RemoteMirror(std::string name) : name_(std::move(name)), asker_(RandomId()) {}

void RemoteMirror::OnState(const ParamsState& state) {
  State read;
  std::string fault;
  if (state.ended()) {
    fault = "The session \"" + name_ + "\" no longer offers its parameters.";
  } else {
    try {
      read.root = param_wire::ReadValues(state, "parameters of " + name_);
      read.declarations = param_wire::ReadDeclarations(state);
    } catch (const Error& e) {
      fault = "The parameters of \"" + name_ + "\" cannot be read: " + std::string(e.what());
    }
  }
  {
    const std::scoped_lock lock(mutex_);
    Held* held = Find(state.life());
    if (held != nullptr && state.version() <= held->version) return;
    if (held == nullptr) {
      if (held_.size() == kMostServers) {
        const auto ended = std::ranges::find_if(held_, [](const Held& one) { return !one.fault.empty(); });
        held_.erase(ended == held_.end() ? held_.begin() : ended);
      }
      held = &held_.emplace_back();
    }
    *held = {state.life(), state.version(), std::move(read), std::move(fault)};
  }
  changed_.notify_all();
}

RemoteMirror::Held* RemoteMirror::Find(std::uint64_t life) {
  const auto held = std::ranges::find(held_, life, &Held::life);
  return held == held_.end() ? nullptr : &*held;
}

void RemoteMirror::OnAnswer(const ParamsAnswer& answer) {
  if (answer.asker() != asker_) return;
  {
    const std::scoped_lock lock(mutex_);
    const auto waiting = answers_.find(answer.number());
    if (waiting == answers_.end() || waiting->second) return;
    waiting->second = answer;
  }
  changed_.notify_all();
}

ParamsQuestion RemoteMirror::NextQuestion() {
  const std::scoped_lock lock(mutex_);
  ParamsQuestion question;
  question.set_asker(asker_);
  question.set_number(++last_number_);
  answers_.emplace(last_number_, std::nullopt);
  return question;
}

bool RemoteMirror::AwaitAnswer(const ParamsQuestion& question, Deadline until) {
  std::unique_lock lock(mutex_);
  const auto waiting = answers_.find(question.number());
  return changed_.wait_until(lock, until, [&] { return ended_ || waiting->second.has_value(); });
}

std::optional<RemoteMirror::Outcome> RemoteMirror::Wait(const ParamsQuestion& question, Deadline until) {
  std::unique_lock lock(mutex_);
  const auto waiting = answers_.find(question.number());
  const auto refused = [&] { return waiting->second && !waiting->second->refusal().empty(); };
  const auto told = [&]() -> const Held* {
    const Held* held = waiting->second ? Find(waiting->second->life()) : nullptr;
    return held != nullptr && held->version >= waiting->second->version() ? held : nullptr;
  };
  if (!changed_.wait_until(lock, until, [&] { return ended_ || refused() || told() != nullptr; })) return std::nullopt;
  if (refused()) return Outcome{{}, waiting->second->refusal()};
  const Held* const held = told();
  if (held == nullptr) return Ended();
  if (!held->fault.empty()) return Outcome{{}, held->fault};
  return Outcome{held->state, {}};
}

RemoteMirror::Outcome RemoteMirror::Late(const ParamsQuestion& question) const {
  const std::scoped_lock lock(mutex_);
  if (answers_.at(question.number())) {
    return {{}, "The session \"" + name_ + "\" answered, but its parameters did not arrive in time."};
  }
  return {{}, "The session \"" + name_ + "\" did not answer in time, but it may still do so."};
}

void RemoteMirror::EndWaits() noexcept {
  {
    const std::scoped_lock lock(mutex_);
    ended_ = true;
  }
  changed_.notify_all();
}

bool RemoteMirror::ended() const {
  const std::scoped_lock lock(mutex_);
  return ended_;
}

RemoteMirror::Outcome RemoteMirror::Ended() const {
  return {{}, "The wait for the session \"" + name_ + "\" was ended."};
}

void RemoteMirror::Forget(const ParamsQuestion& question) {
  const std::scoped_lock lock(mutex_);
  answers_.erase(question.number());
}

}  // namespace hgros
