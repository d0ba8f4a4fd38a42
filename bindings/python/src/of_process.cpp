#include "of_process.hpp"

#include <pthread.h>

#include "hgros/base/error.hpp"
#include "wire.hpp"

namespace hgros::python {

void OfProcess::ThrowOfParent() {
  throw Error("It belongs to the session of another process, from which this one was forked.", {},
              "Make a session after the fork, and use that.");
}

void CountForks() {
  pthread_atfork(nullptr, nullptr, [] {
    ++forks;
    leases.count = 0;  // Those of the parent.
    leases.bytes = 0;
  });
}

}  // namespace hgros::python
