// What becomes of the messages that a session publishes last when its subscribers are far away.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <linux/if_tun.h>
#include <net/if.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <deque>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <foxglove/Log.pb.h>

#include "hgros/hgros.hpp"
#include "support/await.hpp"
#include "support/cable.hpp"

namespace hgros::resilience {
namespace {

using foxglove::Log;
using test::Await;
using test::Ip;
using test::kPatience;

// The end of the cable in that host; negative if there is none.
int Plug(const std::string& host, const std::string& address) {
  if (!Ip("netns add " + host)) return -1;
  int fd = -1;
  test::On(host, [&fd] {
    fd = open("/dev/net/tun", O_RDWR | O_NONBLOCK | O_CLOEXEC);
    ifreq request{};
    std::strncpy(request.ifr_name, "eth0", IFNAMSIZ - 1);
    request.ifr_flags = IFF_TAP | IFF_NO_PI;
    if (fd >= 0 && ioctl(fd, TUNSETIFF, &request) != 0) {
      close(fd);
      fd = -1;
    }
  });
  const bool up = fd >= 0 && Ip("-n " + host + " addr add " + address + " broadcast + dev eth0") &&
                  Ip("-n " + host + " link set eth0 up");
  if (fd >= 0 && !up) close(fd);
  return up ? fd : -1;
}

/// Two hosts, 10.196.0.1 and 10.196.0.2, and a cable between them that delays each frame, and may limit the rate.
/// Unlike a relay it acknowledges nothing: what the other host has not got stays in the sender's kernel. Needs root.
class SlowCable {
 public:
  /// `bits_per_second`: 0 for no limit.
  SlowCable(std::chrono::milliseconds each_way, double bits_per_second)
      : each_way_(each_way), bits_per_second_(bits_per_second) {
    test::RemoveLeftNamespaces();
    lanes_[0].from = lanes_[1].to = Plug(left, "10.196.0.1/24");
    lanes_[0].to = lanes_[1].from = Plug(right, "10.196.0.2/24");
    ready = lanes_[0].from >= 0 && lanes_[0].to >= 0 && pipe2(stop_, O_CLOEXEC) == 0;
    if (ready) thread_ = std::thread([this] { Run(); });
  }
  SlowCable(const SlowCable&) = delete;
  SlowCable& operator=(const SlowCable&) = delete;
  ~SlowCable() {
    if (thread_.joinable()) {
      close(stop_[1]);
      thread_.join();
      close(stop_[0]);
    }
    for (const Lane& lane : lanes_) {
      if (lane.from >= 0) close(lane.from);
    }
    for (const std::string& host : {left, right}) (void)Ip("netns del " + host);
  }
  /// From now on every frame is lost.
  void Cut() { cut_ = true; }

  const std::string left = "hgta" + std::to_string(getpid());
  const std::string right = "hgtb" + std::to_string(getpid());
  bool ready = false;

 private:
  using Time = std::chrono::steady_clock::time_point;
  struct Frame {
    Time due;
    std::string bytes;
  };
  struct Lane {
    int from = -1;
    int to = -1;
    Time free{};  // When its rate allows the next frame.
    std::deque<Frame> frames;
  };

  void Read(Lane& lane, Time now) const {
    std::array<char, 2048> frame;
    for (ssize_t size = 0; (size = read(lane.from, frame.data(), frame.size())) > 0;) {
      if (cut_) continue;
      lane.free = std::max(lane.free, now);
      if (bits_per_second_ > 0) {
        lane.free +=
            std::chrono::nanoseconds(static_cast<std::int64_t>(8e9 * static_cast<double>(size) / bits_per_second_));
      }
      lane.frames.push_back({lane.free + each_way_, {frame.data(), static_cast<std::size_t>(size)}});
    }
  }
  static void Write(Lane& lane, Time now) {
    for (; !lane.frames.empty() && lane.frames.front().due <= now; lane.frames.pop_front()) {
      const std::string& bytes = lane.frames.front().bytes;
      [[maybe_unused]] const auto written = write(lane.to, bytes.data(), bytes.size());
    }
  }
  void Run() {
    for (;;) {
      Time wake = std::chrono::steady_clock::now() + std::chrono::seconds(1);
      for (Lane& lane : lanes_) {
        Write(lane, std::chrono::steady_clock::now());
        if (!lane.frames.empty()) wake = std::min(wake, lane.frames.front().due);
      }
      const auto patience =
          std::chrono::ceil<std::chrono::milliseconds>(wake - std::chrono::steady_clock::now()).count();
      pollfd fds[] = {{stop_[0], POLLIN, 0}, {lanes_[0].from, POLLIN, 0}, {lanes_[1].from, POLLIN, 0}};
      poll(fds, 3, static_cast<int>(std::max<std::int64_t>(patience, 0)));
      if (fds[0].revents != 0) return;
      for (Lane& lane : lanes_) Read(lane, std::chrono::steady_clock::now());
    }
  }

  const std::chrono::milliseconds each_way_;
  const double bits_per_second_;
  std::atomic<bool> cut_{false};
  Lane lanes_[2];  // Only the thread uses them.
  int stop_[2] = {-1, -1};
  std::thread thread_;
};

class LastMessages : public testing::Test {
 protected:
  // False: there is no such cable here.
  bool Connect(std::chrono::milliseconds each_way, double bits_per_second, Queue queue) {
    if (geteuid() != 0) return false;
    cable_.emplace(each_way, bits_per_second);
    if (!cable_->ready) return false;
    test::On(cable_->left, [this] {
      talker_.emplace(Config::Parse("{discovery: {local: false}, network: {publisher: {ip: \"tcp://*:5601\"}}}"),
                      SessionOptions{"talker", [this](LogLevel level, std::string_view text) {
                                       const std::scoped_lock lock(mutex_);
                                       if (level >= LogLevel::kWarning) warnings_.emplace_back(text);
                                     }});
    });
    test::On(cable_->right, [this] {
      listener_.emplace(Config::Parse("{discovery: {local: false}, network: {subscribers: [{ip: "
                                      "\"tcp://10.196.0.1:5601\"}]}}"),
                        SessionOptions{"listener"});
    });
    subscription_ = listener_->FromAny<Log>(
        "logs", Invoke::kSerial, [this](const Log& log) { bytes_ += log.message().size(); }, {.queue = queue});
    (void)talker_->Advertise<Log>("logs");
    EXPECT_TRUE(talker_->WaitForSubscribers("logs", 1, kPatience));
    return true;
  }
  void Publish(std::size_t messages, std::size_t bytes) {
    Log log;
    log.set_message(std::string(bytes, 'x'));
    for (std::size_t i = 0; i < messages; ++i) ASSERT_EQ(talker_->ToAny("logs", log), PublishStatus::kOk);
    published_ = messages * bytes;
  }
  void ExpectThatAllArrive() {
    talker_.reset();
    EXPECT_TRUE(Await([&] { return bytes_ >= published_; })) << bytes_ << " bytes of " << published_;
    EXPECT_EQ(bytes_, published_);
    EXPECT_EQ(Warnings(), std::vector<std::string>());
    subscription_.Reset();
    listener_.reset();
    bytes_ = 0;
  }
  [[nodiscard]] std::vector<std::string> Warnings() {
    const std::scoped_lock lock(mutex_);
    return warnings_;
  }

  std::optional<SlowCable> cable_;
  std::mutex mutex_;
  std::vector<std::string> warnings_;  // Of the talker; guarded by mutex_.
  std::atomic<std::size_t> bytes_{0};
  std::size_t published_ = 0;
  std::optional<Session> talker_;    // On the left host.
  std::optional<Session> listener_;  // On the right host.
  Subscription subscription_;
};

constexpr const char* kNoCable = "needs root, network namespaces and TAP devices";

TEST_F(LastMessages, ReachSubscribersOverALongLine) {
  for (const Queue queue : {Queue::KeepAll(1000), Queue::KeepLast(1000)}) {
    if (!Connect(std::chrono::milliseconds(20), 0, queue)) GTEST_SKIP() << kNoCable;
    Publish(900, 1000);
    ExpectThatAllArrive();
  }
}

TEST_F(LastMessages, ReachSubscribersIfTheyNeedLongerThanASilentPeerMay) {
  for (const Queue queue : {Queue::KeepAll(10), Queue::KeepLast(16)}) {
    if (!Connect(std::chrono::milliseconds(5), 20e6, queue)) GTEST_SKIP() << kNoCable;
    Publish(1, 2'000'000);
    ExpectThatAllArrive();
  }
}

TEST_F(LastMessages, AreSaidToBeLostWithTheirNumberIfTheLineIsCut) {
  if (!Connect(std::chrono::milliseconds(5), 0, Queue::KeepAll(1000))) GTEST_SKIP() << kNoCable;
  cable_->Cut();
  Publish(30, 1000);
  talker_.reset();
  const auto warnings = Warnings();
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_NE(warnings[0].find("up to 30 messages of lossless channels, such as \"logs\""), std::string::npos)
      << warnings[0];
  EXPECT_EQ(bytes_, 0U);
}

}  // namespace
}  // namespace hgros::resilience
