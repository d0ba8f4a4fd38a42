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

// What has been heard of the parameters of another session: the latest state, and the answers that are waited for.
//
// Thread safety: all of it.
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

  // `name`: of the session, for sentences.
  explicit RemoteMirror(std::string name);

  void OnState(const ParamsState& state);
  void OnAnswer(const ParamsAnswer& answer);

  // The question that comes next; it is waited for from here on.
  [[nodiscard]] ParamsQuestion NextQuestion();
  // Waits for its answer; false if there is none until then.
  [[nodiscard]] bool AwaitAnswer(const ParamsQuestion& question, Deadline until);
  // Waits for its answer, and for the state that goes with it.
  [[nodiscard]] Outcome Wait(const ParamsQuestion& question, Deadline deadline);
  void Forget(const ParamsQuestion& question);

 private:
  const std::string name_;
  const std::uint64_t asker_;

  std::mutex mutex_;
  std::condition_variable changed_;
  std::uint64_t last_number_ = 0;  // guarded by mutex_, as all below
  std::map<std::uint64_t, std::optional<ParamsAnswer>> answers_;
  std::uint64_t life_ = 0;
  std::uint64_t version_ = 0;
  State state_;
  std::string fault_;  // Why the state cannot be read.
};

}  // namespace hgros
