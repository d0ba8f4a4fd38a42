// Each of these does what a constructor must not do.
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>

#include <hgros/component/component.hpp>

namespace {

struct Crashes {
  explicit Crashes(hgros::Context&) { (void)std::raise(SIGSEGV); }
};
HGROS_COMPONENT(Crashes, "bad/Crashes")

struct Exits {
  explicit Exits(hgros::Context&) { std::exit(3); }
};
HGROS_COMPONENT(Exits, "bad/Exits")

struct Forks {
  explicit Forks(hgros::Context&) {
    const pid_t child = fork();
    while (child == 0) (void)pause();
    (void)std::fprintf(stderr, "left %d\n", child);
    std::abort();
  }
};
HGROS_COMPONENT(Forks, "bad/Forks")

struct Throws {
  explicit Throws(hgros::Context&) { throw std::runtime_error("there is no \x1b[31mcamera"); }
};
HGROS_COMPONENT(Throws, "bad/Throws")

struct Prints {
  explicit Prints(hgros::Context&) { std::puts("I print."); }
};
HGROS_COMPONENT(Prints, "bad/Prints")

}  // namespace
