// A headless OpenGL 3.3 core context: OSMesa, else EGL without a surface. Both are loaded at run
// time, so a machine that has neither gets a sentence and no link error. The environment variable
// LOOMSTONE_GL=osmesa|egl forces one.
#pragma once

#include <memory>
#include <string>

#include <glad/gl.h>

namespace loomstone {

class Context {
 public:
  virtual ~Context() = default;
  virtual const std::string& backend() const = 0;  // "osmesa" | "egl"
  virtual void make_current() = 0;
  virtual void release() = 0;  // no context is current in this thread afterwards
};

// Throws Unsupported naming what was tried and which packages help.
std::unique_ptr<Context> create_context();

// The OpenGL functions of the context that is current.
GladGLContext load_functions(Context& context);

// Makes a context current in this thread for as long as it lives.
class Current {
 public:
  explicit Current(Context& context) : context_(context) { context_.make_current(); }
  ~Current() { context_.release(); }
  Current(const Current&) = delete;
  Current& operator=(const Current&) = delete;

 private:
  Context& context_;
};

}  // namespace loomstone
