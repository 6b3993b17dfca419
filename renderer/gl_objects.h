// Owners of OpenGL objects. Their context must be current whenever they are created, used or
// destroyed.
#pragma once

#include <string>
#include <vector>

#include <glad/gl.h>

#include "core/base/types.h"

namespace loomstone {

using GL = GladGLContext;
using Float4x4 = Eigen::Matrix4f;

// The name of an OpenGL object and the function that deletes it.
class GlObject {
 public:
  using Delete = void (*)(const GL&, GLuint);
  GlObject() = default;
  GlObject(const GL& gl, GLuint name, Delete remove) : gl_(&gl), name_(name), remove_(remove) {}
  ~GlObject();
  GlObject(GlObject&& other) noexcept;
  GlObject& operator=(GlObject&& other) noexcept;
  GLuint name() const { return name_; }

 private:
  const GL* gl_ = nullptr;
  GLuint name_ = 0;
  Delete remove_ = nullptr;
};

GlObject make_buffer(const GL& gl);
GlObject make_vertex_array(const GL& gl);
// Description of a texture. make_texture() makes no mipmaps, and it clamps texture coordinates to
// the edge.
struct Texture {
  GLenum format;
  int width, height;           // pixels
  GLenum filter = GL_NEAREST;  // or GL_LINEAR
  const void* pixels = nullptr;
  GLenum pixel_format = GL_RGBA, pixel_type = GL_FLOAT;  // format and type of `pixels`
};
GlObject make_texture(const GL& gl, const Texture& texture);
GlObject make_renderbuffer(const GL& gl, GLenum format, int width, int height, int samples);
GlObject make_framebuffer(const GL& gl);

// A compiled and linked shader program. The constructor throws Unsupported with the message of
// OpenGL if a shader does not compile or the program does not link.
class Program {
 public:
  Program(const GL& gl, const std::string& name, const std::string& vertex,
          const std::string& fragment);
  void use() const { gl_->UseProgram(object_.name()); }
  // These functions set a uniform. The program must be in use. Uniforms removed by the compiler are
  // ignored. set_texture() also binds the texture to a texture unit.
  void set(const char* name, int value) const;
  void set(const char* name, float value) const;
  void set(const char* name, int x, int y) const;
  void set(const char* name, const Eigen::Vector2f& value) const;
  void set(const char* name, const Eigen::Vector3f& value) const;
  void set(const char* name, const Float4x4& value) const;
  void set_texture(const char* name, int unit, GLuint texture) const;

 private:
  const GL* gl_;
  GlObject object_;
};

// Throws Unsupported if the bound framebuffer is incomplete. `what` is its name in the message.
void check_framebuffer(const GL& gl, const char* what);

}  // namespace loomstone
