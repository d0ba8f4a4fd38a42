#pragma once

#include <string>
#include <tuple>
#include <type_traits>

namespace slam2d {

/// Whether a value may change while it is in use.
enum class When {
  kAnyTime,  ///< From one scan to the next.
  kAtStart,  ///< Never: the map drawn so far depends on it.
};

/// One number of an options struct, with its description for users.
template <class Options, class Value>
struct Tunable {
  const char* name;
  Value Options::*member;
  const char* description;
  const char* unit;  ///< Empty: a plain number.
  double least;      ///< Both bounds are included.
  double most;
  When when = When::kAnyTime;
};
template <class Options, class Value>
Tunable(const char*, Value Options::*, const char*, const char*, double, double) -> Tunable<Options, Value>;
template <class Options, class Value>
Tunable(const char*, Value Options::*, const char*, const char*, double, double, When) -> Tunable<Options, Value>;

/// An options struct within another one.
template <class Options, class Value>
struct TunableGroup {
  const char* name;
  Value Options::*member;
};
template <class Options, class Value>
TunableGroup(const char*, Value Options::*) -> TunableGroup<Options, Value>;

/// Specialized for each options struct: `static constexpr std::tuple kAll{Tunable{...}, ...}`.
template <class Options>
struct Tunables;

/// Calls `visit(path, tunable, value)` for all numbers in `options`, groups included. Their paths begin with `prefix`,
/// if there is one.
template <class Options, class Visit>
void ForEachTunable(const std::string& prefix, Options& options, const Visit& visit) {
  const auto go = [&](const auto& one) {
    const std::string path = prefix.empty() ? one.name : prefix + "." + one.name;
    if constexpr (requires { one.unit; }) {
      visit(path, one, options.*one.member);
    } else {
      ForEachTunable(path, options.*one.member, visit);
    }
  };
  std::apply([&](const auto&... each) { (go(each), ...); }, Tunables<std::remove_const_t<Options>>::kAll);
}

}  // namespace slam2d
