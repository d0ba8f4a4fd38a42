#pragma once

#include <functional>
#include <memory>

#include "hgros/base/export.hpp"
#include "hgros/params/param_server.hpp"

namespace hgros {

/// Reloads the parameters whenever one of their files changes on disk, as long as this object lives.
///
/// Threading: a thread of its own, which sleeps in between; listeners and `done` run on it.
/// Lifetime: ends before its server. The destructor waits for a reload that is under way; it is not called by one.
/// Errors: throws Error if the folders of the files cannot be watched. A file that cannot be used keeps the old values;
/// why
///   is said by `done`, or without it in the log.
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
