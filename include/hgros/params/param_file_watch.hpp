#pragma once

#include <functional>
#include <memory>

#include "hgros/base/export.hpp"
#include "hgros/params/param_server.hpp"

namespace hgros {

/// Reloads the parameters when one of their files changes on disk, as long as this object lives; also at the start if a
/// file has changed since it was read. A file changes, too, when a link or a folder on the way to it is replaced in a
/// folder that this process may read.
///
/// Threading: a thread of its own, which sleeps in between. Listeners and `done` run on it; at the start they run on
/// the thread that creates the watch.
/// Lifetime:  ends before its server. The destructor waits for a running reload and must not be called by one.
/// Errors:    throws Error if the folders of the files cannot be watched. If a file cannot be used the old values stay;
/// `done` gets the reason, or the log if there is no `done`. If `done` throws, that is logged and the watch continues.
class HGROS_EXPORT ParamFileWatch {
 public:
  using Done = std::function<void(const ParamResult& result)>;

  explicit ParamFileWatch(ParamServer& server, Done done = nullptr, LogSink log = DefaultLogSink());
  ParamFileWatch(const ParamFileWatch&) = delete;
  ParamFileWatch& operator=(const ParamFileWatch&) = delete;
  ~ParamFileWatch();

 private:
  class Core;
  std::unique_ptr<Core> core_;
};

}  // namespace hgros
