#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "hgros/hgros.hpp"
#include "support/await.hpp"

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

/// A session and its log.
struct Robot {
  explicit Robot(const std::string& yaml, const std::string& name = "robot")
      : session(std::make_unique<Session>(Config::Parse(yaml),
                                          SessionOptions{name, [this](LogLevel, std::string_view text) {
                                                           const std::scoped_lock lock(mutex);
                                                           lines.emplace_back(text);
                                                         }})) {}
  [[nodiscard]] bool Said(std::string_view part) {
    const std::scoped_lock lock(mutex);
    for (const std::string& line : lines) {
      if (line.find(part) != std::string::npos) return true;
    }
    return false;
  }
  /// The number of lines that contain the text.
  [[nodiscard]] std::size_t Count(std::string_view part) {
    const std::scoped_lock lock(mutex);
    return static_cast<std::size_t>(
        std::ranges::count_if(lines, [&](const std::string& line) { return line.find(part) != std::string::npos; }));
  }
  Session* operator->() const { return session.get(); }

  std::mutex mutex;
  std::vector<std::string> lines;
  std::unique_ptr<Session> session;
};

/// A folder for ipc endpoints, and YAML that uses them.
class Bus {
 public:
  Bus() {
    std::string name = (std::filesystem::temp_directory_path() / "hgros_bus_XXXXXX").string();
    folder_ = mkdtemp(name.data());
  }
  Bus(const Bus&) = delete;
  Bus& operator=(const Bus&) = delete;
  ~Bus() { std::filesystem::remove_all(folder_); }

  [[nodiscard]] std::string Endpoint(const std::string& name) const { return "ipc://" + (folder_ / name).string(); }
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
  std::filesystem::path folder_;
};

inline constexpr Invoke kSerial = Invoke::kSerial;

inline NodeOptions Inline(Queue queue = {}) { return {{}, queue, Executor::Inline()}; }

}  // namespace hgros::test
