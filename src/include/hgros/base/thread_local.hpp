#pragma once

/// A thread_local of the library. It is reached without a call, from a few bytes that the loader keeps for libraries
/// that are loaded late. A compiler's option for all thread-locals would do the same to those of the C++ library, which
/// cannot be moved there if a program has used it before: then this library could not be loaded.
#define HGROS_THREAD_LOCAL thread_local __attribute__((tls_model("initial-exec")))
