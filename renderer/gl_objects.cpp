// Creates and deletes OpenGL objects, and compiles shader programs.
#include "renderer/gl_objects.h"

#include <utility>

#include "core/base/message.h"

namespace loomstone {

GlObject::~GlObject() {
  if (remove_) remove_(*gl_, name_);
}

GlObject::GlObject(GlObject&& other) noexcept
    : gl_(other.gl_), name_(other.name_), remove_(std::exchange(other.remove_, nullptr)) {}

GlObject& GlObject::operator=(GlObject&& other) noexcept {
  std::swap(gl_, other.gl_);
  std::swap(name_, other.name_);
  std::swap(remove_, other.remove_);
  return *this;
}

GlObject make_buffer(const GL& gl) {
  GLuint name = 0;
  gl.GenBuffers(1, &name);
  return {gl, name, [](const GL& g, GLuint n) { g.DeleteBuffers(1, &n); }};
}

GlObject make_vertex_array(const GL& gl) {
  GLuint name = 0;
  gl.GenVertexArrays(1, &name);
  return {gl, name, [](const GL& g, GLuint n) { g.DeleteVertexArrays(1, &n); }};
}

GlObject make_texture(const GL& gl, const Texture& texture) {
  GLuint name = 0;
  gl.GenTextures(1, &name);
  gl.BindTexture(GL_TEXTURE_2D, name);
  gl.TexImage2D(GL_TEXTURE_2D, 0, static_cast<GLint>(texture.format), texture.width, texture.height,
                0, texture.pixel_format, texture.pixel_type, texture.pixels);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, static_cast<GLint>(texture.filter));
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, static_cast<GLint>(texture.filter));
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
  return {gl, name, [](const GL& g, GLuint n) { g.DeleteTextures(1, &n); }};
}

GlObject make_renderbuffer(const GL& gl, GLenum format, int width, int height, int samples) {
  GLuint name = 0;
  gl.GenRenderbuffers(1, &name);
  gl.BindRenderbuffer(GL_RENDERBUFFER, name);
  gl.RenderbufferStorageMultisample(GL_RENDERBUFFER, samples > 1 ? samples : 0, format, width,
                                    height);
  return {gl, name, [](const GL& g, GLuint n) { g.DeleteRenderbuffers(1, &n); }};
}

GlObject make_framebuffer(const GL& gl) {
  GLuint name = 0;
  gl.GenFramebuffers(1, &name);
  return {gl, name, [](const GL& g, GLuint n) { g.DeleteFramebuffers(1, &n); }};
}

namespace {

GLuint compile(const GL& gl, const std::string& name, GLenum stage, const std::string& source) {
  const GLuint shader = gl.CreateShader(stage);
  const std::string text = "#version 330 core\n" + source;
  const char* pointer = text.c_str();
  gl.ShaderSource(shader, 1, &pointer, nullptr);
  gl.CompileShader(shader);
  GLint good = 0;
  gl.GetShaderiv(shader, GL_COMPILE_STATUS, &good);
  if (!good) {
    char log[2000] = "";
    gl.GetShaderInfoLog(shader, sizeof log, nullptr, log);
    fail<Unsupported>("shader {} was not accepted by this OpenGL: {}", name, log);
  }
  return shader;
}

}  // namespace

Program::Program(const GL& gl, const std::string& name, const std::string& vertex,
                 const std::string& fragment)
    : gl_(&gl), object_(gl, gl.CreateProgram(), [](const GL& g, GLuint n) { g.DeleteProgram(n); }) {
  const GLuint first = compile(gl, name, GL_VERTEX_SHADER, vertex);
  const GLuint second = compile(gl, name, GL_FRAGMENT_SHADER, fragment);
  gl.AttachShader(object_.name(), first);
  gl.AttachShader(object_.name(), second);
  gl.LinkProgram(object_.name());
  gl.DeleteShader(first);
  gl.DeleteShader(second);
  GLint good = 0;
  gl.GetProgramiv(object_.name(), GL_LINK_STATUS, &good);
  if (!good) {
    char log[2000] = "";
    gl.GetProgramInfoLog(object_.name(), sizeof log, nullptr, log);
    fail<Unsupported>("shader {} was not linked by this OpenGL: {}", name, log);
  }
}

void Program::set(const char* name, int value) const {
  gl_->Uniform1i(gl_->GetUniformLocation(object_.name(), name), value);
}
void Program::set(const char* name, int x, int y) const {
  gl_->Uniform2i(gl_->GetUniformLocation(object_.name(), name), x, y);
}
void Program::set(const char* name, float value) const {
  gl_->Uniform1f(gl_->GetUniformLocation(object_.name(), name), value);
}
void Program::set(const char* name, const Eigen::Vector2f& value) const {
  gl_->Uniform2fv(gl_->GetUniformLocation(object_.name(), name), 1, value.data());
}
void Program::set(const char* name, const Eigen::Vector3f& value) const {
  gl_->Uniform3fv(gl_->GetUniformLocation(object_.name(), name), 1, value.data());
}
void Program::set(const char* name, const Float4x4& value) const {
  gl_->UniformMatrix4fv(gl_->GetUniformLocation(object_.name(), name), 1, GL_FALSE, value.data());
}
void Program::set_texture(const char* name, int unit, GLuint texture) const {
  gl_->ActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
  gl_->BindTexture(GL_TEXTURE_2D, texture);
  set(name, unit);
}

void check_framebuffer(const GL& gl, const char* what) {
  const GLenum status = gl.CheckFramebufferStatus(GL_FRAMEBUFFER);
  if (status != GL_FRAMEBUFFER_COMPLETE)
    fail<Unsupported>("this OpenGL cannot draw into the framebuffer of the {} (status {})", what,
                      status);
}

}  // namespace loomstone
