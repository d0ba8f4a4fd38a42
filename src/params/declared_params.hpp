#pragma once

#include <functional>
#include <string>
#include <vector>

#include "hgros/params/param_server.hpp"

namespace hgros {

// The declared parameters, and the checks that follow from their declarations.
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

  // Of the default: "number", "text" and so on.
  [[nodiscard]] static std::string TypeOf(const Entry& entry);
  // Null if there is none.
  [[nodiscard]] const Entry* Find(const ParamPath& path) const;
  void Add(Entry entry) { entries_.push_back(std::move(entry)); }
  [[nodiscard]] const std::vector<Entry>& entries() const noexcept { return entries_; }

  // Sets every declared parameter that `root` lacks since `changed` was set to its default.
  [[nodiscard]] ParamNodePtr WithFallbacks(ParamNodePtr root, const ParamPath& changed) const;
  // Throws ParamError if no value can be within the bounds.
  static void RequireRange(const Entry& entry);
  // Throws ParamError if the value has the wrong type or is out of bounds.
  static void RequireGood(const Entry& entry, const ParamView& value);
  // Throws ParamError if `event` is not allowed.
  void RequireAllowed(const ParamEvent& event) const;

 private:
  std::vector<Entry> entries_;
};

}  // namespace hgros
