#pragma once

#include <string>

namespace hgros::test {

/// The path with this name in PATHS of hgros_test, for example of a program that the test starts; empty if it is not
/// built.
std::string Path(const std::string& name);

}  // namespace hgros::test
