#include "hgros/c/session.h"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <filesystem>

#include "c/handles.hpp"
#include "hgros/config/config.hpp"
#include "hgros/graph/data_graph.hpp"
#include "hgros/session/session_parts.hpp"

namespace hgros::c {
namespace {

constexpr std::chrono::seconds kSayAgainAfter{10};

LogLevel LevelOf(std::int32_t level) {
  if (level < HGROS_LOG_DEBUG || level > HGROS_LOG_ERROR) {
    throw InvalidArgument("There is no log level " + std::to_string(level) +
                          ". Use HGROS_LOG_DEBUG to HGROS_LOG_ERROR.");
  }
  return static_cast<LogLevel>(level);
}

// A forked child does not write: the log's lock may be held by a thread that it does not have.
template <class F>
hgros_status WriteLog(const hgros_session* session, std::int32_t level, const char* text, F&& write) {
  return Guarded([&] {
    const hgros_session& on = Given(session, "session");
    const LogLevel weight = LevelOf(level);
    const std::string_view line = Text(text, "text");
    if (on.life->in_forked_child()) return Fail(HGROS_CLOSED, kOfParent);
    write(on.session->log(), weight, line);
    return hgros_status{HGROS_OK};
  });
}

// The options also if they are refused, so that the program's pointer is let go in any case. Without a size there are
// none.
hgros_session_options ReadableIn(const hgros_session_options* given) noexcept {
  hgros_session_options readable{};
  if (given != nullptr && IsStructSize(given->size)) {
    std::memcpy(&readable, given, std::min(given->size, sizeof readable));
  }
  return readable;
}

template <class F>
hgros_status Open(const hgros_session_options* given, hgros_session** session, F&& config) {
  const hgros_session_options readable = ReadableIn(given);
  return CreatingFor({}, readable.log_user, readable.log_release, session,
                     [&](const std::shared_ptr<const User>& kept) {
                       const hgros_session_options options = OptionsFrom(given);
                       SessionOptions to;
                       to.name = TextOrNone(options.name);
                       if (options.log != nullptr) {
                         to.log = [log = options.log, kept](LogLevel level, std::string_view text) {
                           log(kept->get(), static_cast<std::int32_t>(level), std::string(text).c_str());
                         };
                       }
                       auto made = std::make_unique<Session>(config(), std::move(to));
                       auto life = std::make_shared<Life>(*made);
                       return std::make_unique<hgros_session>(hgros_session{std::move(made), std::move(life)});
                     });
}

}  // namespace

void Life::Add(const std::shared_ptr<Dependent>& dependent) {
  {
    const std::unique_lock lock(mutex_);
    std::erase_if(dependents_, [](const auto& one) { return one.expired(); });
    dependents_.push_back(dependent);
  }
  if (closed()) dependent->Stop();
}

void Life::Stop() {
  if (fork_.IsChild()) return;
  closed_.store(true, std::memory_order_release);
  stop_.request_stop();
  // Without the lock, because callbacks of calls that end here may use the session.
  const auto [session, dependents] = [this] {
    const std::shared_lock lock(mutex_);
    return std::pair(session_, dependents_);
  }();
  for (const auto& one : dependents) {
    if (const auto dependent = one.lock()) dependent->Stop();
  }
  if (session != nullptr) SessionParts(*session).EndWaits();
}

void Life::End(bool inside) {
  if (fork_.IsChild()) return;
  Stop();
  std::vector<std::weak_ptr<Dependent>> dependents;
  {
    const std::unique_lock lock(mutex_);
    session_ = nullptr;
    dependents.swap(dependents_);
  }
  for (const auto& one : dependents) {
    const auto dependent = one.lock();
    if (dependent) inside ? dependent->Leave() : dependent->End();
  }
}

}  // namespace hgros::c

namespace c = hgros::c;

hgros_status hgros_session_open(const char* yaml, const hgros_session_options* options, hgros_session** session) {
  return c::Open(options, session, [&] {
    const std::string_view text = c::TextOrNone(yaml);
    return text.empty() ? hgros::Config::OfEnvironment() : hgros::Config::Parse(text);
  });
}

hgros_status hgros_session_open_files(const char* const* files, size_t count, const hgros_session_options* options,
                                      hgros_session** session) {
  return c::Open(options, session, [&] {
    std::vector<std::filesystem::path> paths;
    for (std::size_t i = 0; i < count; ++i) paths.emplace_back(c::Text(*(&c::Given(files, "files") + i), "a file"));
    return paths.empty() ? hgros::Config::OfEnvironment() : hgros::Config::Load(paths);
  });
}

void hgros_session_end(hgros_session* session) {
  if (session == nullptr) return;
  (void)c::Guarded([&] { session->life->Stop(); });
}

// Handles of transforms and the like end first. In a callback nothing can be waited for, as ~Session says.
void hgros_session_close(hgros_session* session) {
  if (session == nullptr) return;
  (void)c::Guarded([&] {
    const std::unique_ptr<hgros_session> owned(session);
    const bool inside = c::InCallback::Of(owned->life.get());
    const c::InClose closes;
    owned->life->End(inside);
    if (inside) hgros::SessionParts(*owned->session).LeaveInside();
  });
}

const char* hgros_session_name(const hgros_session* session) {
  return session == nullptr ? nullptr : session->session->name().c_str();
}

uint64_t hgros_session_id(const hgros_session* session) {
  return session == nullptr ? 0 : session->session->id().value;
}

hgros_status hgros_session_wait_idle(const hgros_session* session, int64_t timeout_ns) {
  return c::Guarded([&] {
    const hgros_session& on = c::Opened(session);
    if (hgros::DataGraph::InCallback()) {
      return c::Fail(HGROS_WOULD_DEADLOCK, "A callback may not wait until no callback runs. Wait on another thread.");
    }
    if (on.session->WaitIdle(c::Timeout(timeout_ns))) return hgros_status{HGROS_OK};
    return c::Fail(HGROS_TIMED_OUT, "The session still has messages to handle.");
  });
}

hgros_status hgros_session_log(const hgros_session* session, int32_t level, const char* text) {
  return c::WriteLog(session, level, text,
                     [](hgros::Log& log, hgros::LogLevel weight, std::string_view line) { log.Write(weight, line); });
}

hgros_status hgros_session_log_limited(const hgros_session* session, int32_t level, const char* alike,
                                       const char* text) {
  return c::WriteLog(session, level, text, [alike](hgros::Log& log, hgros::LogLevel weight, std::string_view line) {
    // The library's own keys are other ones.
    log.WriteLimited(weight, "program " + std::string(c::Text(alike, "alike")), line, c::kSayAgainAfter);
  });
}

hgros_status hgros_session_set_log_level(const hgros_session* session, int32_t level) {
  return c::Guarded([&] { c::Given(session, "session").session->log().SetLevel(c::LevelOf(level)); });
}

hgros_status hgros_session_wait_for_subscribers(const hgros_session* session, const char* channel, size_t count,
                                                int64_t timeout_ns) {
  return c::Guarded([&] {
    const std::string_view name = c::Text(channel, "channel");
    const hgros_session& on = c::Opened(session);
    if (on.session->WaitForSubscribers(name, count, c::Timeout(timeout_ns))) return hgros_status{HGROS_OK};
    if (on.life->closed()) return c::Fail(HGROS_CLOSED, on.life->why_closed());
    return c::Fail(HGROS_TIMED_OUT,
                   "Channel " + std::string(name) + " has less than " + std::to_string(count) + " subscribers.");
  });
}

hgros_status hgros_session_wait_for_publishers(const hgros_session* session, const char* channel, size_t count,
                                               int64_t timeout_ns) {
  return c::Guarded([&] {
    const std::string_view name = c::Text(channel, "channel");
    const hgros_session& on = c::Opened(session);
    if (on.session->WaitForPublishers(name, count, c::Timeout(timeout_ns))) return hgros_status{HGROS_OK};
    if (on.life->closed()) return c::Fail(HGROS_CLOSED, on.life->why_closed());
    return c::Fail(HGROS_TIMED_OUT, "Less than " + std::to_string(count) + " other sessions publish on channel " +
                                        std::string(name) + ".");
  });
}
