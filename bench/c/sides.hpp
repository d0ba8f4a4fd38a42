#pragma once

#include <memory>
#include <string>

#include "support/pair.hpp"

namespace hgros::bench {

/// The same in C and in C++: raw bytes of a named type, copied when published, or lent from 256 KB up; the receiver has
/// an inline callback. `domain` is where the two sessions find each other.
std::unique_ptr<PairSender> MakeCSender(const std::string& domain);
std::unique_ptr<PairReceiver> MakeCReceiver(const std::string& domain, PairControl& control);
std::unique_ptr<PairSender> MakeCppSender(const std::string& domain);
std::unique_ptr<PairReceiver> MakeCppReceiver(const std::string& domain, PairControl& control);

}  // namespace hgros::bench
