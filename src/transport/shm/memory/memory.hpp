#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <utility>

namespace hgros::shm {

/// An open file descriptor with one owner.
class Handle {
 public:
  Handle() = default;
  explicit Handle(int fd) noexcept : fd_(fd) {}
  Handle(Handle&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Handle& operator=(Handle&& other) noexcept;
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  ~Handle();

  [[nodiscard]] int fd() const noexcept { return fd_; }
  [[nodiscard]] bool valid() const noexcept { return fd_ >= 0; }

 private:
  int fd_ = -1;
};

/// Which processes may write to a segment.
enum class Access {
  kOwnerOnly,  ///< Others map it for reading; the kernel refuses anything else.
  kEverybody,
};

/// A mapped piece of shared memory. Thread safety: that of plain memory.
class Mapping {
 public:
  Mapping(std::byte* begin, std::size_t size_bytes) noexcept : bytes_(begin, size_bytes) {}
  ~Mapping();
  Mapping(const Mapping&) = delete;
  Mapping& operator=(const Mapping&) = delete;

  [[nodiscard]] std::span<std::byte> bytes() const noexcept { return bytes_; }
  template <class Page>
  [[nodiscard]] Page& as() const noexcept {
    return *reinterpret_cast<Page*>(bytes_.data());
  }

 private:
  std::span<std::byte> bytes_;
};

/// New shared memory: a sealed memfd, which the kernel frees after its last user.
struct Segment {
  std::shared_ptr<Mapping> mapping;  ///< Null if there is none: see `fault`.
  Handle handle;                     ///< To send it to peers.
  std::string fault;                 ///< A sentence.
};

/// When the pages of new memory are made.
enum class Pages {
  kAtOnce,   ///< Now: a lack of memory is an error here, not a signal later.
  kOnTouch,  ///< At first use: for tables that may stay mostly unused.
};

/// `size_bytes` zeroed bytes, rounded up to whole pages.
[[nodiscard]] Segment MakeSegment(const char* name, std::size_t size_bytes, Access access, Pages pages);

/// Maps memory that a peer has sent. It must be a memfd that can neither shrink nor grow and has at least
/// `size_bytes`, so that no access can fail later. Otherwise null, and `fault` is set. If `size_bytes` is 0, all of
/// it is mapped, and all its pages must exist: reading a hole would allocate memory. Sets `no_room` if the memory is
/// right, and this process has no room for it.
[[nodiscard]] std::shared_ptr<Mapping> MapForeign(const Handle& handle, std::size_t size_bytes, bool writable,
                                                  std::string& fault, bool* no_room = nullptr);

}  // namespace hgros::shm
