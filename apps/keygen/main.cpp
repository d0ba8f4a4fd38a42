// Makes a CURVE key pair: the secret key goes into a file that only its owner can read, the public key to standard
// output, ready for `network: security:`.
#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <string>

#include "hgros/base/error.hpp"
#include "hgros/transport/curve_key_pair.hpp"

namespace {

constexpr const char* kUsage =
    "usage: hgros-keygen FILE\n"
    "Writes a new secret key to FILE, which must not exist yet, and prints the public key that belongs to it.\n";

int Fail(const std::string& file) {
  std::fprintf(stderr, "hgros-keygen: %s cannot be written: %s.\n", file.c_str(), std::strerror(errno));
  return 1;
}

int Run(const std::string& file) {
  const hgros::CurveKeyPair keys = hgros::GenerateCurveKeyPair();
  const int descriptor = open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (descriptor < 0) return Fail(file);
  const std::string line = keys.secret_key + "\n";
  const bool written = write(descriptor, line.data(), line.size()) == static_cast<ssize_t>(line.size());
  if (close(descriptor) != 0 || !written) return Fail(file);
  std::printf("%s\n", keys.public_key.c_str());
  std::fprintf(stderr,
               "Put this into the configuration of this session:\n"
               "  network: {security: {public_key: \"%s\", secret_key_file: %s}}\n"
               "and the public key into the allowed_clients or servers of the other sessions.\n",
               keys.public_key.c_str(), file.c_str());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
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
