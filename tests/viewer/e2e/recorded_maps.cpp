#include "viewer/e2e/recorded_maps.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace hgros::viewer::test {
namespace {

constexpr int kLevels = 16;
constexpr int kUnknownGray = 205;

using Key = std::array<std::uint32_t, 3>;

/// Depth first: two bytes per node, two bits per child: 1 free, 2 occupied, 3 has children.
class Octree {
 public:
  explicit Octree(std::istream& file) : file_(file) { Read(0, {0, 0, 0}); }
  [[nodiscard]] const std::vector<Key>& occupied() const { return occupied_; }

 private:
  void Read(int level, const Key& corner) {
    std::array<unsigned char, 2> bytes{};
    if (!file_.read(reinterpret_cast<char*>(bytes.data()), 2)) throw std::runtime_error("The octree ends too early.");
    const unsigned children = bytes[0] | static_cast<unsigned>(bytes[1]) << 8U;
    const std::uint32_t edge = 1U << static_cast<unsigned>(kLevels - level - 1);
    for (const unsigned wanted : {2U, 3U}) {
      for (unsigned child = 0; child < 8; ++child) {
        const unsigned kind = children >> (2 * child) & 3U;
        if (kind != wanted) continue;
        const Key at = {corner[0] + (child & 1U) * edge, corner[1] + (child >> 1U & 1U) * edge,
                        corner[2] + (child >> 2U & 1U) * edge};
        if (kind == 3) {
          Read(level + 1, at);
        } else {
          Fill(at, edge);
        }
      }
    }
  }
  void Fill(const Key& corner, std::uint32_t edge) {
    for (std::uint32_t z = 0; z < edge; ++z) {
      for (std::uint32_t y = 0; y < edge; ++y) {
        for (std::uint32_t x = 0; x < edge; ++x) occupied_.push_back({corner[0] + x, corner[1] + y, corner[2] + z});
      }
    }
  }

  std::istream& file_;
  std::vector<Key> occupied_;
};

template <class Head>
void AddByteField(Head& head, const std::string& name, foxglove::PackedElementField::NumericType type) {
  auto* const field = head.add_fields();
  field->set_name(name);
  field->set_type(type);
}

}  // namespace

std::unique_ptr<Bulk<foxglove::Grid>> ReadMap(const std::filesystem::path& pgm, double cell_meters) {
  std::ifstream file(pgm, std::ios::binary);
  std::string word;
  std::array<std::size_t, 3> numbers{};
  file >> word;
  for (std::size_t i = 0; i < numbers.size();) {
    file >> std::ws;
    if (file.peek() == '#') {
      std::getline(file, word);
    } else {
      file >> numbers[i++];
    }
  }
  file.get();
  const auto [columns, rows, most] = numbers;
  std::string gray(columns * rows, '\0');
  if (!file.read(gray.data(), static_cast<std::streamsize>(gray.size()))) throw std::runtime_error("No such map.");
  auto grid = std::make_unique<Bulk<foxglove::Grid>>(gray.size());
  foxglove::Grid& head = grid->head();
  head.set_frame_id("map");
  head.set_column_count(static_cast<std::uint32_t>(columns));
  head.set_row_stride(static_cast<std::uint32_t>(columns));
  head.set_cell_stride(1);
  head.mutable_cell_size()->set_x(cell_meters);
  head.mutable_cell_size()->set_y(cell_meters);
  AddByteField(head, "occupancy", foxglove::PackedElementField::INT8);
  for (std::size_t row = 0; row < rows; ++row) {  // The picture's top row is the map's last row.
    for (std::size_t column = 0; column < columns; ++column) {
      const auto value = static_cast<unsigned char>(gray[(rows - 1 - row) * columns + column]);
      const auto occupied = static_cast<std::int8_t>(
          value == kUnknownGray ? -1
                                : std::lround(100.0 * (static_cast<double>(most) - value) / static_cast<double>(most)));
      grid->writable()[row * columns + column] = static_cast<std::byte>(occupied);
    }
  }
  return grid;
}

std::unique_ptr<Bulk<foxglove::VoxelGrid>> ReadOctree(const std::filesystem::path& bt) {
  std::ifstream file(bt, std::ios::binary);
  double cell_meters = 0;
  for (std::string line; std::getline(file, line) && line != "data";) {
    if (line.starts_with("res ")) cell_meters = std::stod(line.substr(4));
  }
  const Octree tree(file);
  Key least = tree.occupied().at(0);
  Key most = least;
  for (const Key& key : tree.occupied()) {
    for (std::size_t i = 0; i < 3; ++i) {
      least[i] = std::min(least[i], key[i]);
      most[i] = std::max(most[i], key[i]);
    }
  }
  const Key counts = {most[0] - least[0] + 1, most[1] - least[1] + 1, most[2] - least[2] + 1};
  auto grid = std::make_unique<Bulk<foxglove::VoxelGrid>>(std::size_t{counts[0]} * counts[1] * counts[2]);
  foxglove::VoxelGrid& head = grid->head();
  head.set_frame_id("map");
  const auto meters = [&](std::size_t i) { return (static_cast<double>(least[i]) - 32768) * cell_meters; };
  head.mutable_pose()->mutable_position()->set_x(meters(0));
  head.mutable_pose()->mutable_position()->set_y(meters(1));
  head.mutable_pose()->mutable_position()->set_z(meters(2));
  head.mutable_cell_size()->set_x(cell_meters);
  head.mutable_cell_size()->set_y(cell_meters);
  head.mutable_cell_size()->set_z(cell_meters);
  head.set_column_count(counts[0]);
  head.set_row_count(counts[1]);
  head.set_cell_stride(1);
  head.set_row_stride(counts[0]);
  head.set_slice_stride(counts[0] * counts[1]);
  AddByteField(head, "occupancy", foxglove::PackedElementField::UINT8);
  std::ranges::fill(grid->writable(), std::byte{0});
  for (const Key& key : tree.occupied()) {
    const std::size_t at =
        (std::size_t{key[2] - least[2]} * counts[1] + (key[1] - least[1])) * counts[0] + (key[0] - least[0]);
    grid->writable()[at] = std::byte{1};
  }
  return grid;
}

}  // namespace hgros::viewer::test
