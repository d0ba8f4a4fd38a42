#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <utility>

namespace hgros::shm {

/// An open descriptor with one owner.
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

/// Who may write what a segment holds.
enum class Access {
  kOwnerOnly,  ///< Others map it for reading; the kernel refuses them more.
  kEverybody,
};

/// A mapped piece of shared memory. Thread safety: as memory.
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

/// New shared memory: a sealed memfd that the kernel frees with its last user.
struct Segment {
  std::shared_ptr<Mapping> mapping;  ///< Null: there is none, see `fault`.
  Handle handle;                     ///< For passing on.
  std::string fault;                 ///< A sentence.
};

/// What the pages of new memory are.
enum class Pages {
  kAtOnce,   ///< All there and mapped now: running out of memory shows here and not as a signal later.
  kOnTouch,  ///< For small tables of which little may ever be used.
};

/// `size_bytes` zeroed bytes, rounded up to whole pages.
[[nodiscard]] Segment MakeSegment(const char* name, std::size_t size_bytes, Access access, Pages pages);

/// Maps what a peer has passed on. Null, and `fault` is set, unless it is a memfd that can neither shrink nor grow and
/// has at least `size_bytes`: then no access to it can fail later. Maps all of it if `size_bytes` is 0; then all its
/// pages must be there already, because reading a hole would use up memory that nobody has asked for.
[[nodiscard]] std::shared_ptr<Mapping> MapForeign(const Handle& handle, std::size_t size_bytes, bool writable,
                                                  std::string& fault);

}  // namespace hgros::shm
