#pragma once

#include <sys/prctl.h>

#include <csignal>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <map>
#include <mutex>
#include <string>
#include <string_view>

namespace hgros::resilience {

/// The arguments of a worker: "--name=value".
class Arguments {
 public:
  Arguments(int count, char** texts) {
    for (int i = 1; i < count; ++i) {
      const std::string_view text = texts[i];
      const std::size_t equals = text.find('=');
      values_.emplace(text.substr(2, equals - 2), text.substr(equals + 1));
    }
  }
  [[nodiscard]] std::string Text(const std::string& name) const {
    const auto found = values_.find(name);
    return found == values_.end() ? std::string() : found->second;
  }
  [[nodiscard]] std::uint64_t Number(const std::string& name, std::uint64_t otherwise = 0) const {
    const std::string text = Text(name);
    return text.empty() ? otherwise : std::stoull(text);
  }

 private:
  std::map<std::string, std::string> values_;
};

/// Writes a line to standard output.
inline void Say(const std::string& line) {
  static std::mutex writing;
  const std::scoped_lock lock(writing);
  (void)std::printf("%s\n", line.c_str());
  (void)std::fflush(stdout);
}

/// Calls `run` with the arguments and SIGTERM, which is blocked. The worker is killed when its parent ends.
template <class Run>
int RunWorker(int count, char** texts, const Run& run) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  sigset_t end;
  sigemptyset(&end);
  sigaddset(&end, SIGTERM);
  sigprocmask(SIG_BLOCK, &end, nullptr);
  try {
    return run(Arguments(count, texts), end);
  } catch (const std::exception& error) {
    Say(std::string("log ") + error.what());
    return 1;
  }
}

}  // namespace hgros::resilience
