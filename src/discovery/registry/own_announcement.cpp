#include "discovery/registry/own_announcement.hpp"

#include <algorithm>
#include <utility>

#include "discovery/registry/announcement_file.hpp"
#include "hgros/base/error.hpp"

namespace hgros::discovery {
namespace {

using Clock = std::chrono::steady_clock;

// A program that advertises twenty channels in a row writes twice. Where many sessions read each change, there are
// fewer.
constexpr auto kBetweenWrites = std::chrono::milliseconds(5);
constexpr auto kPauseForReader = std::chrono::microseconds(200);
constexpr auto kLongestWritePause = std::chrono::milliseconds(100);
constexpr auto kBetweenFailures = std::chrono::seconds(1);
constexpr int kTries = 100;

}  // namespace

void OwnAnnouncement::Announce(const Announcement& own, std::size_t readers) {
  std::string content = EncodeFile(own);
  if (TryChange(own, content, readers)) return;
  const std::scoped_lock writing(writing_);
  if (!TryChange(own, content, readers)) WriteFirst(own, std::move(content));
}

// False if there is no first one yet.
bool OwnAnnouncement::TryChange(const Announcement& own, const std::string& content, std::size_t readers) {
  const std::scoped_lock lock(mutex_);
  if (!announced_) return false;
  if (own.session != session_) {
    throw Error("A registry that announces session " + session_.ToString() + " cannot announce " +
                    own.session.ToString() + " too.",
                folder_.path().string(), "Open a registry for each session.");
  }
  if (content == content_) return true;
  content_ = content;
  const Clock::duration pause = kPauseForReader * std::min<std::size_t>(readers, kLongestWritePause / kPauseForReader);
  next_write_ = std::max(Clock::now(), last_write_ + std::max<Clock::duration>(pause, kBetweenWrites));
  return true;
}

void OwnAnnouncement::WriteFirst(const Announcement& own, std::string content) {
  const auto note = [&](SessionId session, bool announced) {
    const std::scoped_lock lock(mutex_);
    session_ = session;
    announced_ = announced;
    if (announced) content_ = std::move(content);
  };
  note(own.session, false);
  try {
    file_.emplace(folder_.path(), own.session);
    Write(content);
  } catch (...) {
    file_.reset();
    note({}, false);
    throw;
  }
  note(own.session, true);
}

void OwnAnnouncement::Write(const std::string& content) {
  for (int tries = 0; tries < kTries; ++tries) {
    folder_.Make();  // The last session that left may have removed it.
    if (!file_->Put(content)) continue;
    const std::scoped_lock lock(mutex_);
    last_write_ = Clock::now();
    return;
  }
  throw Error("The folder in which sessions find each other is removed repeatedly.", folder_.path().string(),
              "Stop the program that removes it.");
}

void OwnAnnouncement::WriteDue() {
  std::string content;
  {
    const std::scoped_lock lock(mutex_);
    if (!announced_ || !next_write_ || *next_write_ > Clock::now()) return;
    content = content_;
    next_write_.reset();
    last_write_ = Clock::now();  // Changes wait from now on.
  }
  try {
    Write(content);
  } catch (const Error& error) {
    log_.WriteLimited(LogLevel::kError, "registry write", error.what());
    const std::scoped_lock lock(mutex_);
    next_write_ = Clock::now() + kBetweenFailures;
  }
}

bool OwnAnnouncement::announced() const {
  const std::scoped_lock lock(mutex_);
  return announced_;
}

bool OwnAnnouncement::Owns(SessionId session) const {
  const std::scoped_lock lock(mutex_);
  return session == session_;
}

std::optional<Clock::time_point> OwnAnnouncement::next_write() const {
  const std::scoped_lock lock(mutex_);
  return next_write_;
}

void OwnAnnouncement::WriteIfDue() noexcept {
  const std::scoped_lock writing(writing_);
  WriteDue();
}

void OwnAnnouncement::RestoreIfLost() noexcept {
  const std::scoped_lock writing(writing_);
  if (!file_ || next_write() || file_->IsInPlace()) return;
  log_.WriteLimited(LogLevel::kWarning, "registry lost " + session_.ToString(),
                    "The file that announces this session was removed by another program (" + file_->path().string() +
                        "); it is written again. Do not clean this folder up: "
                        "sessions remove the files of dead ones themselves.");
  {
    // The other program may continue to remove files.
    const std::scoped_lock lock(mutex_);
    next_write_ = std::max(Clock::now(), last_write_ + kBetweenWrites);
  }
  WriteDue();
}

void OwnAnnouncement::Withdraw() noexcept {
  const std::scoped_lock writing(writing_);
  file_.reset();
  const std::scoped_lock lock(mutex_);
  announced_ = false;
  session_ = {};
}

}  // namespace hgros::discovery
