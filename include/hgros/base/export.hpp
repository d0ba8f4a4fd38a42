#pragma once

/// Marks what the shared library shows to programs; everything else stays hidden inside it.
#define HGROS_EXPORT __attribute__((visibility("default")))
