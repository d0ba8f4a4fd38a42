#include "viewer/scene/layers/recent_points.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "viewer/data/bounds_of_most.hpp"

namespace hgros::viewer {
namespace {

using Position = std::array<float, 3>;
constexpr std::size_t kSpareMessages = 2;
constexpr std::size_t kMostMapped = 2'000'000;  // points; larger buffers are faster in the card's own memory

}  // namespace

void RecentPoints::Add(const PointBatch& batch, const std::string& fixed_frame, const RigidTransform& T_fixed_frame,
                       double when_s) {
  Message message;
  if (!spare_.empty()) {
    message = std::move(spare_.back());
    spare_.pop_back();
  }
  message.count = batch.positions.size();
  message.has_values = !batch.scalars.empty();
  message.has_colors = !batch.colors.empty();
  message.boxes = BoxesAround(batch.positions);
  message.frame = batch.frame;
  message.stamp = batch.stamp;
  message.when_s = when_s;
  // Floats are exact near their origin, so that is where most points are.
  Eigen::Vector3f middle = Eigen::Vector3f::Zero();
  if (!message.boxes.most.isEmpty()) middle = message.boxes.most.center().cast<float>();
  const Eigen::Vector3d shift = middle.cast<double>();
  message.boxes.all.translate(-shift);
  message.boxes.most.translate(-shift);
  message.T_frame_points = batch.T_frame_points * RigidTransform({1, 0, 0, 0}, shift);
  message.fixed_frame = fixed_frame;
  message.T_fixed_points = T_fixed_frame * message.T_frame_points;
  message.placed = true;

  const bool few = points_ + message.count <= kMostMapped;
  const StreamBuffer::Way way = few ? StreamBuffer::BestWay() : StreamBuffer::Way::kCopied;
  message.points.Write<Position>(way, message.count, [&](std::span<Position> written) {
    for (std::size_t i = 0; i < written.size(); ++i) {
      const Eigen::Vector3f at = batch.positions[i] - middle;
      written[i] = {at.x(), at.y(), at.z()};
    }
  });
  if (message.has_values) {
    message.values.Write<float>(way, message.count,
                                [&](std::span<float> written) { std::ranges::copy(batch.scalars, written.begin()); });
  }
  if (message.has_colors) {
    message.colors.Write<std::uint32_t>(way, message.count, [&](std::span<std::uint32_t> written) {
      std::ranges::copy(batch.colors, written.begin());
    });
  }
  points_ += message.count;
  messages_.push_back(std::move(message));
}

bool RecentPoints::PlaceAgain(const FixedFrame& fixed, bool frame_changed, std::string& why_not) {
  bool any = false;
  for (Message& message : messages_) {
    if (message.placed && !frame_changed) continue;
    RigidTransform T_fixed_frame;
    message.placed = true;
    if (fixed.Find(message.frame, message.stamp, T_fixed_frame, why_not) == FixedFrame::Answer::kFound) {
      message.T_fixed_points = T_fixed_frame * message.T_frame_points;
    } else if (fixed.Find(message.fixed_frame, T_fixed_frame, why_not) == FixedFrame::Answer::kFound) {
      message.T_fixed_points = T_fixed_frame * message.T_fixed_points;
    } else {
      message.placed = false;
      continue;
    }
    message.fixed_frame = fixed.name();
    any = true;
  }
  if (messages_.empty() || messages_.back().placed) why_not.clear();
  return any;
}

bool RecentPoints::Expire(std::size_t messages, double oldest_s) {
  bool gone = false;
  while (!messages_.empty() && (messages_.size() > messages || messages_.front().when_s < oldest_s)) {
    points_ -= messages_.front().count;
    if (spare_.size() < kSpareMessages) {
      messages_.front().points.Retire();
      messages_.front().values.Retire();
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
    if (!message.placed || message.count <= slice.index || message.when_s > until_s) continue;
    programs.SetPlace(program, view, style, message.T_fixed_points);
    const auto attribute = [&](GLuint at, const StreamBuffer& buffer, GLint size, GLenum type, std::size_t size_bytes) {
      glBindBuffer(GL_ARRAY_BUFFER, buffer.name());
      glEnableVertexAttribArray(at);
      glVertexAttribPointer(at, size, type, GL_TRUE, static_cast<GLsizei>(slice.count * size_bytes),
                            reinterpret_cast<const void*>(slice.index * size_bytes));  // NOLINT: as GL wants it
    };
    attribute(0, message.points, 3, GL_FLOAT, sizeof(Position));
    if (message.has_values) {
      attribute(1, message.values, 1, GL_FLOAT, sizeof(float));
    } else {
      glDisableVertexAttribArray(1);
      glVertexAttrib1f(1, 0);
    }
    if (message.has_colors) {
      attribute(2, message.colors, 4, GL_UNSIGNED_BYTE, 4);
    } else {
      glDisableVertexAttribArray(2);
      glVertexAttrib4f(2, 1, 1, 1, 1);
    }
    glDrawArrays(GL_POINTS, 0, static_cast<GLsizei>((message.count - slice.index + slice.count - 1) / slice.count));
  }
}

void RecentPoints::Find(const Eigen::Vector3d& at, double until_s, NearestPoint& nearest) const {
  std::vector<Position> positions;
  for (const Message& message : messages_) {
    if (message.count == 0 || !message.placed || message.when_s > until_s) continue;
    const Eigen::Vector3d at_points = message.T_fixed_points.Inverse() * at;
    if (message.boxes.all.exteriorDistance(at_points) > nearest.distance_m) continue;
    positions.resize(message.count);
    glBindBuffer(GL_ARRAY_BUFFER, message.points.name());
    glGetBufferSubData(GL_ARRAY_BUFFER, 0, static_cast<GLsizeiptr>(message.count * sizeof(Position)), positions.data());
    std::size_t found = positions.size();
    for (std::size_t i = 0; i < positions.size(); ++i) {
      const Position& point = positions[i];
      const double distance_m = (Eigen::Vector3f(point[0], point[1], point[2]).cast<double>() - at_points).norm();
      if (distance_m > nearest.distance_m) continue;
      nearest.distance_m = distance_m;
      found = i;
    }
    if (found == positions.size()) continue;
    nearest.value.reset();
    if (!message.has_values) continue;
    nearest.value.emplace();
    glBindBuffer(GL_ARRAY_BUFFER, message.values.name());
    glGetBufferSubData(GL_ARRAY_BUFFER, static_cast<GLintptr>(found * sizeof(float)), sizeof(float), &*nearest.value);
  }
}

std::size_t RecentPoints::gpu_bytes() const noexcept {
  std::size_t bytes = 0;
  for (const Message& message : messages_) bytes += message.gpu_bytes();
  for (const Message& message : spare_) bytes += message.gpu_bytes();
  return bytes;
}

Eigen::AlignedBox3d RecentPoints::Bounds() const {
  std::vector<Eigen::AlignedBox3d> boxes;
  for (const Message& message : messages_) {
    if (message.boxes.most.isEmpty() || !message.placed) continue;
    boxes.push_back(message.boxes.most.transformed(message.T_fixed_points.Isometry()));
  }
  return BoundsOfMost(std::move(boxes));
}

double RecentPoints::oldest_s() const noexcept {
  return messages_.empty() ? std::numeric_limits<double>::infinity() : messages_.front().when_s;
}

}  // namespace hgros::viewer
