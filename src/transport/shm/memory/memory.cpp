#include "transport/shm/memory/memory.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#ifndef F_SEAL_FUTURE_WRITE
#define F_SEAL_FUTURE_WRITE 0x0010
#endif

namespace hgros::shm {
namespace {

constexpr int kSizeSeals = F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL;

std::size_t WholePages(std::size_t size_bytes) {
  const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  return (size_bytes + page - 1) / page * page;
}

std::string Fault(const char* what, int error) { return std::string(what) + ": " + std::strerror(error); }

std::shared_ptr<Mapping> Map(int fd, std::size_t size_bytes, bool writable, bool populate, std::string& fault) {
  const int protection = writable ? PROT_READ | PROT_WRITE : PROT_READ;
  void* begin = mmap(nullptr, size_bytes, protection, MAP_SHARED | (populate ? MAP_POPULATE : 0), fd, 0);
  if (begin == MAP_FAILED) {
    fault = Fault("it cannot be mapped", errno);
    return nullptr;
  }
  return std::make_shared<Mapping>(static_cast<std::byte*>(begin), size_bytes);
}

}  // namespace

Handle& Handle::operator=(Handle&& other) noexcept {
  if (this != &other) {
    if (fd_ >= 0) close(fd_);
    fd_ = std::exchange(other.fd_, -1);
  }
  return *this;
}

Handle::~Handle() {
  if (fd_ >= 0) close(fd_);
}

Mapping::~Mapping() { munmap(bytes_.data(), bytes_.size()); }

Segment MakeSegment(const char* name, std::size_t size_bytes, Access access, Pages pages) {
  Segment made;
  const std::size_t size = WholePages(size_bytes);
  made.handle = Handle(memfd_create(name, MFD_CLOEXEC | MFD_ALLOW_SEALING));
  const int fd = made.handle.fd();
  if (fd < 0) {
    made.fault = Fault("no memory file can be made", errno);
    return made;
  }
  if (ftruncate(fd, static_cast<off_t>(size)) != 0) {
    made.fault = Fault("its size cannot be set", errno);
    return made;
  }
  // Without this, a lack of memory would be a SIGBUS at some later write.
  if (pages == Pages::kAtOnce && fallocate(fd, 0, 0, static_cast<off_t>(size)) != 0) {
    made.fault = Fault("there is no memory for it", errno);
    return made;
  }
  made.mapping = Map(fd, size, true, pages == Pages::kAtOnce, made.fault);
  if (!made.mapping) return made;
  const bool sealed = access == Access::kOwnerOnly && fcntl(fd, F_ADD_SEALS, kSizeSeals | F_SEAL_FUTURE_WRITE) == 0;
  // Linux before 5.1 has no seal against writing. Readers map the memory for reading in any case.
  if (!sealed && fcntl(fd, F_ADD_SEALS, kSizeSeals) != 0) {
    made.fault = Fault("it cannot be sealed", errno);
    made.mapping.reset();
  }
  return made;
}

std::shared_ptr<Mapping> MapForeign(const Handle& handle, std::size_t size_bytes, bool writable, std::string& fault,
                                    bool* no_room) {
  const int seals = fcntl(handle.fd(), F_GET_SEALS);
  if (seals < 0 || (seals & (F_SEAL_SHRINK | F_SEAL_GROW)) != (F_SEAL_SHRINK | F_SEAL_GROW)) {
    fault = "it is not a memory file with a sealed size";
    return nullptr;
  }
  struct stat status {};
  if (fstat(handle.fd(), &status) != 0) {
    fault = Fault("its size cannot be read", errno);
    return nullptr;
  }
  const auto size = static_cast<std::size_t>(status.st_size);
  if (status.st_size <= 0 || size < size_bytes) {
    fault = "it has " + std::to_string(size) + " bytes instead of " + std::to_string(size_bytes);
    return nullptr;
  }
  constexpr std::size_t kBlockBytes = 512;  // The unit of st_blocks.
  if (size_bytes == 0 && static_cast<std::size_t>(status.st_blocks) < size / kBlockBytes) {
    fault = "it has holes";
    return nullptr;
  }
  auto mapping = Map(handle.fd(), size_bytes == 0 ? size : WholePages(size_bytes), writable, size_bytes == 0, fault);
  if (no_room != nullptr) *no_room = !mapping && (errno == ENOMEM || errno == EAGAIN);
  return mapping;
}

}  // namespace hgros::shm
