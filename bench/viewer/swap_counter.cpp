// Preloaded into a program that reports no frame rate. Counts the frames that it presents, in the file HGROS_SWAPS.
// The file holds two 64 bit numbers: the number of frames, and the time of the first one (CLOCK_MONOTONIC, ns).
#include <dlfcn.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <time.h>
#include <unistd.h>

#include <atomic>
#include <cstdint>
#include <cstdlib>

namespace {

struct Counts {
  std::atomic<std::uint64_t> frames;
  std::atomic<std::uint64_t> first_ns;
};

Counts* Open() {
  const char* const path = std::getenv("HGROS_SWAPS");
  const int file = path == nullptr ? -1 : open(path, O_RDWR | O_CLOEXEC);
  if (file < 0) return nullptr;
  void* const memory = mmap(nullptr, sizeof(Counts), PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  close(file);
  return memory == MAP_FAILED ? nullptr : static_cast<Counts*>(memory);
}

}  // namespace

// Name and arguments are GLX's.
extern "C" __attribute__((visibility("default"))) void glXSwapBuffers(void* display, unsigned long drawable) {
  static Counts* const counts = Open();
  static const auto real = reinterpret_cast<void (*)(void*, unsigned long)>(dlsym(RTLD_NEXT, "glXSwapBuffers"));
  real(display, drawable);
  if (counts == nullptr) return;
  if (counts->frames.fetch_add(1) > 0) return;
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  counts->first_ns = static_cast<std::uint64_t>(now.tv_sec) * 1'000'000'000U + static_cast<std::uint64_t>(now.tv_nsec);
}
