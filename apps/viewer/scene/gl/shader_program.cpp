#include "viewer/scene/gl/shader_program.hpp"

#include <array>
#include <utility>

#include "hgros/base/error.hpp"

namespace hgros::viewer {
namespace {

GLuint Compile(GLenum kind, const std::string& name, const std::string& preamble, const std::string& source) {
  const GLuint shader = glCreateShader(kind);
  const std::array<const char*, 3> parts = {"#version 330 core\n", preamble.c_str(), source.c_str()};
  glShaderSource(shader, static_cast<GLsizei>(parts.size()), parts.data(), nullptr);
  glCompileShader(shader);
  GLint compiled = 0;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
  if (compiled == 0) {
    std::string log(2048, '\0');
    GLsizei length = 0;
    glGetShaderInfoLog(shader, static_cast<GLsizei>(log.size()), &length, log.data());
    glDeleteShader(shader);
    log.resize(static_cast<std::size_t>(length));
    throw Error("The shader \"" + name + "\" does not compile on this driver: " + log);
  }
  return shader;
}

}  // namespace

ShaderProgram::ShaderProgram(std::string name, std::string preamble, std::string vertex, std::string fragment,
                             std::string geometry)
    : name_(std::move(name)),
      preamble_(std::move(preamble)),
      vertex_(std::move(vertex)),
      fragment_(std::move(fragment)),
      geometry_(std::move(geometry)) {}

ShaderProgram::~ShaderProgram() {
  if (program_ != 0) glDeleteProgram(program_);
}

void ShaderProgram::Use() {
  if (program_ == 0) {
    const std::array<std::pair<GLenum, const std::string*>, 3> sources = {
        {{GL_VERTEX_SHADER, &vertex_}, {GL_GEOMETRY_SHADER, &geometry_}, {GL_FRAGMENT_SHADER, &fragment_}}};
    const GLuint program = glCreateProgram();
    for (const auto& [kind, source] : sources) {
      if (source->empty()) continue;
      const GLuint shader = Compile(kind, name_, preamble_, *source);
      glAttachShader(program, shader);
      glDeleteShader(shader);
    }
    glLinkProgram(program);
    GLint linked = 0;
    glGetProgramiv(program, GL_LINK_STATUS, &linked);
    if (linked == 0) throw Error("The shaders of \"" + name_ + "\" cannot be linked on this driver.");
    program_ = program;
  }
  glUseProgram(program_);
}

GLint ShaderProgram::Location(std::string_view uniform) {
  const auto found = locations_.find(uniform);
  if (found != locations_.end()) return found->second;
  const std::string name(uniform);
  return locations_.emplace(name, glGetUniformLocation(program_, name.c_str())).first->second;
}

void ShaderProgram::Set(std::string_view uniform, float value) { glUniform1f(Location(uniform), value); }
void ShaderProgram::Set(std::string_view uniform, int value) { glUniform1i(Location(uniform), value); }
void ShaderProgram::Set(std::string_view uniform, const Eigen::Vector2f& value) {
  glUniform2fv(Location(uniform), 1, value.data());
}
void ShaderProgram::Set(std::string_view uniform, const Eigen::Vector3f& value) {
  glUniform3fv(Location(uniform), 1, value.data());
}
void ShaderProgram::Set(std::string_view uniform, const Eigen::Vector4f& value) {
  glUniform4fv(Location(uniform), 1, value.data());
}
void ShaderProgram::Set(std::string_view uniform, const Eigen::Matrix3f& value) {
  glUniformMatrix3fv(Location(uniform), 1, GL_FALSE, value.data());
}
void ShaderProgram::Set(std::string_view uniform, const Eigen::Matrix4f& value) {
  glUniformMatrix4fv(Location(uniform), 1, GL_FALSE, value.data());
}

}  // namespace hgros::viewer
