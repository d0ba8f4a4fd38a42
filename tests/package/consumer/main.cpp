// A program that is built against the installed package alone. It uses the library, its errors and its messages.
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
    std::puts("The message did not come back.");
    return 1;
  }
  try {
    hgros::RequireChannelName("two words");
  } catch (const hgros::Error& error) {  // crosses the library's border: its type information is shown
    std::printf("As it should be: %s\n", error.what());
    return 0;
  }
  std::puts("The library accepted a bad channel name.");
  return 1;
}
