#pragma once

#include <functional>
#include <memory>

#include "hgros/base/export.hpp"
#include "hgros/params/param_server.hpp"

namespace hgros {

/// Reloads the parameters whenever one of their files changes on disk, as long as this object lives; and at its
/// beginning, if one has changed since it was read.
///
/// Threading: a thread of its own, which sleeps in between; listeners and `done` run on it, and at the beginning on the
/// one that makes the watch.
/// Lifetime: ends before its server. The destructor waits for a reload that is under way; it is not called by one.
/// Errors: throws Error if the folders of the files cannot be watched. A file that cannot be used keeps the old values;
/// why is said by `done`, or without it in the log. If `done` throws, that is said in the log, and the watch goes on.
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
