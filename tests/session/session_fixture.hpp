#pragma once

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "clock/lines.hpp"
#include "hgros/hgros.hpp"
#include "support/await.hpp"
#include "support/scratch_folder.hpp"

namespace hgros::test {

/// A message with its own codec, as the paper's custom types have it, that counts its calls.
struct Note {
  std::string text;

  Note() = default;
  explicit Note(std::string value) : text(std::move(value)) {}
  bool SerializeToString(std::string* out) const {
    ++written;
    *out = text;
    return text != "unwritable";
  }
  bool ParseFromString(const std::string& in) {
    ++read;
    text = in;
    return text != "unreadable";
  }
  inline static std::atomic<int> written{0};
  inline static std::atomic<int> read{0};
};

/// Collects the texts of notes.
class Notes {
 public:
  void operator()(const Note& note) {
    const std::scoped_lock lock(mutex_);
    texts_.push_back(note.text);
  }
  [[nodiscard]] std::vector<std::string> texts() const {
    const std::scoped_lock lock(mutex_);
    return texts_;
  }
  [[nodiscard]] std::size_t size() const { return texts().size(); }

 private:
  mutable std::mutex mutex_;
  std::vector<std::string> texts_;
};

/// Keeps the messages of a subscription, and what is known of them.
template <class T>
class Kept {
 public:
  void operator()(const std::shared_ptr<const T>& message, const MessageInfo& info) {
    const std::scoped_lock lock(mutex_);
    messages_.push_back(message);
    infos_.push_back(info);
  }
  [[nodiscard]] std::shared_ptr<const T> at(std::size_t index) const {
    const std::scoped_lock lock(mutex_);
    return messages_.at(index);
  }
  [[nodiscard]] MessageInfo info(std::size_t index) const {
    const std::scoped_lock lock(mutex_);
    return infos_.at(index);
  }
  [[nodiscard]] std::size_t size() const {
    const std::scoped_lock lock(mutex_);
    return messages_.size();
  }
  [[nodiscard]] bool AwaitSize(std::size_t count) const {
    return Await([&] { return size() == count; });
  }

 private:
  mutable std::mutex mutex_;
  std::vector<std::shared_ptr<const T>> messages_;
  std::vector<MessageInfo> infos_;
};

/// A session and its log.
struct Robot {
  explicit Robot(const std::string& yaml, const std::string& name = "robot")
      : session(std::make_unique<Session>(Config::Parse(yaml), SessionOptions{name, lines.Sink()})) {}
  [[nodiscard]] bool Said(std::string_view part) const { return lines.Contains(part); }
  /// The number of lines that contain the text.
  [[nodiscard]] std::size_t Count(std::string_view part) const { return lines.Count(part); }
  Session* operator->() const { return session.get(); }

  Lines lines;
  std::unique_ptr<Session> session;
};

/// A folder for ipc endpoints, and YAML that uses them.
class Bus {
 public:
  [[nodiscard]] std::string Endpoint(const std::string& name) const { return folder_.Ipc(name); }
  [[nodiscard]] std::string Publisher(const std::string& name, const std::string& channels = {}) const {
    return "publisher: {ip: \"" + Endpoint(name) + "\"" + List(channels) + "}";
  }
  [[nodiscard]] std::string Subscriber(const std::string& name, const std::string& channels = {}) const {
    return "{ip: \"" + Endpoint(name) + "\"" + List(channels) + "}";
  }
  [[nodiscard]] std::string Publishing(const std::string& name, const std::string& channels = {}) const {
    return "network: {" + Publisher(name, channels) + "}\n";
  }
  [[nodiscard]] std::string Subscribing(const std::string& name, const std::string& channels = {}) const {
    return "network: {subscribers: [" + Subscriber(name, channels) + "]}\n";
  }
  [[nodiscard]] std::string Both(const std::string& own, const std::string& other) const {
    return "network: {" + Publisher(own) + ", subscribers: [" + Subscriber(other) + "]}\n";
  }

 private:
  static std::string List(const std::string& channels) {
    return channels.empty() ? std::string() : ", channels: [" + channels + "]";
  }
  ScratchFolder folder_;
};

inline constexpr Invoke kSerial = Invoke::kSerial;

inline NodeOptions Inline(Queue queue = {}) { return {{}, queue, Executor::Inline()}; }

}  // namespace hgros::test
