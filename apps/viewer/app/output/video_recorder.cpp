#include "viewer/app/output/video_recorder.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <utility>

#include "hgros/base/error.hpp"

namespace hgros::viewer {
namespace {

constexpr int kEndPatience = 3;  // times `patience` is how long ffmpeg may take to finish the file
constexpr int kKilledMs = 5'000;

/// The file of a program with that name; empty if there is none.
std::string FindProgram(const std::string& name) {
  const char* const variable = std::getenv("PATH");
  std::string folders = variable == nullptr ? "/usr/bin:/bin" : variable;
  folders += ':';
  for (std::size_t begin = 0, end = 0; (end = folders.find(':', begin)) != std::string::npos; begin = end + 1) {
    const std::string file = folders.substr(begin, end - begin) + "/" + name;
    if (access(file.c_str(), X_OK) == 0) return file;
  }
  return {};
}

/// The last line of a file.
std::string LastLine(int file) {
  char text[2048];
  const off_t size = lseek(file, 0, SEEK_END);
  const off_t from = std::max<off_t>(0, size - static_cast<off_t>(sizeof text));
  const ssize_t got = pread(file, text, sizeof text, from);
  std::string all(text, got > 0 ? static_cast<std::size_t>(got) : 0);
  while (!all.empty() && (all.back() == '\n' || all.back() == '\r')) all.pop_back();
  return all.substr(all.find_last_of("\r\n") + 1);
}

std::string Seconds(std::chrono::milliseconds time) {
  char text[32];
  std::snprintf(text, sizeof text, "%g s", std::chrono::duration<double>(time).count());
  return text;
}

/// Returns whether the child ends within that time. It still must be waited for.
bool AwaitEnd(pid_t child, std::chrono::milliseconds most) {
  const int handle = static_cast<int>(syscall(SYS_pidfd_open, child, 0U));
  if (handle < 0) return true;  // An old kernel: the later wait has no limit.
  pollfd wait{handle, POLLIN, 0};
  const auto end = std::chrono::steady_clock::now() + most;
  int ready = 0;
  do {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(end - std::chrono::steady_clock::now());
    ready = poll(&wait, 1, static_cast<int>(std::max<std::int64_t>(0, left.count())));
  } while (ready < 0 && errno == EINTR);
  close(handle);
  return ready != 0;
}

}  // namespace

VideoRecorder::VideoRecorder(std::filesystem::path file, std::chrono::milliseconds patience)
    : file_(std::move(file)), patience_(patience), program_(FindProgram("ffmpeg")) {
  if (program_.empty()) {
    throw Error("Films need the program ffmpeg, which is not installed.", "",
                "Install Debian's package ffmpeg, or leave out --record-video.");
  }
}

VideoRecorder::~VideoRecorder() {
  if (!ended_) (void)Finish();
}

std::string VideoRecorder::Start(const Viewport& size) {
  size_ = size;
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) return std::strerror(errno);
  to_child_ = ends[0];
  words_ = memfd_create("ffmpeg", MFD_CLOEXEC);
  const std::string extent = std::to_string(size.width) + "x" + std::to_string(size.height);
  // Timestamps are in hundredths of a second. Most film formats need an even width and height.
  std::vector<std::string> words = {program_,
                                    "-hide_banner",
                                    "-loglevel",
                                    "error",
                                    "-y",
                                    "-f",
                                    "rawvideo",
                                    "-pixel_format",
                                    "rgb24",
                                    "-video_size",
                                    extent,
                                    "-framerate",
                                    "100",
                                    "-use_wallclock_as_timestamps",
                                    "1",
                                    "-i",
                                    "pipe:0",
                                    "-vf",
                                    "pad=ceil(iw/2)*2:ceil(ih/2)*2",
                                    "-fps_mode",
                                    "vfr",
                                    "-pix_fmt",
                                    "yuv420p",
                                    "file:" + file_.string()};
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, ends[1], STDIN_FILENO);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, words_, STDERR_FILENO);
  // ffmpeg ends when its pictures end, not by the SIGINT that ends the viewer. So it gets its own process group, with
  // no signals blocked.
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t none;
  sigemptyset(&none);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setpgroup(&attributes, 0);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETPGROUP);
  const int fault = posix_spawn(&child_, program_.c_str(), &actions, &attributes, arguments.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  close(ends[1]);
  if (fault == 0) return {};
  child_ = -1;
  return std::string("ffmpeg cannot be started: ") + std::strerror(fault) + ".";
}

std::string VideoRecorder::Add(const Viewport& size, std::span<const std::uint8_t> rgb) {
  if (ended_) return {};
  if (child_ < 0) {
    if (std::string fault = Start(size); !fault.empty()) {
      ended_ = true;
      return fault;
    }
  }
  if (size == size_) {
    last_.assign(rgb.begin(), rgb.end());
  } else {
    const auto row_bytes = static_cast<std::ptrdiff_t>(size_.width) * 3;
    const std::ptrdiff_t given_bytes = static_cast<std::ptrdiff_t>(size.width) * 3;
    last_.assign(static_cast<std::size_t>(row_bytes) * static_cast<std::size_t>(size_.height), 0);
    for (int y = 0; y < std::min(size.height, size_.height); ++y) {
      std::copy_n(rgb.begin() + given_bytes * y, std::min(row_bytes, given_bytes), last_.begin() + row_bytes * y);
    }
  }
  return Send();
}

std::string VideoRecorder::Repeat() { return ended_ || last_.empty() ? std::string() : Send(); }

std::string VideoRecorder::Send() {
  std::span<const std::uint8_t> rgb = last_;
  while (!rgb.empty()) {
    pollfd wait{to_child_, POLLOUT, 0};
    const int ready = poll(&wait, 1, static_cast<int>(patience_.count()));
    if (ready < 0 && errno == EINTR) continue;
    if (ready == 0) {
      kill(child_, SIGKILL);
      (void)End();
      return "ffmpeg accepted no picture for " + Seconds(patience_) + " and was stopped: " + file_.string() +
             " is not complete.";
    }
    const ssize_t sent = send(to_child_, rgb.data(), rgb.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    if (sent < 0 && (errno == EAGAIN || errno == EINTR)) continue;
    if (sent < 0) {
      const std::string why = End();
      return why.empty() ? "ffmpeg has ended before the film: " + file_.string() + " may not be whole." : why;
    }
    rgb = rgb.subspan(static_cast<std::size_t>(sent));
  }
  ++pictures_;
  return {};
}

std::string VideoRecorder::End() {
  ended_ = true;
  if (to_child_ >= 0) close(std::exchange(to_child_, -1));
  const bool stuck = child_ > 0 && !AwaitEnd(child_, kEndPatience * patience_);
  bool gone = true;
  if (stuck) {
    kill(child_, SIGKILL);
    // A process that waits for a disk does not end even then.
    gone = AwaitEnd(child_, std::chrono::milliseconds(kKilledMs));
  }
  int status = 0;
  pid_t got = -1;
  while (gone && child_ > 0 && (got = waitpid(child_, &status, 0)) < 0 && errno == EINTR) {
  }
  child_ = -1;
  std::string said;
  if (words_ >= 0) {
    said = LastLine(words_);
    close(std::exchange(words_, -1));
  }
  if (stuck) {
    return "ffmpeg did not end within " + Seconds(kEndPatience * patience_) + " and was killed: " + file_.string() +
           " is not whole.";
  }
  if (got <= 0 || (WIFEXITED(status) && WEXITSTATUS(status) == 0)) return {};
  return "The film " + file_.string() + " is not whole: ffmpeg " + (WIFSIGNALED(status) ? "was killed" : "failed") +
         (said.empty() ? "." : " and said: " + said);
}

std::string VideoRecorder::Finish() {
  if (ended_) return {};
  if (child_ < 0) {
    ended_ = true;
    return "No picture was drawn, so there is no film.";
  }
  return End();
}

}  // namespace hgros::viewer
