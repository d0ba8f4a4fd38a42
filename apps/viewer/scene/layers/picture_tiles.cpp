#include "viewer/scene/layers/picture_tiles.hpp"

#include <algorithm>
#include <utility>

namespace hgros::viewer {
namespace {

constexpr const char* kTileVertex = R"(
uniform mat4 clip_from_eye;
uniform vec3 corner_from_eye;
uniform vec3 along_x;
uniform vec3 along_y;
out vec2 at;
void main() {
  at = vec2(gl_VertexID & 1, gl_VertexID >> 1);
  gl_Position = clip_from_eye * vec4(corner_from_eye + at.x * along_x + at.y * along_y, 1);
}
)";

constexpr const char* kTileFragment = R"(
in vec2 at;
uniform sampler2D picture;
uniform float alpha;
out vec4 result;
void main() {
  result = texture(picture, at) * alpha;
  if (result.a == 0.0) discard;  // Transparent pixels write no depth.
}
)";

}  // namespace

PictureTiles::PictureTiles(std::size_t most_pixels)
    : most_pixels_(most_pixels), program_("picture in the scene", "", kTileVertex, kTileFragment) {}

void PictureTiles::Cut(std::size_t columns, std::size_t rows) {
  GLint most = 0;
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &most);
  const std::size_t side = std::min(most_pixels_, static_cast<std::size_t>(std::max(most, 64)));
  tiles_.clear();
  for (std::size_t row = 0; row < rows; row += side) {
    for (std::size_t column = 0; column < columns; column += side) {
      Tile tile{GlTexture::New(), column, row, std::min(side, columns - column), std::min(side, rows - row)};
      glBindTexture(GL_TEXTURE_2D, tile.texture.name());
      glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, static_cast<GLsizei>(tile.columns), static_cast<GLsizei>(tile.rows), 0,
                   GL_RGBA, GL_UNSIGNED_BYTE, nullptr);
      glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_NEAREST);
      glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
      glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
      glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
      tiles_.push_back(std::move(tile));
    }
  }
  columns_ = columns;
  rows_ = rows;
}

void PictureTiles::Set(std::span<const Rgba> pixels, std::size_t columns, std::size_t rows) {
  glActiveTexture(GL_TEXTURE0);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  if (columns != columns_ || rows != rows_) Cut(columns, rows);
  glPixelStorei(GL_UNPACK_ROW_LENGTH, static_cast<GLint>(columns));
  for (const Tile& tile : tiles_) {
    const Rgba* const part = pixels.data() + tile.row * columns + tile.column;
    glBindTexture(GL_TEXTURE_2D, tile.texture.name());
    glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, static_cast<GLsizei>(tile.columns), static_cast<GLsizei>(tile.rows),
                    GL_RGBA, GL_UNSIGNED_BYTE, part);
    glGenerateMipmap(GL_TEXTURE_2D);
  }
  glPixelStorei(GL_UNPACK_ROW_LENGTH, 0);
}

void PictureTiles::Draw(const DrawContext& context, const RigidTransform& T_fixed_corner,
                        const Eigen::Vector2d& pixel_meters, float alpha, bool blended) {
  if (tiles_.empty()) return;
  const ViewMatrices& view = context.view;
  if (!corners_) corners_ = GlVertexArray::New();
  program_.Use();
  program_.Set("clip_from_eye", view.clip_from_eye);
  program_.Set("picture", 0);
  program_.Set("alpha", alpha);
  glActiveTexture(GL_TEXTURE0);
  glBindVertexArray(corners_.name());
  glEnable(GL_DEPTH_TEST);
  if (!context.true_depth) {
    glEnable(GL_POLYGON_OFFSET_FILL);  // Other things in the same plane are drawn over it.
    glPolygonOffset(blended ? 1 : 2, blended ? 4 : 8);
  }
  if (blended) {
    glEnable(GL_BLEND);
    glBlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
    glDepthMask(context.marks_depth ? GL_TRUE : GL_FALSE);
  }
  for (const Tile& tile : tiles_) {
    const Eigen::Vector3d corner(static_cast<double>(tile.column) * pixel_meters.x(),
                                 static_cast<double>(tile.row) * pixel_meters.y(), 0);
    const auto along = [&](const Eigen::Vector3d& extent) {
      return Eigen::Vector3f((T_fixed_corner.rotation * extent).cast<float>());
    };
    program_.Set("corner_from_eye", Eigen::Vector3f((T_fixed_corner * corner - view.eye).cast<float>()));
    program_.Set("along_x", along({static_cast<double>(tile.columns) * pixel_meters.x(), 0, 0}));
    program_.Set("along_y", along({0, static_cast<double>(tile.rows) * pixel_meters.y(), 0}));
    glBindTexture(GL_TEXTURE_2D, tile.texture.name());
    glDrawArrays(GL_TRIANGLE_STRIP, 0, 4);
  }
  glDisable(GL_POLYGON_OFFSET_FILL);
  glDisable(GL_BLEND);
  glDepthMask(GL_TRUE);
}

}  // namespace hgros::viewer
