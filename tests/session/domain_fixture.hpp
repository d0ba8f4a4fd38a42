#pragma once

#include <cstdlib>

#include "session/session_fixture.hpp"

namespace hgros::test {

/// Gives each test its own domain through the environment, so that its sessions find only each other.
class DomainFixture : public testing::Test {
 protected:
  DomainFixture() { Enter("test-" + SessionId::Random().ToString()); }
  ~DomainFixture() override { Enter("none"); }
  static void Enter(const std::string& domain) { setenv("HGROS_DOMAIN", domain.c_str(), 1); }
};

/// The parameter names the transport.
inline std::string TransportName(const testing::TestParamInfo<std::string>& info) { return info.param; }

}  // namespace hgros::test
