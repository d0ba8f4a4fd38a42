#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include <hgros/Params.pb.h>

#include "hgros/params/param_server.hpp"

namespace hgros {

// The parameters of another session as received: the latest state, and the answers to open questions. If several
// sessions offer them under one name, all answer, and the first answer counts, with the state of the session that gave
// it.
//
// Thread safety: all functions.
class RemoteMirror {
 public:
  struct State {
    ParamNodePtr root;
    std::vector<ParamDeclaration> declarations;
  };
  struct Outcome {
    std::optional<State> state;
    std::string refusal;
  };
  using Deadline = std::chrono::steady_clock::time_point;

  // `name`: the session's name, for error texts.
  explicit RemoteMirror(std::string name);

  void OnState(const ParamsState& state);
  void OnAnswer(const ParamsAnswer& answer);

  // A new question. From here on its answer is kept, until Forget().
  [[nodiscard]] ParamsQuestion NextQuestion();
  // Waits for the answer. False if there is none at `until`. True also after EndWaits().
  [[nodiscard]] bool AwaitAnswer(const ParamsQuestion& question, Deadline until);
  // Waits for the answer and for the state that belongs to it. Empty if they are not there at `until`.
  [[nodiscard]] std::optional<Outcome> Wait(const ParamsQuestion& question, Deadline until);
  // Why the wait was in vain.
  [[nodiscard]] Outcome Late(const ParamsQuestion& question) const;
  void Forget(const ParamsQuestion& question);
  // All waits end, also later ones.
  void EndWaits() noexcept;
  [[nodiscard]] bool ended() const;
  [[nodiscard]] Outcome Ended() const;  // Of a wait.

 private:
  // The latest state of one server.
  struct Held {
    std::uint64_t life = 0;
    std::uint64_t version = 0;
    State state;
    std::string fault;  // Why there is no state: it cannot be read, or the session no longer offers it.
  };
  // Under mutex_. Null if there is none.
  [[nodiscard]] Held* Find(std::uint64_t life);

  const std::string name_;
  const std::uint64_t asker_;

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::uint64_t last_number_ = 0;  // guarded by mutex_, as all below
  std::map<std::uint64_t, std::optional<ParamsAnswer>> answers_;
  std::vector<Held> held_;  // Of the last few servers.
  bool ended_ = false;
};

}  // namespace hgros
