#include "params/remote_mirror.hpp"

#include <utility>

#include "hgros/base/error.hpp"
#include "hgros/base/ids.hpp"
#include "params/param_wire.hpp"

namespace hgros {

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
    if (state.life() == life_ && state.version() <= version_) return;
    if (state.ended() && life_ != 0 && state.life() != life_) return;  // Another server has already replaced it.
    life_ = state.life();
    version_ = state.version();
    state_ = std::move(read);
    fault_ = std::move(fault);
  }
  changed_.notify_all();
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
  const auto told = [&] {
    return waiting->second && life_ == waiting->second->life() && version_ >= waiting->second->version();
  };
  if (!changed_.wait_until(lock, until, [&] { return ended_ || refused() || told(); })) return std::nullopt;
  if (refused()) return Outcome{{}, waiting->second->refusal()};
  if (!told()) return Ended();
  if (!fault_.empty()) return Outcome{{}, fault_};
  return Outcome{state_, {}};
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
