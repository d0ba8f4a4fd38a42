#pragma once

#include <string>

#include "hgros/base/export.hpp"

namespace hgros {

/// A CurveZMQ key pair (https://rfc.zeromq.org/spec/26/), each key as 40 characters of Z85.
struct CurveKeyPair {
  std::string public_key;
  std::string secret_key;
};

/// A new key pair. The public key can be written into a robot file: it has no "${". Errors: throws Error if ZeroMQ was
/// built without CURVE.
[[nodiscard]] HGROS_EXPORT CurveKeyPair GenerateCurveKeyPair();
/// The public key that belongs to a secret key. Errors: throws Error if that is not a key, or without CURVE.
[[nodiscard]] HGROS_EXPORT std::string PublicCurveKeyOf(const std::string& secret_key);

}  // namespace hgros
