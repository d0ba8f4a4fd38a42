#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "hgros/params/remote_params.hpp"
#include "robot/robot.hpp"
#include "terminal/records.hpp"

namespace hgros::cli {

/// The names under which other sessions offer parameters, sorted.
[[nodiscard]] std::vector<std::string> ParamSessions(const Robot& robot);
/// The only one, for a command line without a session. Throws Error if there is none or there are several.
[[nodiscard]] std::string OnlyParamSession(const Robot& robot);

/// If several sessions offer parameters under the name of this channel: a sentence that names them. Otherwise empty.
[[nodiscard]] std::string OfferedTwice(const KnownChannel& channel);
/// What to do about that.
inline constexpr std::string_view kRenameSession = "Rename one, or give each robot its own HGROS_DOMAIN.";

/// No answer, or a refusal; what() is the sentence of the library.
class ParamRefusal : public Error {
 public:
  using Error::Error;
};

/// The parameters that a session offers. Failures are thrown as ParamRefusal, or as TimedOut if there is a --timeout.
class OfferedParams {
 public:
  /// Waits a second for the session, or --timeout. Throws with the nearest name if it does not come. Says so if several
  /// offer parameters under the name.
  OfferedParams(Robot& robot, const RobotOptions& options, std::string name);

  [[nodiscard]] const std::string& name() const noexcept { return name_; }
  [[nodiscard]] ParamView Snapshot();
  /// The part at `path`. Throws ParamRefusal with the nearest path if it is not there.
  [[nodiscard]] ParamView At(const std::string& path);
  [[nodiscard]] std::vector<ParamDeclaration> Declarations(const std::string& path);
  /// Throws ParamRefusal, and changes nothing, if several sessions offer parameters under the name.
  void Change(const std::vector<ParamChange>& changes, IfMissing if_missing);
  [[nodiscard]] Subscription Watch(const std::string& path, ParamListener listener);

 private:
  template <class Ask>
  auto Asked(const Ask& ask);
  [[nodiscard]] std::string Twice() const;

  Robot& robot_;
  const RobotOptions& options_;
  const std::string name_;
  std::unique_ptr<RemoteParams> params_;  // With --timeout one for each question: it has the time that is left.
};

/// The part of `all` at `path`. Throws ParamRefusal with the nearest path, and `mend`, if it is not there.
[[nodiscard]] ParamView Existing(const ParamView& all, const std::string& path, const std::string& mend);

/// The paths of all values at and below `view` that are not maps, with these values.
[[nodiscard]] std::vector<std::pair<std::string, ParamNodePtr>> ValuesOf(const ParamView& view);

/// A value in one line; JSON has the value itself. Null: there is none. `most_characters`: the rest is left out.
[[nodiscard]] Cell CellOf(const ParamNodePtr& value, std::size_t most_characters = std::size_t(-1));

/// Writes all parameters of these sessions. Says which session does not answer. Returns an ExitCode.
int WriteParams(Robot& robot, const RobotOptions& options, const std::vector<std::string>& sessions);

}  // namespace hgros::cli
