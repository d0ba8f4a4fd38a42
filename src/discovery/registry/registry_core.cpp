#include "discovery/registry/registry_core.hpp"

#include <pthread.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "discovery/registry/announcement_file.hpp"
#include "discovery/registry/session_file.hpp"
#include "discovery/registry/stale_folders.hpp"
#include "hgros/base/error.hpp"
#include "hgros/base/system_limits.hpp"

namespace hgros::discovery {
namespace {

// The kernel reports that a file was closed a moment before it releases the lock.
constexpr auto kFirstPause = std::chrono::milliseconds(1);
constexpr int kPauseGrowth = 10;
constexpr auto kLongestDoubt = std::chrono::seconds(1);
// A living session restores a removed file sooner.
constexpr auto kGrace = std::chrono::milliseconds(500);
constexpr auto kBetweenMendings = std::chrono::seconds(1);
constexpr int kOpenTries = 100;
constexpr auto kFirstLookElsewhere = std::chrono::seconds(1);
constexpr auto kLongestLookElsewhere = std::chrono::minutes(1);

constexpr std::string_view kEnded = "Its process ended without a goodbye.";

}  // namespace

RegistryCore::RegistryCore(const RegistryOptions& options, DiscoveryListener& listener, Log& log)
    : listener_(listener),
      log_(log),
      folder_(options),
      own_(folder_, log),
      watch_(log),
      between_looks_elsewhere_(kFirstLookElsewhere) {
  Open();
  Scan(true);
  book_.Tell(listener_);
  LookElsewhere();  // Some commands end before they announce themselves.
  thread_ = StartThread<std::thread>("the thread of the registry", [this] { Loop(); });
}

RegistryCore::~RegistryCore() {
  stopping_ = true;
  wake_.Signal();
  thread_.join();
  own_.Withdraw();
  folder_.RemoveIfEmpty();
}

void RegistryCore::Announce(const Announcement& own) {
  own_.Announce(own, book_.size());
  wake_.Signal();
}

void RegistryCore::Loop() {
  pthread_setname_np(pthread_self(), "hgros-registry");
  RemoveStaleFolders(folder_.path());
  for (;;) {
    book_.Tell(listener_);
    wake_.Wait(watch_.fd(), Deadline());
    if (stopping_) return;
    const FolderWatch::News news = watch_.Read(read_.size());
    ExamineAll(news.events);
    // The first announcement makes the folder if the last session that left has removed it.
    const bool mending_due = next_mending_ && *next_mending_ <= Clock::now();
    if (news.folder_lost || mending_due || (!next_mending_ && !watch_.Watches(folder_.path()))) {
      Mend();
    } else if (news.missed) {
      Scan(news.deaths);
    }
    LookAgain();
    own_.WriteIfDue();
    if (own_.announced() && next_look_elsewhere_ <= Clock::now()) {
      LookElsewhere();
      PlanLookElsewhere();
    }
  }
}

std::optional<RegistryCore::Clock::time_point> RegistryCore::Deadline() const {
  std::optional<Clock::time_point> first = own_.next_write();
  const auto consider = [&](Clock::time_point time) { first = first ? std::min(*first, time) : time; };
  if (next_mending_) consider(*next_mending_);
  if (watch_.next_look()) consider(*watch_.next_look());
  if (own_.announced() && next_look_elsewhere_ != Clock::time_point::max()) consider(next_look_elsewhere_);
  for (const auto& [name, doubt] : doubts_) consider(doubt.next_look);
  return first;
}

void RegistryCore::Open() {
  for (int tries = 1;; ++tries) {
    folder_.Make();
    try {
      watch_.Watch(folder_.path());
      return;
    } catch (const Error&) {
      // The last session that leaves may remove the folder between the two steps.
      if (tries == kOpenTries || std::filesystem::exists(folder_.path())) throw;
    }
  }
}

void RegistryCore::Mend() {
  try {
    Open();
    next_mending_.reset();
  } catch (const Error& error) {
    log_.WriteLimited(LogLevel::kError, "registry folder", error.what());
    next_mending_ = Clock::now() + kBetweenMendings;
  }
  Scan(true);
}

// A file that has changed several times since the last look is read once.
void RegistryCore::ExamineAll(const std::vector<FolderWatch::FileEvent>& events) {
  std::unordered_map<std::string_view, const FolderWatch::FileEvent*> last_put;
  for (const FolderWatch::FileEvent& one : events) {
    if (one.event == Event::kPut) last_put[one.name] = &one;
  }
  for (const FolderWatch::FileEvent& one : events) {
    if (one.event != Event::kPut || last_put.at(one.name) == &one) Examine(one.name, one.event);
  }
}

// `deaths`: the locks of files that have not changed are looked at, too.
void RegistryCore::Scan(bool deaths) {
  own_.RestoreIfLost();
  const auto files = FilesIn(folder_.path());
  if (!files) return SayBlind();
  std::unordered_set<SessionId> here;
  for (const auto& [name, stamp] : *files) {
    here.insert(SessionOfFile(name));
    const auto read = read_.find(name);
    if (deaths || read == read_.end() || read->second != stamp) Examine(name, std::nullopt);
  }
  for (const SessionId session : book_.Sessions()) {
    if (!here.contains(session)) ExamineAbsent(FileName(session), session, Event::kRemoved);
  }
}

void RegistryCore::SayBlind() {
  log_.WriteLimited(LogLevel::kWarning, "registry open files",
                    "This process does not see which sessions come and change: the limit of open files is reached. "
                    "Raise it (ulimit -n).");
  next_mending_ = Clock::now() + kBetweenMendings;
}

void RegistryCore::Examine(const std::string& name, std::optional<Event> event) {
  const SessionId session = SessionOfFile(name);
  if (session.value == 0) {
    const bool may_be_left_over = IsUnfinished(name) && (!event || event == Event::kClosed);
    if (may_be_left_over && LookAtFile(folder_.path() / name).state == FileLook::State::kStale) {
      RemoveStaleFile(folder_.path() / name);
    }
    return;
  }
  if (own_.Owns(session)) {
    own_.RestoreIfLost();
    return;
  }
  const auto read = read_.find(name);
  const FileLook look = LookAtFile(folder_.path() / name, read == read_.end() ? FileStamp() : read->second);
  if (look.state != FileLook::State::kStrange && look.state != FileLook::State::kUnknown) strange_.erase(name);
  switch (look.state) {
    case FileLook::State::kAbsent: ExamineAbsent(name, session, event); return;
    case FileLook::State::kStale:
      RemoveStaleFile(folder_.path() / name);
      doubts_.erase(name);
      Forget(name, session, kEnded);
      return;
    case FileLook::State::kStrange:
      SayOnce(name, look.fault);
      Forget(name, session, "Its file cannot be trusted any more.");
      return;
    case FileLook::State::kUnknown: SayBlind(); return;
    case FileLook::State::kAlive:
    case FileLook::State::kAsKnown:
      if (event == Event::kClosed) {
        doubts_.try_emplace(name, Doubt{Clock::now() + kFirstPause, kFirstPause, false});
      } else if (event == Event::kPut) {
        doubts_.erase(name);
      }
      if (look.state == FileLook::State::kAlive) ExamineAlive(name, session, look);
      return;
  }
}

void RegistryCore::ExamineAbsent(const std::string& name, SessionId session, std::optional<Event> event) {
  if (event == Event::kPut) return;  // The next event reports what has happened to it since.
  if (event == Event::kRemoved && !doubts_.contains(name)) {
    doubts_.emplace(name, Doubt{Clock::now() + kGrace, kGrace, true});
    return;
  }
  const auto doubt = doubts_.find(name);
  const bool removed = doubt != doubts_.end() && doubt->second.removed;
  if (removed && event == Event::kRemoved) return;
  if (doubt != doubts_.end()) doubts_.erase(doubt);
  if (event == Event::kMoved) {
    Forget(name, session, "It said goodbye.");
  } else {
    Forget(name, session, removed ? "Its file was removed, and it did not announce itself again." : kEnded);
  }
}

void RegistryCore::Forget(const std::string& name, SessionId session, std::string_view reason) {
  read_.erase(name);
  book_.Remove(session, reason);
}

void RegistryCore::ExamineAlive(const std::string& name, SessionId session, const FileLook& look) {
  read_.erase(name);
  ParsedFile parsed = ParseFile(AsBytes(look.content));
  if (!parsed.announcement) {
    SayOnce(name, parsed.fault);
  } else if (parsed.announcement->session != session) {
    SayOnce(name, "it announces session " + parsed.announcement->session.ToString());
  } else {
    strange_.erase(name);
    read_[name] = look.stamp;
    book_.Put(std::move(*parsed.announcement));
  }
}

void RegistryCore::LookAgain() {
  const Clock::time_point now = Clock::now();
  std::vector<std::string> due;
  for (const auto& [name, doubt] : doubts_) {
    if (doubt.next_look <= now) due.push_back(name);
  }
  for (const std::string& name : due) {
    Examine(name, std::nullopt);
    const auto doubt = doubts_.find(name);
    if (doubt == doubts_.end()) continue;
    doubt->second.pause *= kPauseGrowth;
    doubt->second.next_look = now + doubt->second.pause;
    if (doubt->second.pause > kLongestDoubt) doubts_.erase(doubt);
  }
}

// Two sessions that start at the same moment may choose two folders. After both have announced themselves, at least one
// of them sees the other. Only root sees the folders of others, and these sessions may start later.
void RegistryCore::PlanLookElsewhere() {
  next_look_elsewhere_ = geteuid() == 0 ? Clock::now() + between_looks_elsewhere_ : Clock::time_point::max();
  between_looks_elsewhere_ = std::min<Clock::duration>(2 * between_looks_elsewhere_, kLongestLookElsewhere);
}

void RegistryCore::LookElsewhere() {
  for (const RegistryFolder::Elsewhere& other : folder_.FindElsewhere()) {
    if (!said_elsewhere_.insert(other.folder).second) continue;
    log_.WriteLimited(LogLevel::kWarning, "registry elsewhere",
                      "Sessions of user " + std::to_string(other.user) + " in " + other.folder.string() +
                          " and this one, of user " + std::to_string(geteuid()) + " in " + folder_.path().string() +
                          ", do not find each other. " +
                          (other.user == geteuid() ? "Give all programs the same XDG_RUNTIME_DIR, and start them again."
                                                   : "Run all as one user, or connect them by endpoints."));
  }
}

void RegistryCore::SayOnce(const std::string& name, const std::string& fault) {
  if (std::string& said = strange_[name]; std::exchange(said, fault) == fault) return;
  log_.WriteLimited(LogLevel::kWarning, "strange announcement",
                    "A session's announcement is ignored (" + (folder_.path() / name).string() + "): " + fault +
                        ". Remove it if no program uses it; sessions of other versions need a "
                        "domain of their own.");
}

}  // namespace hgros::discovery
