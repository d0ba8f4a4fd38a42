#include "terminal/line_reader.hpp"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "arguments/command.hpp"
#include "hgros/base/error.hpp"
#include "terminal/pause.hpp"

namespace hgros::cli {

LineReader::LineReader(const std::string& file, std::size_t most_bytes)
    : name_(file == "-" ? "standard input" : file), most_bytes_(most_bytes) {
  descriptor_ = file == "-" ? dup(STDIN_FILENO) : open(file.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor_ < 0) throw UsageError(name_ + " cannot be read: " + std::strerror(errno) + ".");
}

LineReader::~LineReader() { close(descriptor_); }

std::optional<std::string_view> LineReader::Next(Pause& pause, std::chrono::steady_clock::time_point deadline) {
  constexpr std::size_t kBlock = 64 * 1024;
  std::size_t searched = begin_;
  for (;;) {
    const std::size_t end = read_.find('\n', searched);
    if (end != std::string::npos || (ended_ && begin_ < read_.size())) {
      const std::size_t size = std::min(end, read_.size()) - begin_;
      const std::string_view line(read_.data() + begin_, size);
      begin_ += std::min(size + 1, read_.size() - begin_);
      ++number_;
      if (size <= most_bytes_) return line;
    }
    if (end != std::string::npos || read_.size() - begin_ > most_bytes_) {
      throw Error("Line " + std::to_string(number_ + (end == std::string::npos ? 1 : 0)) + " of " + name_ +
                  " is longer than " + std::to_string(most_bytes_ >> 20U) + " MiB.");
    }
    if (ended_) return std::nullopt;
    read_.erase(0, begin_);
    begin_ = 0;
    searched = read_.size();
    const Pause::End end_of_wait = pause.UntilReadable(descriptor_, deadline);
    if (end_of_wait == Pause::End::kInterrupted) return std::nullopt;
    if (end_of_wait == Pause::End::kDeadline) throw TimedOut("The next line of " + name_ + " did not come in time.");
    pollfd readable{descriptor_, POLLIN, 0};
    if (poll(&readable, 1, 0) == 0) continue;  // Another thread has called Wake().
    read_.resize(searched + kBlock);
    const ssize_t count = read(descriptor_, read_.data() + searched, kBlock);
    const int error = errno;
    read_.resize(searched + static_cast<std::size_t>(count > 0 ? count : 0));
    if (count < 0 && error != EAGAIN && error != EINTR) {
      throw Error(name_ + " cannot be read: " + std::strerror(error) + ".");
    }
    ended_ = count == 0;
  }
}

}  // namespace hgros::cli
