#pragma once

#include <cstdlib>
#include <string>

#include "session/session_fixture.hpp"

namespace hgros::test {

/// A domain of its own for each test, as the environment says it: sessions find each other, and nobody else.
class DomainFixture : public testing::Test {
 protected:
  DomainFixture() { Enter("test-" + SessionId::Random().ToString()); }
  ~DomainFixture() override { Enter("none"); }
  static void Enter(const std::string& domain) { setenv("HGROS_DOMAIN", domain.c_str(), 1); }
};

}  // namespace hgros::test
