// A headless OpenGL 3.3 core context from the system's OSMesa, else from surfaceless EGL, else from
// the OSMesa that wheels contain. The OSMesa of wheels is slower, because it has no LLVM and draws
// with softpipe. The libraries are loaded at run time, so a machine without them gets an error
// message instead of a link error. The environment variable LOOMSTONE_GL=osmesa|egl|softpipe
// selects one of the three.
#pragma once

#include <memory>
#include <string>

#include <glad/gl.h>

namespace loomstone {

class Context {
 public:
  virtual ~Context() = default;
  virtual const std::string& backend() const = 0;  // "osmesa" | "egl" | "softpipe"
  virtual void make_current() = 0;
  virtual void release() = 0;  // this thread then has no current context
};

// Creates a context as described at the top of this file. Throws InvalidInput if LOOMSTONE_GL has
// an unknown value, and Unsupported if no context can be created. The message of Unsupported names
// what could not be loaded (the value of LOOMSTONE_GL or, if this variable is not set, OSMesa and
// EGL) and the Debian packages to install.
std::unique_ptr<Context> create_context();

// Returns the OpenGL functions of `context`, which must be current. Throws Unsupported if they
// cannot be loaded.
GladGLContext load_functions(Context& context);

// Makes a context current in this thread during the lifetime of the object.
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
