#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "hgros/base/fork_guard.hpp"
#include "hgros/base/log.hpp"
#include "hgros/internal/base/listeners.hpp"
#include "hgros/params/param_server.hpp"
#include "params/declared_params.hpp"
#include "params/param_tree.hpp"

namespace hgros {

// Variables of the environment that set parameters.
inline constexpr std::string_view kEnvironmentPrefix = "HGROS_PARAM_";

// Thread safety: all functions.
// Invariants: root_ and declared_ fit together: every declared parameter exists and is valid. A change is computed and
//   validated without a lock, on its own tree. It takes effect only if nothing else changed meanwhile (version_).
//   An override that nobody declares is reported once, some seconds after the start or at the end.
//   events_ holds events that listeners have not received yet; one thread at a time delivers them, and hands over
//   when its own change was told and others wait.
class ParamServer::Core {
 public:
  Core(ParamSources sources, LogSink log);
  Core(const Core&) = delete;
  Core& operator=(const Core&) = delete;
  ~Core();

  [[nodiscard]] ParamNodePtr root() const;
  ParamNodePtr Declare(DeclaredParams::Entry entry);
  [[nodiscard]] std::vector<ParamDeclaration> Declarations() const;

  struct Step {
    ParamPath path;
    ParamNodePtr value;  // null: removed
  };
  // Commit(), then TellListeners().
  ParamResult Change(const std::vector<Step>& steps, IfMissing if_missing);
  Listening AddValidator(ParamPath path, ParamValidator validator);
  Listening OnChange(ParamPath path, ParamListener listener);

  void Save();
  void SaveAs(const std::filesystem::path& file) const;
  ParamResult Reload();
  [[nodiscard]] const std::vector<std::filesystem::path>& files() const noexcept { return sources_.files; }

  const ForkGuard fork;  // A child does not have the thread.

 private:
  struct Question {
    const ParamEvent& event;
    std::string& refusal;
  };

  // Makes the change. Call TellListeners() afterwards.
  ParamResult Commit(const std::vector<Step>& steps, IfMissing if_missing);
  // Reads the files and applies the overrides. Sets `unknown` to those that are in no file, if it is not null.
  [[nodiscard]] ParamNodePtr ReadSources(std::vector<ParamOverride>* unknown = nullptr) const;
  // Throws ParamError if the path belongs to a session.
  void RequireFree(const ParamPath& path) const;
  // The reason of the first validator that refuses; empty if none does.
  [[nodiscard]] std::string Ask(const ParamEvent& event) const;
  // Waits while very many events wait, unless a listener calls this.
  void TellListeners();
  void SayUndeclared();

  const ParamSources sources_;
  Log log_;
  std::vector<ParamOverride> unknown_;  // The overrides that are in no file, until SayUndeclared(). Guarded by mutex_.
  Listeners<Question> validators_;
  Listeners<ParamEvent> listeners_;

  std::mutex files_mutex_;  // held while files are read again or written, never while listeners run; before mutex_
  ParamNodePtr loaded_;     // guarded by files_mutex_: the result of the last ReadSources()

  mutable std::mutex mutex_;
  ParamNodePtr root_;  // guarded by mutex_, as all below
  DeclaredParams declared_;
  std::uint64_t version_ = 0;  // of root_ and declared_
  std::deque<ParamEvent> events_;
  std::uint64_t told_ = 0;  // Events.
  std::thread::id teller_;  // Of the thread that tells them.
  std::size_t waiting_ = 0;
  std::condition_variable room_;
  std::jthread waits_;  // Waits for declarations, if there are unknown overrides.
};

}  // namespace hgros
