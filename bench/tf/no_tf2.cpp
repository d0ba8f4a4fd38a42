// Compiled instead of tf2.cpp if tf2 is not installed.
#include "sides.hpp"

namespace hgros::bench {

std::unique_ptr<Side> MakeTf2() { return nullptr; }

}  // namespace hgros::bench
