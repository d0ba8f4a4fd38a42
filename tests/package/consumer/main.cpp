// A program that uses only the installed package: the library, its errors and its messages.
#include <cstdio>
#include <string>

#include <foxglove/Log.pb.h>
#include <hgros/base/error.hpp>
#include <hgros/base/names.hpp>

int main() {
  foxglove::Log sent;
  sent.set_message("hello");
  foxglove::Log received;
  if (!received.ParseFromString(sent.SerializeAsString()) || received.message() != "hello") {
    std::puts("The parsed message differs from the original.");
    return 1;
  }
  try {
    hgros::RequireChannelName("two words");
  } catch (const hgros::Error& error) {  // thrown inside the library, so its type information must be exported
    std::printf("Expected error: %s\n", error.what());
    return 0;
  }
  std::puts("The library accepted a bad channel name.");
  return 1;
}
