// A server in its own process: `service_worker YAML`. Writes to standard output its endpoints ("at ENDPOINT"), "ready"
// when it serves, and "begun" when it has begun a request that it never finishes. Ends with its parent.
#include <sys/prctl.h>

#include <csignal>
#include <cstdio>
#include <string>

#include "services/services_fixture.hpp"

int main(int, char** arguments) {
  using hgros::test::Sum;
  using hgros::test::Total;
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  const auto say = [](const std::string& what) {
    std::printf("%s\n", what.c_str());
    std::fflush(stdout);
  };
  hgros::Session session(hgros::Config::Parse(arguments[1]), {"server", [](hgros::LogLevel, std::string_view) {}});
  for (const std::string& endpoint : session.PublisherEndpoints()) say("at " + endpoint);
  hgros::test::Door never;
  const hgros::Service add = session.Serve<Sum, Total>("add", hgros::test::Add);
  const hgros::Service stuck = session.Serve<Sum, Total>("stuck", [&](const Sum& sum) {
    say("begun");
    for (;;) never.Pass();
    return hgros::test::Add(sum);
  });
  say("ready");
  for (;;) never.Pass();
}
