#pragma once

#include <string>
#include <string_view>

namespace hgros::test {

/// A frame of ZMTP 3 (https://rfc.zeromq.org/spec/23).
inline std::string Frame(std::string_view body, bool more = false) {
  std::string frame;
  if (body.size() < 256) {
    frame += static_cast<char>(more ? 1 : 0);
    frame += static_cast<char>(body.size());
  } else {
    frame += static_cast<char>(more ? 3 : 2);
    for (int shift = 56; shift >= 0; shift -= 8) frame += static_cast<char>(body.size() >> shift & 0xff);
  }
  return frame.append(body);
}

/// The greeting without keys and the READY command of a socket type with four letters.
inline std::string Greeting(std::string_view socket_type) {
  std::string greeting("\xff\0\0\0\0\0\0\0\1\x7f\3\0NULL", 16);
  greeting.resize(64);
  return (greeting + std::string("\4\x1a\5READY\13Socket-Type\0\0\0\4", 24)).append(socket_type);
}

}  // namespace hgros::test
