// The layout of the file and of its notes: elf(5).
#include "remote/library_build.hpp"

#include <elf.h>
#include <link.h>
#include <string.h>

#include <algorithm>
#include <fstream>
#include <string_view>

#include "hgros/base/error.hpp"

namespace hgros::cli {
namespace {

constexpr std::size_t kMostNoteBytes = 1U << 20U;

template <class T>
bool ReadAt(std::ifstream& file, std::uint64_t offset, T& value) {
  file.clear();
  file.seekg(static_cast<std::streamoff>(offset));
  return static_cast<bool>(file.read(reinterpret_cast<char*>(&value), sizeof value));
}

std::string InHex(std::string_view bytes) {
  std::string text;
  for (const char one : bytes) {
    const auto byte = static_cast<unsigned char>(one);
    for (const unsigned digit : {byte / 16U, byte % 16U}) text += "0123456789abcdef"[digit];
  }
  return text;
}

// The build id among the notes; empty: none of them.
std::string IdIn(std::string_view notes) {
  const auto padded = [](std::size_t size) { return (size + 3) / 4 * 4; };
  while (notes.size() >= sizeof(ElfW(Nhdr))) {
    ElfW(Nhdr) head;
    memcpy(&head, notes.data(), sizeof head);
    notes.remove_prefix(sizeof head);
    const std::size_t name = padded(head.n_namesz);
    if (name > notes.size() || head.n_descsz > notes.size() - name) return {};
    const std::string_view id = notes.substr(name, head.n_descsz);
    if (head.n_type == NT_GNU_BUILD_ID && notes.starts_with(std::string_view("GNU\0", 4))) return InHex(id);
    notes.remove_prefix(std::min(notes.size(), name + padded(head.n_descsz)));
  }
  return {};
}

}  // namespace

LibraryBuild BuildOf(const std::filesystem::path& library) {
  std::ifstream file(library, std::ios::binary);
  ElfW(Ehdr) head;
  if (!ReadAt(file, 0, head) || memcmp(head.e_ident, ELFMAG, SELFMAG) != 0) {
    throw Error("The library " + library.string() + " cannot be read.");
  }
  LibraryBuild build;
  build.machine = head.e_machine;
  for (std::uint64_t i = 0; i < head.e_phnum && build.id.empty(); ++i) {
    ElfW(Phdr) segment;
    if (!ReadAt(file, head.e_phoff + i * head.e_phentsize, segment)) break;
    if (segment.p_type != PT_NOTE || segment.p_filesz > kMostNoteBytes) continue;
    std::string notes(segment.p_filesz, '\0');
    file.seekg(static_cast<std::streamoff>(segment.p_offset));
    if (file.read(notes.data(), static_cast<std::streamsize>(notes.size()))) build.id = IdIn(notes);
  }
  return build;
}

}  // namespace hgros::cli
