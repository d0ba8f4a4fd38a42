// The peer in C++. ../README.md says what each role does.
#include <poll.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <future>
#include <map>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <foxglove/Log.pb.h>
#include <foxglove/PointCloud.pb.h>
#include <foxglove/PoseInFrame.pb.h>

#include "hgros/codec/bulk.hpp"
#include "hgros/hgros.hpp"

namespace {

using namespace std::chrono_literals;
using Cloud = hgros::Bulk<foxglove::PointCloud>;

constexpr auto kPatience = 30s;
constexpr auto kSlice = 100ms;
constexpr std::size_t kRoom = 100;

void Require(bool condition, const std::string& sentence) {
  if (!condition) throw std::runtime_error(sentence);
}

void Say(const std::string& line) {
  std::puts(line.c_str());
  std::fflush(stdout);
}

/// The lines of standard input.
class Input {
 public:
  /// Whether there is a next line, or the end, within `timeout`.
  bool Waits(std::chrono::milliseconds timeout) {
    while (!ended_ && text_.find('\n') == std::string::npos) {
      pollfd standard_input{STDIN_FILENO, POLLIN, 0};
      if (poll(&standard_input, 1, static_cast<int>(timeout.count())) == 0) return false;
      char part[4096];
      const ssize_t count = read(STDIN_FILENO, part, sizeof part);
      if (count > 0) text_.append(part, static_cast<std::size_t>(count));
      ended_ = count <= 0;
    }
    return true;
  }
  void Await() { (void)Waits(-1ms); }
  std::optional<std::string> Next() {
    Await();
    const std::size_t end = text_.find('\n');
    if (end == std::string::npos) return std::nullopt;
    std::string line = text_.substr(0, end);
    text_.erase(0, end + 1);
    return line;
  }

 private:
  std::string text_;
  bool ended_ = false;
};

hgros::NodeOptions Lossless() { return {.queue = hgros::Queue::KeepAll(kRoom)}; }

foxglove::Log Text(std::string message) {
  foxglove::Log log;
  log.set_message(std::move(message));
  return log;
}

constexpr std::byte ByteAt(std::size_t i) { return static_cast<std::byte>((i * 7 + 3) & 255); }

/// "" or what is wrong with the bytes of a cloud.
std::string Fault(hgros::Bytes bytes, std::size_t size) {
  if (bytes.size() != size) return "The cloud has " + std::to_string(bytes.size()) + " bytes.";
  for (std::size_t i = 0; i < size; ++i) {
    if (bytes[i] != ByteAt(i)) return "The cloud has other bytes.";
  }
  return "";
}

class Peer {
 public:
  explicit Peer(const std::string& yaml) : session_(hgros::Config::Parse(yaml)) {}

  void Run(const std::vector<std::string>& words) {
    static const std::map<std::string, void (Peer::*)(const std::string&, const std::string&)> roles{
        {"talk", &Peer::Talk},
        {"publish", &Peer::Publish},
        {"subscribe", &Peer::Subscribe},
        {"latch", &Peer::Latch},
        {"bulk-publish", &Peer::BulkPublish},
        {"bulk-subscribe", &Peer::BulkSubscribe},
        {"serve", &Peer::Serve},
        {"call", &Peer::Call},
        {"misfit", &Peer::Misfit},
    };
    const auto role = roles.find(words.at(0));
    Require(role != roles.end(), "There is no role " + words[0] + ".");
    (this->*role->second)(words.size() > 1 ? words[1] : "", words.size() > 2 ? words[2] : "");
  }

 private:
  using Log = foxglove::Log;

  void Talk(const std::string& /*unused*/, const std::string& /*unused*/) {
    Say("ready");
    while (const std::optional<std::string> line = input_.Next()) {
      std::istringstream stream(*line);
      std::vector<std::string> words;
      for (std::string word; stream >> word;) words.push_back(word);
      if (!words.empty()) Run(words);
    }
  }

  void AwaitSubscriber(const std::string& channel) {
    Require(session_.WaitForSubscribers(channel, 1, kPatience), "No subscriber came to " + channel + ".");
  }

  void Publish(const std::string& channel, const std::string& count) {
    const auto publish = session_.Advertise<Log>(channel);
    AwaitSubscriber(channel);
    const int most = std::stoi(count);
    int sent = 0;
    while (sent < most && !input_.Waits(0ms)) {
      const auto status = publish.Wait(std::make_unique<Log>(Text(std::to_string(sent + 1))),
                                       std::chrono::steady_clock::now() + kSlice);
      if (status == hgros::PublishStatus::kTimedOut) continue;
      Require(status == hgros::PublishStatus::kOk, "Message " + std::to_string(sent + 1) + " was not published.");
      if (++sent == 1) Say("publishing");
    }
    Say("published " + std::to_string(sent));
    input_.Await();
  }

  void Subscribe(const std::string& channel, const std::string& count) {
    const int most = std::stoi(count);
    int received = 0;
    bool from_one = false;
    std::string last;
    std::string fault;
    std::promise<void> end;
    const std::future<void> ended = end.get_future();
    {
      const auto subscription = session_.FromAny<Log>(
          channel, hgros::Invoke::kSerial,
          [&](const Log& log) {
            if (received == most || !fault.empty()) return;
            last = log.message();
            if (++received == 1) Say("receiving " + last);
            if (received == 1) from_one = last == "1";
            if (from_one && last != std::to_string(received))
              fault = "\"" + last + "\" came, not " + std::to_string(received) + ".";
            if (received == most || !fault.empty()) end.set_value();
          },
          Lossless());
      while (ended.wait_for(kSlice) != std::future_status::ready && !input_.Waits(0ms)) {
      }
    }
    Require(fault.empty(), fault);
    Say("received " + std::to_string(received) + " " + last);
  }

  void Latch(const std::string& channel, const std::string& text) {
    const auto publish = session_.Advertise<Log>(channel, {.latched = 2});
    for (const std::string& one : {std::string("old"), text, std::string("new")})
      Require(publish(Text(one)) == hgros::PublishStatus::kOk, "The message was not published.");
    Say("latched");
    input_.Await();
  }

  void BulkPublish(const std::string& channel, const std::string& bytes) {
    const auto publish = session_.Advertise<Cloud>(channel);
    AwaitSubscriber(channel);
    auto cloud = session_.Loan<Cloud>(channel, std::stoul(bytes));
    cloud->head().set_point_stride(1);
    std::size_t i = 0;
    for (std::byte& byte : cloud->writable()) byte = ByteAt(i++);
    const auto status = publish.Wait(std::move(cloud), std::chrono::steady_clock::now() + kPatience);
    Require(status == hgros::PublishStatus::kOk, "The cloud was not published.");
    Say("published " + bytes);
    input_.Await();
  }

  void BulkSubscribe(const std::string& channel, const std::string& bytes) {
    std::promise<std::string> end;
    std::future<std::string> found = end.get_future();
    const auto subscription = session_.FromAny<Cloud>(
        channel, hgros::Invoke::kSerial,
        [&](const Cloud& cloud) { end.set_value(Fault(cloud.bytes(), std::stoul(bytes))); }, Lossless());
    Say("subscribed");
    Require(found.wait_for(kPatience) == std::future_status::ready, "Nothing came on " + channel + ".");
    const std::string fault = found.get();
    Require(fault.empty(), fault);
    Say("received " + bytes);
  }

  void Serve(const std::string& name, const std::string& /*unused*/) {
    const auto service = session_.Serve<Log, Log>(name, [](const Log& request) {
      if (request.message() == "fail") throw std::runtime_error("asked to fail");
      return Text("re: " + request.message());
    });
    Say("serving");
    input_.Await();
  }

  void Call(const std::string& name, const std::string& text) {
    const auto deadline = std::chrono::steady_clock::now() + kPatience;
    while (true) {
      const auto result = session_.Call<Log, Log>(name, Text(text), kPatience).Wait();
      if (result) return Say("answer " + result->message());
      if (result.failure().kind != hgros::CallFailure::Kind::kNoServer || std::chrono::steady_clock::now() > deadline) {
        return Say("failed " + result.failure().reason);
      }
      if (input_.Waits(10ms)) throw std::runtime_error("Nobody serves " + name + ".");
    }
  }

  void Misfit(const std::string& channel, const std::string& /*unused*/) {
    const auto subscription =
        session_.FromAny<foxglove::PoseInFrame>(channel, hgros::Invoke::kSerial, [](const foxglove::PoseInFrame&) {});
    Say("subscribed");
    input_.Await();
  }

  hgros::Session session_;
  Input input_;
};

}  // namespace

int main(int count, char** words) try {
  Require(count > 1, "usage: peer ROLE [ARGUMENT...]");
  const char* const yaml = std::getenv("HGROS_INTEROP_YAML");
  Peer(yaml == nullptr ? "" : yaml).Run({words + 1, words + count});
} catch (const std::exception& error) {
  std::fprintf(stderr, "peer: %s\n", error.what());
  return 1;
}
