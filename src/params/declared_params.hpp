#pragma once

#include <functional>
#include <string>
#include <vector>

#include "hgros/params/param_server.hpp"

namespace hgros {

// What has been declared, and what that forbids.
//
// Thread safety: none.
class DeclaredParams {
 public:
  struct Entry {
    ParamPath path;
    ParamNodePtr fallback;
    ParamInfo info;
    std::function<void(const ParamView&)> check;  // throws ParamError
  };

  // Null if there is none.
  [[nodiscard]] const Entry* Find(const ParamPath& path) const;
  void Add(Entry entry) { entries_.push_back(std::move(entry)); }
  [[nodiscard]] const std::vector<Entry>& entries() const noexcept { return entries_; }

  // What is removed of a declared parameter is its fallback again.
  [[nodiscard]] ParamNodePtr WithFallbacks(ParamNodePtr root) const;
  // Throws ParamError for a value that cannot be.
  static void RequireGood(const Entry& entry, const ParamView& value);
  // Throws ParamError if `event` is not allowed.
  void RequireAllowed(const ParamEvent& event) const;

 private:
  std::vector<Entry> entries_;
};

}  // namespace hgros
