#include "viewer/scene/layers/recent_points.hpp"

#include <algorithm>
#include <utility>

#include "viewer/data/bounds_of_most.hpp"

namespace hgros::viewer {
namespace {

constexpr std::size_t kSpareMessages = 2;
constexpr std::size_t kMostMapped = 2'000'000;  // points; larger buffers are faster in the card's own memory

}  // namespace

void RecentPoints::Add(const PlacedPoints& positions, std::span<const float> values,
                       std::span<const std::uint32_t> colors, double when_s) {
  Message message;
  if (!spare_.empty()) {
    message = std::move(spare_.back());
    spare_.pop_back();
  }
  message.count = positions.size();
  message.has_values = !values.empty();
  message.has_colors = !colors.empty();
  message.box = BoxAround(positions, values);
  message.when_s = when_s;
  const bool few = points_ + message.count <= kMostMapped;
  const StreamBuffer::Way way = few ? StreamBuffer::BestWay() : StreamBuffer::Way::kCopied;
  message.points.Write<PackedPoint>(
      way, message.count, [&](std::span<PackedPoint> packed) { Pack(positions, values, message.box, packed); });
  if (message.has_colors) {
    message.colors.Write<std::uint32_t>(
        way, colors.size(), [&](std::span<std::uint32_t> written) { std::ranges::copy(colors, written.begin()); });
  }
  points_ += message.count;
  messages_.push_back(std::move(message));
}

bool RecentPoints::Expire(std::size_t messages, double oldest_s) {
  bool gone = false;
  while (!messages_.empty() && (messages_.size() > messages || messages_.front().when_s < oldest_s)) {
    points_ -= messages_.front().count;
    if (spare_.size() < kSpareMessages) {
      messages_.front().points.Retire();
      messages_.front().colors.Retire();
      spare_.push_back(std::move(messages_.front()));
    }
    messages_.pop_front();
    gone = true;
  }
  return gone;
}

void RecentPoints::Clear() {
  messages_.clear();
  spare_.clear();
  points_ = 0;
}

void RecentPoints::Draw(PointPrograms& programs, const ViewMatrices& view, const PointStyle& style, const Slice& slice,
                        double until_s) {
  if (points_ == 0) return;
  if (!vertices_) vertices_ = GlVertexArray::New();
  glBindVertexArray(vertices_.name());
  ShaderProgram& program = programs.Begin(false, view, style);
  for (const Message& message : messages_) {
    if (message.count <= slice.index || message.when_s > until_s) continue;
    programs.SetOrigin(program, view, style, message.box.corner, message.box.scalar_lo, message.box.scalar_hi);
    program.Set("box", message.box.size);
    const auto attribute = [&](GLuint at, const StreamBuffer& buffer, GLenum type, std::size_t size_bytes) {
      glBindBuffer(GL_ARRAY_BUFFER, buffer.name());
      glEnableVertexAttribArray(at);
      glVertexAttribPointer(at, 4, type, GL_TRUE, static_cast<GLsizei>(slice.count * size_bytes),
                            reinterpret_cast<const void*>(slice.index * size_bytes));  // NOLINT: as GL wants it
    };
    attribute(0, message.points, GL_UNSIGNED_SHORT, 8);
    if (message.has_colors) {
      attribute(2, message.colors, GL_UNSIGNED_BYTE, 4);
    } else {
      glDisableVertexAttribArray(2);
      glVertexAttrib4f(2, 1, 1, 1, 1);
    }
    glDrawArrays(GL_POINTS, 0, static_cast<GLsizei>((message.count - slice.index + slice.count - 1) / slice.count));
  }
}

void RecentPoints::Find(const Eigen::Vector3d& at, double until_s, NearestPoint& nearest) const {
  std::vector<PackedPoint> codes;
  for (const Message& message : messages_) {
    const Eigen::AlignedBox3d box(message.box.corner, message.box.corner + message.box.size.cast<double>());
    if (message.count == 0 || message.when_s > until_s || box.exteriorDistance(at) > nearest.distance_m) continue;
    codes.resize(message.count);
    glBindBuffer(GL_ARRAY_BUFFER, message.points.name());
    glGetBufferSubData(GL_ARRAY_BUFFER, 0, static_cast<GLsizeiptr>(8 * message.count), codes.data());
    const Eigen::Vector3d step = message.box.size.cast<double>() / 65535;
    for (const PackedPoint& code : codes) {
      const Eigen::Vector3d point = message.box.corner + step.cwiseProduct(Eigen::Vector3d(code[0], code[1], code[2]));
      const double distance_m = (point - at).norm();
      if (distance_m > nearest.distance_m) continue;
      nearest.distance_m = distance_m;
      nearest.value.reset();
      if (!message.has_values) continue;
      nearest.value =
          message.box.scalar_lo + static_cast<float>(code[3]) / 65535 * (message.box.scalar_hi - message.box.scalar_lo);
    }
  }
}

std::size_t RecentPoints::gpu_bytes() const noexcept {
  std::size_t bytes = 0;
  for (const Message& message : messages_) bytes += message.points.capacity_bytes() + message.colors.capacity_bytes();
  for (const Message& message : spare_) bytes += message.points.capacity_bytes() + message.colors.capacity_bytes();
  return bytes;
}

Eigen::AlignedBox3d RecentPoints::Bounds() const {
  std::vector<Eigen::AlignedBox3d> boxes;
  for (const Message& message : messages_) {
    if (message.count == 0) continue;
    boxes.emplace_back(message.box.corner, message.box.corner + message.box.size.cast<double>());
  }
  return BoundsOfMost(std::move(boxes));
}

double RecentPoints::oldest_s() const noexcept {
  return messages_.empty() ? std::numeric_limits<double>::infinity() : messages_.front().when_s;
}

}  // namespace hgros::viewer
