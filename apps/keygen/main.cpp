// Makes a CURVE key pair: the secret key goes into a file that only its owner can read, the public key to standard
// output, ready for `network: security:`.
#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <string>

#include "hgros/base/error.hpp"
#include "hgros/transport/curve_key_pair.hpp"

namespace {

constexpr const char* kUsage =
    "usage: hgros-keygen FILE\n"
    "Writes a new secret key to FILE, which must not exist yet, and prints the public key that belongs to it.\n";

int Fail(const std::string& what, int error) {
  std::fprintf(stderr, "hgros-keygen: %s cannot be written: %s.\n", what.c_str(), std::strerror(error));
  return 1;
}

// A file with a part of a key, or with one whose public key nobody knows, is of no use.
int FailWithout(const std::string& file, const std::string& what, int error) {
  (void)unlink(file.c_str());
  return Fail(what, error);
}

int Run(const std::string& file) {
  const hgros::CurveKeyPair keys = hgros::GenerateCurveKeyPair();
  const int descriptor = open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (descriptor < 0) return Fail(file, errno);
  const std::string line = keys.secret_key + "\n";
  errno = ENOSPC;  // If only a part is written.
  bool written = write(descriptor, line.data(), line.size()) == static_cast<ssize_t>(line.size());
  written = written && (fsync(descriptor) == 0 || errno == EINVAL);
  const int error = errno;
  if (close(descriptor) != 0 || !written) return FailWithout(file, file, error);
  if (std::printf("%s\n", keys.public_key.c_str()) < 0 || std::fflush(stdout) != 0) {
    return FailWithout(file, "Standard output", errno);
  }
  std::fprintf(stderr,
               "Put this into the configuration of this session:\n"
               "  network: {security: {public_key: \"%s\", secret_key_file: %s}}\n"
               "and the public key into the allowed_clients or servers of the other sessions.\n",
               keys.public_key.c_str(), file.c_str());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  (void)std::signal(SIGPIPE, SIG_IGN);  // Writing fails instead.
  if (argc != 2 || argv[1][0] == '-') {
    const bool help = argc == 2 && (std::strcmp(argv[1], "--help") == 0 || std::strcmp(argv[1], "-h") == 0);
    std::fputs(kUsage, help ? stdout : stderr);
    return help ? 0 : 2;
  }
  try {
    return Run(argv[1]);
  } catch (const hgros::Error& error) {
    std::fprintf(stderr, "hgros-keygen: %s\n", error.what());
    return 1;
  }
}
