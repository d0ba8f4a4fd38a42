// A program with its own messages, which import messages of the library.
#include <shop/order.pb.h>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <string>

#include <hgros/hgros.hpp>

int main() {
  hgros::Session session;
  std::atomic<double> x{0};
  std::atomic<double> raw_x{0};
  const auto typed = session.FromAny<shop::Order>("orders", hgros::Invoke::kSerial,
                                                  [&](const shop::Order& order) { x = order.where().position().x(); });
  const auto raw = session.FromAnyRaw("orders", hgros::Invoke::kSerial, [&](const hgros::RawMessage& message) {
    shop::Order order;
    if (order.ParseFromString(std::string(hgros::AsText(message.data.bytes)))) raw_x = order.where().position().x();
  });
  shop::Order order;
  order.set_what("tea");
  order.mutable_where()->mutable_position()->set_x(3);
  session.ToAny("orders", order);
  session.WaitIdle(std::chrono::seconds(10));
  if (x == 3 && raw_x == 3) return 0;
  std::puts("The order did not arrive.");
  return 1;
}
