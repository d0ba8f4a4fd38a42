#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "hgros/hgros.h"
#include "support/await.hpp"
#include "support/scratch_folder.hpp"

namespace hgros::test {

inline constexpr std::int64_t kPatienceNs = std::chrono::nanoseconds(kPatience).count();

inline std::string LastError() { return hgros_last_error(); }

/// Calls the function that ends a handle.
template <auto End>
struct Ends {
  template <class T>
  void operator()(T* handle) const {
    (void)End(handle);
  }
};
template <class Result, class Handle>
Handle* HandleOf(Result (*end)(Handle*));

/// What a function opens, whose last argument says where the handle goes.
template <auto End, class Function, class... Arguments>
auto Opened(Function function, Arguments... arguments) {
  decltype(HandleOf(End)) handle = nullptr;
  EXPECT_EQ(function(arguments..., &handle), HGROS_OK) << LastError();
  return std::unique_ptr<std::remove_pointer_t<decltype(handle)>, Ends<End>>(handle);
}

/// A struct of the interface with its size.
template <class Struct>
Struct Sized() {
  Struct sized{};
  sized.size = sizeof sized;
  return sized;
}

using SessionHandle = std::unique_ptr<hgros_session, Ends<hgros_session_close>>;
using SchemaHandle = std::unique_ptr<hgros_schema, Ends<hgros_schema_free>>;
using MessageHandle = std::unique_ptr<hgros_message, Ends<hgros_message_free>>;
using PublisherHandle = std::unique_ptr<hgros_publisher, Ends<hgros_publisher_close>>;
using SubscriptionHandle = std::unique_ptr<hgros_subscription, Ends<hgros_subscription_close>>;
using ServiceHandle = std::unique_ptr<hgros_service, Ends<hgros_service_close>>;
using WatchHandle = std::unique_ptr<hgros_watch, Ends<hgros_watch_close>>;

inline std::string TextOf(const hgros_message* message) {
  std::size_t size = 0;
  const void* const data = hgros_message_data(message, &size);
  return {static_cast<const char*>(data), size};
}

/// Texts that a callback or the log of a session gets.
class Texts {
 public:
  static void Add(void* user, const hgros_message* message) { static_cast<Texts*>(user)->Add(TextOf(message)); }
  static void Add(void* user, int32_t /*level*/, const char* line) { static_cast<Texts*>(user)->Add(line); }
  void Add(std::string text) {
    const std::scoped_lock lock(mutex_);
    texts_.push_back(std::move(text));
  }
  [[nodiscard]] std::vector<std::string> all() const {
    const std::scoped_lock lock(mutex_);
    return texts_;
  }
  [[nodiscard]] bool Contain(std::string_view part) const {
    const auto texts = all();
    return std::any_of(texts.begin(), texts.end(),
                       [&](const std::string& one) { return one.find(part) != std::string::npos; });
  }

 private:
  mutable std::mutex mutex_;
  std::vector<std::string> texts_;
};
using LogLines = Texts;

/// From now on sessions are in a domain that no other test uses. Returns their configuration.
inline std::string DomainYaml() {
  static int number = 0;
  setenv("HGROS_DOMAIN", ("c-test-" + std::to_string(getpid()) + "-" + std::to_string(++number)).c_str(), 1);
  return "data_graph: {threads: 2}";
}

inline SessionHandle Open(const std::string& yaml, LogLines& log, const char* name = "robot") {
  auto options = Sized<hgros_session_options>();
  options.name = name;
  options.log = &LogLines::Add;
  options.log_user = &log;
  return Opened<hgros_session_close>(hgros_session_open, yaml.c_str(), &options);
}

inline SchemaHandle TextSchema(const char* name = "text") {
  return Opened<hgros_schema_free>(hgros_schema_create, name, HGROS_ENCODING_CUSTOM, 0U, nullptr, 0U);
}

inline PublisherHandle Publisher(const SessionHandle& session, const char* channel, const SchemaHandle& schema,
                                 std::uint64_t latched = 0) {
  auto options = Sized<hgros_publish_options>();
  options.latched = latched;
  return Opened<hgros_publisher_close>(hgros_publisher_open, session.get(), channel, schema.get(), &options);
}

inline hgros_status Publish(const PublisherHandle& publisher, std::string_view text) {
  return hgros_publish(publisher.get(), text.data(), text.size());
}

inline SubscriptionHandle Queue(const SessionHandle& session, const char* channel, std::uint64_t keep_all = 0,
                                const hgros_schema* schema = nullptr) {
  auto options = Sized<hgros_subscribe_options>();
  options.keep_all = keep_all;
  options.schema = schema;
  return Opened<hgros_subscription_close>(hgros_subscribe_queue, session.get(), channel, &options);
}

/// Subscribes with that, which must live as long.
template <class Callback>
SubscriptionHandle Subscribe(const SessionHandle& session, const char* channel, const Callback& callback) {
  const auto call = [](void* user, const hgros_message* message) { (*static_cast<const Callback*>(user))(message); };
  return Opened<hgros_subscription_close>(hgros_subscribe, session.get(), channel, nullptr, call,
                                          const_cast<Callback*>(&callback), nullptr);
}

/// The next message as text, or the name of the status.
inline std::string Take(const SubscriptionHandle& queue, std::int64_t timeout_ns = kPatienceNs) {
  hgros_message* message = nullptr;
  const hgros_status status = hgros_queue_take(queue.get(), timeout_ns, &message);
  const MessageHandle owned(message);
  return status == HGROS_OK ? TextOf(message) : "<" + std::string(hgros_status_name(status)) + ">";
}

/// Sessions of a domain of their own.
class CTest : public testing::Test {
 protected:
  SessionHandle OpenOther(const char* name = "other") { return Open(yaml, others_log, name); }

  LogLines log;
  LogLines others_log;
  std::string yaml = DomainYaml();
  SessionHandle session = Open(yaml, log);
  SchemaHandle text = TextSchema();
};

}  // namespace hgros::test
