#pragma once

#include <memory>
#include <string>

#include "hgros/base/export.hpp"
#include "hgros/params/param_server.hpp"
#include "hgros/session/session.hpp"

namespace hgros {

/// Offers parameters to all sessions that reach this one, to be read, watched and set by RemoteParams under this
/// session's name; on the channels params/NAME/ask, /answer and /state.
///
/// Threading: a thread of its own makes the changes that others ask for; validators and listeners run on it.
/// Lifetime: ends before its session and its server. The destructor waits for a change that is under way.
/// Errors: throws Error if the name cannot be part of a channel's name. Another session that offers parameters under
/// the same name is named in the log.
class HGROS_EXPORT ParamService {
 public:
  /// `name`: instead of the session's.
  ParamService(Session& session, ParamServer& server, std::string name = {}, LogSink log = DefaultLogSink());
  ParamService(const ParamService&) = delete;
  ParamService& operator=(const ParamService&) = delete;
  ~ParamService();

 private:
  class Core;
  std::unique_ptr<Core> core_;
};

}  // namespace hgros
