#pragma once

#include <epoxy/gl.h>

#include <Eigen/Core>
#include <map>
#include <string>
#include <string_view>

namespace hgros::viewer {

/// A vertex and a fragment shader, with a geometry shader between them if there is one, compiled when they are first
/// used. GLSL 3.30; the version line is added.
class ShaderProgram {
 public:
  /// `name` is for errors; `preamble` goes before all sources, for definitions that make variants.
  ShaderProgram(std::string name, std::string preamble, std::string vertex, std::string fragment,
                std::string geometry = {});
  ShaderProgram(const ShaderProgram&) = delete;
  ShaderProgram& operator=(const ShaderProgram&) = delete;
  ~ShaderProgram();

  /// Errors: throws Error with the driver's words if it does not compile.
  void Use();

  // After Use(). Names that the driver has optimised away are left out.
  void Set(std::string_view uniform, float value);
  void Set(std::string_view uniform, int value);
  void Set(std::string_view uniform, const Eigen::Vector2f& value);
  void Set(std::string_view uniform, const Eigen::Vector3f& value);
  void Set(std::string_view uniform, const Eigen::Vector4f& value);
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
