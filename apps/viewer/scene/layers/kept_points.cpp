#include "viewer/scene/layers/kept_points.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "viewer/data/bounds_of_most.hpp"
#include "viewer/data/points/cell_code.hpp"
#include "viewer/data/points/point_boxes.hpp"
#include "viewer/data/value_range.hpp"
#include "viewer/scene/gl/software_renderer.hpp"

namespace hgros::viewer {
namespace {

constexpr std::size_t kPage = PageBook::kPagePoints;
constexpr std::size_t kMostRanges = 16;  // each has pages that are not full

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
bool InPicture(const Eigen::AlignedBox3d& box, const RigidTransform& T_fixed_box, const ViewMatrices& view) {
  Eigen::Vector3i below = Eigen::Vector3i::Zero();
  Eigen::Vector3i above = Eigen::Vector3i::Zero();
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3f corner =
        (T_fixed_box * box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(i)) - view.eye).cast<float>();
    const Eigen::Vector4f clip = view.clip_from_eye * corner.homogeneous();
    for (int axis = 0; axis < 3; ++axis) {
      below[axis] += clip[axis] < -clip.w() ? 1 : 0;
      above[axis] += clip[axis] > clip.w() ? 1 : 0;
    }
  }
  return below.maxCoeff() < 8 && above.maxCoeff() < 8;
}

}  // namespace

KeptPoints::KeptPoints(std::string frame, bool with_values, bool with_colors)
    : frame_(std::move(frame)), with_values_(with_values), with_colors_(with_colors) {}

bool KeptPoints::PlaceAgain(const FixedFrame& fixed, bool frame_changed, std::string& why_not) {
  if (fixed_from_kept_ && !frame_changed) return false;
  RigidTransform T_fixed_kept;
  fixed_from_kept_.reset();
  if (fixed.Find(frame_, T_fixed_kept, why_not) == FixedFrame::Answer::kFound) fixed_from_kept_ = T_fixed_kept;
  return fixed_from_kept_.has_value();
}

KeptPoints::Slab KeptPoints::MakeSlab(const Eigen::Vector3d& origin) const {
  Slab slab;
  slab.origin = origin;
  slab.codes = MakeBuffer(GL_ARRAY_BUFFER, kSlabPoints * sizeof(std::uint32_t));
  if (with_values_) slab.values = MakeBuffer(GL_ARRAY_BUFFER, kSlabPoints);
  if (with_colors_) slab.colors = MakeBuffer(GL_ARRAY_BUFFER, kSlabPoints * sizeof(std::uint16_t));
  slab.pages = MakeBuffer(GL_TEXTURE_BUFFER, kSlabPages * sizeof(PageRow));
  slab.page_texture = GlTexture::New();
  glActiveTexture(GL_TEXTURE1);
  glBindTexture(GL_TEXTURE_BUFFER, slab.page_texture.name());
  glTexBuffer(GL_TEXTURE_BUFFER, GL_RGBA32F, slab.pages.name());
  return slab;
}

void KeptPoints::BeginPages(std::size_t first, std::span<const PageBook::Page> pages, const Range& range,
                            const Eigen::Vector3d& middle) {
  std::array<std::uint32_t, kPage> empty;
  empty.fill(cell_code::kNowhere);
  for (std::size_t i = 0; i < pages.size(); ++i) {
    const auto& [at, edge_meters] = pages[i];
    const std::size_t page = first + i;
    if (page / kSlabPages == slabs_.size()) slabs_.push_back(MakeSlab(middle));
    Slab& slab = slabs_[page / kSlabPages];
    const std::size_t in_slab = page % kSlabPages;
    slab.used_pages = in_slab + 1;
    slab.bounds.extend(Eigen::AlignedBox3d(at, at + Eigen::Vector3d::Constant(edge_meters)));
    Write<std::uint32_t>(slab.codes, in_slab * kPage, empty);
    const Eigen::Vector3f corner = (at - slab.origin).cast<float>();
    const PageRow row = {corner.x(),   corner.y(),    corner.z(), static_cast<float>(edge_meters),
                         range.lowest, range.highest, 0,          0};
    Write<float>(slab.pages, in_slab * row.size(), row);
  }
}

void KeptPoints::Add(std::span<const Eigen::Vector3d> positions, std::span<const float> values,
                     std::span<const std::uint32_t> colors) {
  if (positions.empty()) return;
  const Eigen::AlignedBox3d box = BoxesAround(positions).most;
  const std::size_t kind = with_values_ ? RangeFor(values) : 0;
  const Range range = with_values_ ? ranges_[kind] : Range();
  const std::size_t first_page = book_.pages();
  const PageBook::Added added = book_.Add(positions, box, kind);
  BeginPages(first_page, added.new_pages, range, box.center());
  AddToRegion(box);

  std::vector<std::uint8_t> value_codes;
  if (with_values_) {
    value_codes.resize(positions.size());
    if (!values.empty()) {
      std::ranges::transform(added.order, value_codes.begin(),
                             [&](std::uint32_t i) { return EncodeIn(range.lowest, range.highest, values[i]); });
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

std::size_t KeptPoints::RangeFor(std::span<const float> values) {
  ValueRange own;
  if (!own.Cover(values) && !ranges_.empty()) return 0;  // None is a number.
  const float spread = own.hi() - own.lo();
  const auto suits = [&](const Range& range) {
    return range.lowest <= own.lo() && own.hi() <= range.highest && range.highest - range.lowest <= 4 * spread;
  };
  if (const auto found = std::ranges::find_if(ranges_, suits); found != ranges_.end()) {
    return static_cast<std::size_t>(found - ranges_.begin());
  }
  const float margin = ranges_.empty() ? 0 : spread / 4;  // Values that changed once will change again.
  if (ranges_.size() == kMostRanges) {
    ranges_.clear();
    book_.ClosePages();
  }
  ranges_.push_back({own.lo() - margin, own.hi() + margin});
  return ranges_.size() - 1;
}

void KeptPoints::AddToRegion(const Eigen::AlignedBox3d& box) {
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
  if (!fixed_from_kept_) return {};
  constexpr std::size_t kShares = 64;
  std::vector<Eigen::AlignedBox3d> boxes;
  for (const Region& region : regions_)
    boxes.insert(boxes.end(), 1 + kShares * region.messages / messages_, region.box);
  const Eigen::AlignedBox3d bounds = BoundsOfMost(std::move(boxes));
  return bounds.isEmpty() ? bounds : bounds.transformed(fixed_from_kept_->Isometry());
}

void KeptPoints::Bind(PointPrograms& programs, ShaderProgram& program, const ViewMatrices& view,
                      const PointStyle& style, const Slab& slab, const Slice& slice) {
  programs.SetPlace(program, view, style, *fixed_from_kept_ * RigidTransform({1, 0, 0, 0}, slab.origin));
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
  if (slabs_.empty() || !fixed_from_kept_) return;
  if (!vertices_) vertices_ = GlVertexArray::New();
  glBindVertexArray(vertices_.name());
  ShaderProgram& program = programs.Begin(true, view, style);
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
  if (slabs_.empty() || !fixed_from_kept_) return;
  if (!vertices_) vertices_ = GlVertexArray::New();
  glBindVertexArray(vertices_.name());
  ShaderProgram& program = programs.Begin(true, view, style);
  DrawnPoints waiting;
  for (Slab& slab : slabs_) {
    slab.new_firsts.clear();
    slab.new_counts.clear();
    const std::size_t points = slab.used_pages * kPage;
    if (points <= slice.index || !InPicture(slab.bounds, *fixed_from_kept_, view)) continue;
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
  if (!fixed_from_kept_) return;
  const Eigen::Vector3d at_kept = fixed_from_kept_->Inverse() * at;
  std::array<std::uint32_t, kPage> codes;
  std::array<std::uint8_t, kPage> values;
  std::vector<PageRow> rows;
  for (const Slab& slab : slabs_) {
    if (slab.bounds.exteriorDistance(at_kept) > nearest.distance_m) continue;
    rows.resize(slab.used_pages);
    glBindBuffer(GL_ARRAY_BUFFER, slab.pages.name());
    glGetBufferSubData(GL_ARRAY_BUFFER, 0, static_cast<GLsizeiptr>(rows.size() * sizeof(PageRow)), rows.data());
    for (std::size_t page = 0; page < rows.size(); ++page) {
      const auto& [x, y, z, edge, lowest, highest, unused_1, unused_2] = rows[page];
      const Eigen::Vector3d corner = slab.origin + Eigen::Vector3f(x, y, z).cast<double>();
      const auto cell = static_cast<double>(edge);
      const Eigen::AlignedBox3d box(corner, corner + Eigen::Vector3d::Constant(cell));
      if (box.exteriorDistance(at_kept) > nearest.distance_m) continue;
      glBindBuffer(GL_ARRAY_BUFFER, slab.codes.name());
      glGetBufferSubData(GL_ARRAY_BUFFER, static_cast<GLintptr>(page * sizeof codes), sizeof codes, codes.data());
      if (with_values_) {
        glBindBuffer(GL_ARRAY_BUFFER, slab.values.name());
        glGetBufferSubData(GL_ARRAY_BUFFER, static_cast<GLintptr>(page * sizeof values), sizeof values, values.data());
      }
      for (std::size_t i = 0; i < kPage; ++i) {
        if (codes[i] == cell_code::kNowhere) continue;
        const double distance_m = (corner + cell * cell_code::Decode(codes[i]) - at_kept).norm();
        if (distance_m > nearest.distance_m) continue;
        nearest.distance_m = distance_m;
        nearest.value.reset();
        if (with_values_) nearest.value = lowest + static_cast<float>(values[i]) / 255 * (highest - lowest);
      }
    }
  }
}

std::size_t KeptPoints::gpu_bytes() const noexcept {
  return slabs_.size() *
         (kSlabPoints * (4U + (with_values_ ? 1U : 0U) + (with_colors_ ? 2U : 0U)) + kSlabPages * sizeof(PageRow));
}

}  // namespace hgros::viewer
