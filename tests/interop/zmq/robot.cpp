// A robot for programs that speak plain ZeroMQ: it sends and takes every kind of message.
//
//   robot ENDPOINT
//       prints the endpoint at which it publishes, and subscribes to plain publishers at ENDPOINT. For each line of
//       standard input it publishes one message of each kind. It prints what it has taken, and ends with its input.
#include <array>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <exception>
#include <iostream>
#include <memory>
#include <string>
#include <string_view>

#include <foxglove/Log.pb.h>
#include <foxglove/PointCloud.pb.h>

#include "hgros/clock/derived_clocks.hpp"
#include "hgros/codec/block.hpp"
#include "hgros/codec/bulk.hpp"
#include "hgros/codec/custom_codec.hpp"
#include "hgros/hgros.hpp"
#include "hgros/params/param_service.hpp"
#include "hgros/session/clock_publisher.hpp"

namespace hgros_test {

struct Wheel {
  float speed;
  std::int16_t ticks[4];
};

struct Mark {
  std::string text;
};

}  // namespace hgros_test

template <>
struct hgros::CustomCodec<hgros_test::Mark> {
  static constexpr std::string_view kTypeName = "test.Mark";
  static bool Serialize(const hgros_test::Mark& mark, std::string& bytes) {
    bytes = mark.text;
    return true;
  }
  static bool Parse(std::string_view bytes, hgros_test::Mark& mark) {
    mark.text = bytes;
    return true;
  }
};

namespace {

using hgros::Invoke;
using hgros_test::Mark;
using hgros_test::Wheel;
using Cloud = hgros::Bulk<foxglove::PointCloud>;

constexpr std::size_t kCloudBytes = 1000;
constexpr std::array<unsigned char, 4> kBlock{0, 1, 254, 255};

void Say(const std::string& line) {
  std::puts(line.c_str());
  std::fflush(stdout);
}

hgros::Config ConfigFor(const std::string& publisher) {
  return hgros::Config::Parse(
      "discovery: {local: false}\nnetwork: {publisher: {ip: \"tcp://127.0.0.1:*\"}, "
      "subscribers: [{ip: \"" +
      publisher + "\"}]}\n");
}

foxglove::Log Text(const std::string& message) {
  foxglove::Log log;
  log.set_message(message);
  return log;
}

class Robot {
 public:
  explicit Robot(const std::string& publisher) : session_(ConfigFor(publisher), {.name = "robot"}) {
    params_.Declare("count", 0);
    Say("endpoint " + session_.PublisherEndpoints().at(0));
  }

  void PublishAll() {
    // "echo" is published while this message is handled.
    (void)text_(Text("hello"));
    auto cloud = session_.Loan<Cloud>("cloud", kCloudBytes);
    cloud->head().set_frame_id("lidar");
    cloud->head().set_point_stride(4);
    std::uint8_t next = 0;
    for (std::byte& byte : cloud->writable()) byte = std::byte{next++};
    (void)cloud_(std::move(cloud));
    (void)wheel_(Wheel{1.5F, {1, -2, 3, -4}});
    (void)mark_(Mark{"a mark"});
    auto block = std::make_unique<hgros::Block>(hgros::Block::Allocate(kBlock.size()));
    std::memcpy(block->writable().data(), kBlock.data(), kBlock.size());
    (void)block_(std::move(block));
    (void)params_.Set("count", ++count_);
  }

 private:
  template <class T, class F>
  hgros::Subscription Take(const std::string& channel, F text_of) {
    return session_.FromAny<T>(channel, Invoke::kSerial, [channel, text_of](const T& message) {
      Say("took " + channel + " " + text_of(message));
    });
  }

  hgros::Session session_;
  int count_ = 0;
  hgros::ParamServer params_;
  std::shared_ptr<hgros::SimulatedClock> clock_ = std::make_shared<hgros::SimulatedClock>();
  hgros::ClockPublisher clock_publisher_{session_, clock_};
  hgros::ParamService param_service_{session_, params_};
  hgros::Publisher<foxglove::Log> text_ = session_.Advertise<foxglove::Log>("text", {.latched = 2});
  hgros::Publisher<foxglove::Log> echo_ = session_.Advertise<foxglove::Log>("echo");
  hgros::Publisher<Cloud> cloud_ = session_.Advertise<Cloud>("cloud");
  hgros::Publisher<Wheel> wheel_ = session_.Advertise<Wheel>("wheel");
  hgros::Publisher<Mark> mark_ = session_.Advertise<Mark>("mark");
  hgros::Publisher<hgros::Block> block_ = session_.Advertise<hgros::Block>("block");
  hgros::Subscription echoing_ = session_.FromAny<foxglove::Log>(
      "text", Invoke::kSerial, [this](const foxglove::Log& log) { (void)echo_(Text("echo of " + log.message())); },
      {.executor = hgros::Executor::Inline()});
  hgros::Subscription text_in_ = Take<foxglove::Log>("in/text", [](const foxglove::Log& log) { return log.message(); });
  hgros::Subscription cloud_in_ =
      Take<Cloud>("in/cloud", [](const Cloud& cloud) { return std::to_string(cloud.size()) + " bytes"; });
  hgros::Subscription wheel_in_ = Take<Wheel>("in/wheel", [](const Wheel& wheel) {
    return std::to_string(wheel.speed) + " " + std::to_string(wheel.ticks[3]);
  });
  hgros::Subscription mark_in_ = Take<Mark>("in/mark", [](const Mark& mark) { return mark.text; });
  hgros::Subscription block_in_ =
      Take<hgros::Block>("in/block", [](const hgros::Block& block) { return std::to_string(block.size()) + " bytes"; });
};

}  // namespace

int main(int count, char** words) try {
  if (count != 2) throw hgros::Error("usage: robot ENDPOINT");
  Robot robot(words[1]);
  for (std::string line; std::getline(std::cin, line);) robot.PublishAll();
} catch (const std::exception& error) {
  std::fprintf(stderr, "robot: %s\n", error.what());
  return 1;
}
