#include "viewer/scene/layers/kept_points.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "viewer/data/bounds_of_most.hpp"
#include "viewer/data/points/cell_code.hpp"
#include "viewer/scene/gl/software_renderer.hpp"

namespace hgros::viewer {
namespace {

constexpr std::size_t kPage = PageBook::kPagePoints;

std::uint16_t To565(std::uint32_t color) {
  return static_cast<std::uint16_t>((color & 0xF8U) << 8U | (color >> 5U & 0x7E0U) | (color >> 19U & 0x1FU));
}

GlBuffer MakeBuffer(GLenum target, std::size_t size_bytes) {
  GlBuffer buffer = GlBuffer::New();
  glBindBuffer(target, buffer.name());
  glBufferData(target, static_cast<GLsizeiptr>(size_bytes), nullptr, GL_STATIC_DRAW);
  return buffer;
}

template <class T>
void Write(const GlBuffer& buffer, std::size_t first, std::span<const T> values) {
  glBindBuffer(GL_ARRAY_BUFFER, buffer.name());
  glBufferSubData(GL_ARRAY_BUFFER, static_cast<GLintptr>(first * sizeof(T)),
                  static_cast<GLsizeiptr>(values.size_bytes()), values.data());
}

/// Whether a part of a box may be visible.
bool InPicture(const Eigen::AlignedBox3d& box, const ViewMatrices& view) {
  Eigen::Vector3i below = Eigen::Vector3i::Zero();
  Eigen::Vector3i above = Eigen::Vector3i::Zero();
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3f corner =
        (box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(i)) - view.eye).cast<float>();
    const Eigen::Vector4f clip = view.clip_from_eye * corner.homogeneous();
    for (int axis = 0; axis < 3; ++axis) {
      below[axis] += clip[axis] < -clip.w() ? 1 : 0;
      above[axis] += clip[axis] > clip.w() ? 1 : 0;
    }
  }
  return below.maxCoeff() < 8 && above.maxCoeff() < 8;
}

}  // namespace

KeptPoints::KeptPoints(double cell_meters, bool with_values, bool with_colors)
    : book_(cell_meters), with_values_(with_values), with_colors_(with_colors) {}

KeptPoints::Slab KeptPoints::MakeSlab(const Eigen::Vector3d& origin) const {
  Slab slab;
  slab.origin = origin;
  slab.codes = MakeBuffer(GL_ARRAY_BUFFER, kSlabPoints * sizeof(std::uint32_t));
  if (with_values_) slab.values = MakeBuffer(GL_ARRAY_BUFFER, kSlabPoints);
  if (with_colors_) slab.colors = MakeBuffer(GL_ARRAY_BUFFER, kSlabPoints * sizeof(std::uint16_t));
  slab.pages = MakeBuffer(GL_TEXTURE_BUFFER, kSlabPages * sizeof(Eigen::Vector4f));
  slab.page_texture = GlTexture::New();
  glActiveTexture(GL_TEXTURE1);
  glBindTexture(GL_TEXTURE_BUFFER, slab.page_texture.name());
  glTexBuffer(GL_TEXTURE_BUFFER, GL_RGBA32F, slab.pages.name());
  return slab;
}

void KeptPoints::BeginPages(std::size_t first, std::span<const Eigen::Vector3d> corners) {
  std::array<std::uint32_t, kPage> empty;
  empty.fill(cell_code::kNowhere);
  const Eigen::Vector3d edge = Eigen::Vector3d::Constant(book_.cell_meters());
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const std::size_t page = first + i;
    if (page / kSlabPages == slabs_.size()) slabs_.push_back(MakeSlab(corners[i]));
    Slab& slab = slabs_[page / kSlabPages];
    const std::size_t in_slab = page % kSlabPages;
    slab.used_pages = in_slab + 1;
    slab.bounds.extend(Eigen::AlignedBox3d(corners[i], corners[i] + edge));
    Write<std::uint32_t>(slab.codes, in_slab * kPage, empty);
    Eigen::Vector4f row = Eigen::Vector4f::Zero();
    row.head<3>() = (corners[i] - slab.origin).cast<float>();
    Write<float>(slab.pages, in_slab * 4, std::span(row.data(), 4));
  }
}

void KeptPoints::Add(std::span<const Eigen::Vector3d> positions, std::span<const float> values,
                     std::span<const std::uint32_t> colors) {
  if (positions.empty()) return;
  const std::size_t first_page = book_.pages();
  const PageBook::Added added = book_.Add(positions);
  BeginPages(first_page, added.new_pages);

  AddToRegion(positions);

  std::vector<std::uint8_t> value_codes;
  if (with_values_) {
    const ValueRange before = range_;
    if (range_.Cover(values) && before.known()) Recode(before);
    value_codes.resize(positions.size());
    if (!values.empty()) {
      std::ranges::transform(added.order, value_codes.begin(),
                             [&](std::uint32_t i) { return EncodeIn(range_, values[i]); });
    }
  }
  std::vector<std::uint16_t> color_codes;
  if (with_colors_) {
    color_codes.resize(positions.size(), 0xFFFF);
    if (!colors.empty()) {
      std::ranges::transform(added.order, color_codes.begin(), [&](std::uint32_t i) { return To565(colors[i]); });
    }
  }
  for (const PageBook::Run& run : added.runs) {
    Slab& slab = slabs_[run.page / kSlabPages];
    const std::size_t first = run.page % kSlabPages * kPage + run.slot;
    Write(slab.codes, first, std::span(added.codes).subspan(run.from, run.count));
    if (with_values_)
      Write(slab.values, first, std::span<const std::uint8_t>(value_codes).subspan(run.from, run.count));
    if (with_colors_)
      Write(slab.colors, first, std::span<const std::uint16_t>(color_codes).subspan(run.from, run.count));
    slab.new_firsts.push_back(static_cast<GLint>(first));
    slab.new_counts.push_back(static_cast<GLsizei>(run.count));
  }
}

void KeptPoints::AddToRegion(std::span<const Eigen::Vector3d> positions) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& at : positions) box.extend(at);
  const auto region = std::ranges::find_if(
      regions_, [&](const Region& known) { return known.box.merged(box).sizes().maxCoeff() <= kFarFromOthersMeters; });
  if (region == regions_.end()) {
    regions_.push_back({box, 1});
  } else {
    region->box.extend(box);
    ++region->messages;
  }
  ++messages_;
}

Eigen::AlignedBox3d KeptPoints::Bounds() const {
  constexpr std::size_t kShares = 64;
  std::vector<Eigen::AlignedBox3d> boxes;
  for (const Region& region : regions_)
    boxes.insert(boxes.end(), 1 + kShares * region.messages / messages_, region.box);
  return BoundsOfMost(std::move(boxes));
}

void KeptPoints::Recode(const ValueRange& before) {
  const std::vector<std::uint8_t> code = Recoding(before, range_);
  for (Slab& slab : slabs_) {
    const std::size_t count = slab.used_pages * kPage;
    glBindBuffer(GL_ARRAY_BUFFER, slab.values.name());
    auto* const values = static_cast<std::uint8_t*>(
        glMapBufferRange(GL_ARRAY_BUFFER, 0, static_cast<GLsizeiptr>(count), GL_MAP_READ_BIT | GL_MAP_WRITE_BIT));
    if (values == nullptr) continue;  // They have the colors of the old range.
    std::transform(values, values + count, values, [&](std::uint8_t old) { return code[old]; });
    glUnmapBuffer(GL_ARRAY_BUFFER);
  }
}

void KeptPoints::Bind(PointPrograms& programs, ShaderProgram& program, const ViewMatrices& view,
                      const PointStyle& style, const Slab& slab, const Slice& slice) {
  programs.SetOrigin(program, view, style, slab.origin, range_.lo(), range_.hi());
  program.Set("stride", static_cast<int>(slice.count));
  program.Set("first", static_cast<int>(slice.index));
  glActiveTexture(GL_TEXTURE1);
  glBindTexture(GL_TEXTURE_BUFFER, slab.page_texture.name());
  const auto attribute = [&](GLuint at, const GlBuffer& buffer, GLenum type, std::size_t size_bytes, bool integer) {
    if (!buffer) {
      glDisableVertexAttribArray(at);
      return;
    }
    glBindBuffer(GL_ARRAY_BUFFER, buffer.name());
    glEnableVertexAttribArray(at);
    const auto stride = static_cast<GLsizei>(slice.count * size_bytes);
    const auto* const offset = reinterpret_cast<const void*>(slice.index * size_bytes);  // NOLINT: as GL wants it
    if (integer) {
      glVertexAttribIPointer(at, 1, type, stride, offset);
    } else {
      glVertexAttribPointer(at, 1, type, GL_TRUE, stride, offset);
    }
  };
  attribute(0, slab.codes, GL_UNSIGNED_INT, sizeof(std::uint32_t), true);
  attribute(1, slab.values, GL_UNSIGNED_BYTE, 1, false);
  attribute(2, slab.colors, GL_UNSIGNED_SHORT, sizeof(std::uint16_t), true);
}

void KeptPoints::DrawNew(PointPrograms& programs, const ViewMatrices& view, const PointStyle& style) {
  if (slabs_.empty()) return;
  if (!vertices_) vertices_ = GlVertexArray::New();
  glBindVertexArray(vertices_.name());
  ShaderProgram& program = programs.Begin(true, view, style);
  program.Set("cell", static_cast<float>(book_.cell_meters()));
  for (Slab& slab : slabs_) {
    if (slab.new_firsts.empty()) continue;
    Bind(programs, program, view, style, slab, {});
    glMultiDrawArrays(GL_POINTS, slab.new_firsts.data(), slab.new_counts.data(),
                      static_cast<GLsizei>(slab.new_firsts.size()));
    slab.new_firsts.clear();
    slab.new_counts.clear();
  }
}

void KeptPoints::Draw(PointPrograms& programs, const ViewMatrices& view, const PointStyle& style, const Slice& slice) {
  if (slabs_.empty()) return;
  if (!vertices_) vertices_ = GlVertexArray::New();
  glBindVertexArray(vertices_.name());
  ShaderProgram& program = programs.Begin(true, view, style);
  program.Set("cell", static_cast<float>(book_.cell_meters()));
  DrawnPoints waiting;
  for (Slab& slab : slabs_) {
    slab.new_firsts.clear();
    slab.new_counts.clear();
    const std::size_t points = slab.used_pages * kPage;
    if (points <= slice.index || !InPicture(slab.bounds, view)) continue;
    Bind(programs, program, view, style, slab, slice);
    const std::size_t drawn = (points - slice.index + slice.count - 1) / slice.count;
    for (std::size_t from = 0; from < drawn; from += DrawnPoints::kAtOnce) {
      const std::size_t count = std::min(DrawnPoints::kAtOnce, drawn - from);
      glDrawArrays(GL_POINTS, static_cast<GLint>(from), static_cast<GLsizei>(count));
      waiting.Count(count);
    }
  }
}

void KeptPoints::Find(const Eigen::Vector3d& at, NearestPoint& nearest) const {
  const double cell = book_.cell_meters();
  std::array<std::uint32_t, kPage> codes;
  std::array<std::uint8_t, kPage> values;
  std::vector<Eigen::Vector4f> corners;
  for (const Slab& slab : slabs_) {
    if (slab.bounds.exteriorDistance(at) > nearest.distance_m) continue;
    corners.resize(slab.used_pages);
    glBindBuffer(GL_ARRAY_BUFFER, slab.pages.name());
    glGetBufferSubData(GL_ARRAY_BUFFER, 0, static_cast<GLsizeiptr>(corners.size() * sizeof(Eigen::Vector4f)),
                       corners.data());
    for (std::size_t page = 0; page < corners.size(); ++page) {
      const Eigen::Vector3d corner = slab.origin + corners[page].head<3>().cast<double>();
      const Eigen::AlignedBox3d box(corner, corner + Eigen::Vector3d::Constant(cell));
      if (box.exteriorDistance(at) > nearest.distance_m) continue;
      glBindBuffer(GL_ARRAY_BUFFER, slab.codes.name());
      glGetBufferSubData(GL_ARRAY_BUFFER, static_cast<GLintptr>(page * sizeof codes), sizeof codes, codes.data());
      if (with_values_) {
        glBindBuffer(GL_ARRAY_BUFFER, slab.values.name());
        glGetBufferSubData(GL_ARRAY_BUFFER, static_cast<GLintptr>(page * sizeof values), sizeof values, values.data());
      }
      for (std::size_t i = 0; i < kPage; ++i) {
        if (codes[i] == cell_code::kNowhere) continue;
        const double distance_m = (corner + cell * cell_code::Decode(codes[i]) - at).norm();
        if (distance_m > nearest.distance_m) continue;
        nearest.distance_m = distance_m;
        nearest.value.reset();
        if (with_values_)
          nearest.value = range_.lo() + static_cast<float>(values[i]) / 255 * (range_.hi() - range_.lo());
      }
    }
  }
}

std::size_t KeptPoints::gpu_bytes() const noexcept {
  return slabs_.size() * (kSlabPoints * (4U + (with_values_ ? 1U : 0U) + (with_colors_ ? 2U : 0U)) + kSlabPages * 16U);
}

}  // namespace hgros::viewer
