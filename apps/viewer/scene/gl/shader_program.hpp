#pragma once

#include <epoxy/gl.h>

#include <Eigen/Core>
#include <map>
#include <string>
#include <string_view>

namespace hgros::viewer {

/// A vertex shader, a fragment shader, and optionally a geometry shader, compiled on first use. GLSL 3.30; the version
/// line is added.
class ShaderProgram {
 public:
  /// `name` is for errors. `preamble` is put before all sources: definitions that select a variant.
  ShaderProgram(std::string name, std::string preamble, std::string vertex, std::string fragment,
                std::string geometry = {});
  ShaderProgram(const ShaderProgram&) = delete;
  ShaderProgram& operator=(const ShaderProgram&) = delete;
  ~ShaderProgram();

  /// Errors: throws Error with the driver's message if it does not compile.
  void Use();

  // Call it after Use(). Names that the driver has optimized away are ignored.
  void Set(std::string_view uniform, float value);
  void Set(std::string_view uniform, int value);
  void Set(std::string_view uniform, const Eigen::Vector2f& value);
  void Set(std::string_view uniform, const Eigen::Vector3f& value);
  void Set(std::string_view uniform, const Eigen::Vector4f& value);
  void Set(std::string_view uniform, const Eigen::Matrix3f& value);
  void Set(std::string_view uniform, const Eigen::Matrix4f& value);

 private:
  [[nodiscard]] GLint Location(std::string_view uniform);

  std::string name_;
  std::string preamble_;
  std::string vertex_;
  std::string fragment_;
  std::string geometry_;
  GLuint program_ = 0;
  std::map<std::string, GLint, std::less<>> locations_;
};

}  // namespace hgros::viewer
