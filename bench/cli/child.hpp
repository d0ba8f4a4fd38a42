#pragma once

#include <sys/types.h>

#include <cstdint>
#include <string>
#include <vector>

namespace hgros::bench {

/// Another program that runs beside the benchmark, with pipes to its standard input and output, or in a terminal of its
/// own. Killed when this object ends, and with the benchmark.
class Child {
 public:
  enum class Place { kPipes, kTerminal };
  /// The first word is the program. Throws Error if it cannot be started.
  explicit Child(std::vector<std::string> words, Place place = Place::kPipes);
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  ~Child();

  void Write(const std::string& text) const;
  /// What it writes next; empty: it has ended. Waits.
  [[nodiscard]] std::string Read();
  /// Reads until it ends. Returns everything.
  std::string ReadAll();
  /// CPU time of all its threads, in ns.
  [[nodiscard]] std::int64_t CpuTime() const;

 private:
  pid_t pid_ = -1;
  int in_ = -1;
  int out_ = -1;
};

/// Starts the program, waits for its end, and returns the time that this took in ms.
double RunTime(const std::vector<std::string>& words);

}  // namespace hgros::bench
