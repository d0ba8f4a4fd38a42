#pragma once

#include <string>

#include "hgros/base/error.hpp"

namespace hgros::test {

/// The text of the `Error` that `action` throws; empty if it throws none. Other exceptions pass.
template <class Action>
std::string ErrorOf(const Action& action) {
  try {
    (void)action();
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

}  // namespace hgros::test
