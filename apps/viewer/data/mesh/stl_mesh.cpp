#include "viewer/data/mesh/stl_mesh.hpp"

#include <charconv>
#include <cstdint>
#include <cstring>
#include <utility>

namespace hgros::viewer {
namespace {

// 80 unused bytes, the number of triangles, and for each triangle a normal, three corners and two unused bytes.
constexpr std::size_t kHeadBytes = 84;
constexpr std::size_t kTriangleBytes = 50;
constexpr std::size_t kNormalBytes = 12;
constexpr std::size_t kCornerBytes = 12;

std::string ReadBinary(Bytes file, std::vector<Eigen::Vector3f>& corners) {
  if (file.size() < kHeadBytes) return "The STL file ends before its first triangle.";
  std::uint32_t count = 0;
  std::memcpy(&count, file.data() + kHeadBytes - sizeof count, sizeof count);
  if (count > (file.size() - kHeadBytes) / kTriangleBytes) {
    return "The STL file announces " + std::to_string(count) + " triangles, but ends before the last.";
  }
  corners.reserve(std::size_t{3} * count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::byte* const triangle = file.data() + kHeadBytes + i * kTriangleBytes + kNormalBytes;
    for (std::size_t k = 0; k < 3; ++k) {
      std::memcpy(corners.emplace_back().data(), triangle + k * kCornerBytes, kCornerBytes);
    }
  }
  return {};
}

std::string_view NextWord(std::string_view& text) {
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  if (first == std::string_view::npos) {
    text = {};
    return {};
  }
  text.remove_prefix(first);
  const std::string_view word = text.substr(0, text.find_first_of(" \t\r\n"));
  text.remove_prefix(word.size());
  return word;
}

std::string ReadText(std::string_view text, std::vector<Eigen::Vector3f>& corners) {
  for (std::string_view word = NextWord(text); !word.empty(); word = NextWord(text)) {
    if (word != "vertex") continue;
    Eigen::Vector3f& corner = corners.emplace_back();
    for (int i = 0; i < 3; ++i) {
      const std::string_view number = NextWord(text);
      const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), corner[i]);
      if (error != std::errc() || end != number.data() + number.size()) {
        return "The STL file has \"" + std::string(number.substr(0, 40)) + "\" instead of a number.";
      }
    }
  }
  if (corners.size() % 3 != 0) return "The STL file ends in the middle of a triangle.";
  if (corners.empty()) return "The STL file has no triangles.";
  return {};
}

// Binary files may begin with "solid" as well. Their size shows that they are binary.
bool IsText(Bytes file) {
  if (!AsText(file).starts_with("solid")) return false;
  if (file.size() < kHeadBytes) return true;
  std::uint32_t count = 0;
  std::memcpy(&count, file.data() + kHeadBytes - sizeof count, sizeof count);
  return file.size() != kHeadBytes + std::size_t{count} * kTriangleBytes;
}

}  // namespace

std::string ReadStl(Bytes file, std::vector<Eigen::Vector3f>& corners) {
  std::vector<Eigen::Vector3f> read;
  std::string fault = IsText(file) ? ReadText(AsText(file), read) : ReadBinary(file, read);
  if (!fault.empty()) return fault;
  for (const Eigen::Vector3f& corner : read) {
    if (!corner.allFinite()) return "The STL file has corners that are not numbers.";
  }
  corners = std::move(read);
  return {};
}

}  // namespace hgros::viewer
