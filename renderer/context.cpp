// Only this file uses OSMesa and EGL. Their libraries are opened once and never closed, because the
// contexts of all renderers and threads share them.
#include "renderer/context.h"

#include <dlfcn.h>

#include <array>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GL/osmesa.h>

#include "core/base/message.h"
#include "core/base/own_directory.h"

namespace loomstone {
namespace {

using Function = void (*)();

void* open_first(const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    if (void* library = dlopen(name.c_str(), RTLD_NOW | RTLD_LOCAL)) return library;
  }
  return nullptr;
}

template <class Pointer>
bool look_up(void* library, const char* name, Pointer& pointer) {
  pointer = reinterpret_cast<Pointer>(dlsym(library, name));
  return pointer != nullptr;
}

// ---- OSMesa

struct OsMesa {
  decltype(&OSMesaCreateContextAttribs) create = nullptr;
  decltype(&OSMesaDestroyContext) destroy = nullptr;
  decltype(&OSMesaMakeCurrent) make_current = nullptr;
  decltype(&OSMesaGetProcAddress) function = nullptr;
  bool found = false;

  explicit OsMesa(const std::vector<std::string>& names) {
    void* library = open_first(names);
    found = library && look_up(library, "OSMesaCreateContextAttribs", create) &&
            look_up(library, "OSMesaDestroyContext", destroy) &&
            look_up(library, "OSMesaMakeCurrent", make_current) &&
            look_up(library, "OSMesaGetProcAddress", function);
  }
  static const OsMesa& of_system() {
    static const OsMesa library({"libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so"});
    return library;
  }
  static const OsMesa& of_wheel() {
    static const OsMesa library({own_directory() / "libOSMesa.so.8"});
    return library;
  }
};

class OsMesaContext final : public Context {
 public:
  OsMesaContext(const OsMesa& library, std::string name, OSMesaContext handle)
      : library_(library), name_(std::move(name)), handle_(handle) {}
  ~OsMesaContext() override { library_.destroy(handle_); }
  const std::string& backend() const override { return name_; }
  void make_current() override {
    if (!library_.make_current(handle_, pixels_.data(), GL_UNSIGNED_BYTE, 16, 16))
      throw Unsupported("the OSMesa context could not be made current; try LOOMSTONE_GL=egl");
  }
  void release() override { library_.make_current(nullptr, nullptr, GL_UNSIGNED_BYTE, 0, 0); }

 private:
  const OsMesa& library_;
  std::string name_;
  OSMesaContext handle_;
  std::array<unsigned char, 16 * 16 * 4>
      pixels_{};  // required by OSMesa but unused, because drawing goes to framebuffer objects
};

std::unique_ptr<Context> create_osmesa(const OsMesa& library, const char* name) {
  if (!library.found) return nullptr;
  const int attributes[] = {OSMESA_FORMAT,
                            OSMESA_RGBA,
                            OSMESA_DEPTH_BITS,
                            0,
                            OSMESA_STENCIL_BITS,
                            0,
                            OSMESA_ACCUM_BITS,
                            0,
                            OSMESA_PROFILE,
                            OSMESA_CORE_PROFILE,
                            OSMESA_CONTEXT_MAJOR_VERSION,
                            3,
                            OSMESA_CONTEXT_MINOR_VERSION,
                            3,
                            0};
  OSMesaContext handle = library.create(attributes, nullptr);
  if (!handle) return nullptr;
  return std::make_unique<OsMesaContext>(library, name, handle);
}

// ---- EGL without a surface

struct Egl {
  decltype(&eglGetProcAddress) function = nullptr;
  decltype(&eglInitialize) initialize = nullptr;
  decltype(&eglBindAPI) bind_api = nullptr;
  decltype(&eglCreateContext) create = nullptr;
  decltype(&eglDestroyContext) destroy = nullptr;
  decltype(&eglMakeCurrent) make_current = nullptr;
  EGLDisplay display = EGL_NO_DISPLAY;
  bool found = false;

  Egl() {
    void* library = open_first({"libEGL.so.1", "libEGL.so"});
    if (!library || !look_up(library, "eglGetProcAddress", function) ||
        !look_up(library, "eglInitialize", initialize) ||
        !look_up(library, "eglBindAPI", bind_api) ||
        !look_up(library, "eglCreateContext", create) ||
        !look_up(library, "eglDestroyContext", destroy) ||
        !look_up(library, "eglMakeCurrent", make_current))
      return;
    const auto display_of_platform =
        reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(function("eglGetPlatformDisplayEXT"));
    if (!display_of_platform) return;
    display = display_of_platform(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
    found = display != EGL_NO_DISPLAY && initialize(display, nullptr, nullptr);
  }
  static const Egl& get() {
    static const Egl library;
    return library;
  }
};

class EglContext final : public Context {
 public:
  explicit EglContext(EGLContext handle) : handle_(handle) {}
  ~EglContext() override { Egl::get().destroy(Egl::get().display, handle_); }
  const std::string& backend() const override { return name_; }
  void make_current() override {
    const Egl& egl = Egl::get();
    egl.bind_api(EGL_OPENGL_API);  // the bound API is a property of the thread
    if (!egl.make_current(egl.display, EGL_NO_SURFACE, EGL_NO_SURFACE, handle_))
      throw Unsupported(
          "the EGL context could not be made current (is it in use in another thread?)");
  }
  void release() override {
    Egl::get().make_current(Egl::get().display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  }

 private:
  std::string name_ = "egl";
  EGLContext handle_;
};

std::unique_ptr<Context> create_egl() {
  const Egl& egl = Egl::get();
  if (!egl.found || !egl.bind_api(EGL_OPENGL_API)) return nullptr;
  const EGLint attributes[] = {EGL_CONTEXT_MAJOR_VERSION,
                               3,
                               EGL_CONTEXT_MINOR_VERSION,
                               3,
                               EGL_CONTEXT_OPENGL_PROFILE_MASK,
                               EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                               EGL_NONE};
  EGLContext handle = egl.create(egl.display, EGLConfig{}, EGL_NO_CONTEXT, attributes);
  if (handle == EGL_NO_CONTEXT) return nullptr;
  return std::make_unique<EglContext>(handle);
}

GLADapiproc osmesa_function(const char* name) {
  return reinterpret_cast<GLADapiproc>(OsMesa::of_system().function(name));
}
GLADapiproc softpipe_function(const char* name) {
  return reinterpret_cast<GLADapiproc>(OsMesa::of_wheel().function(name));
}
GLADapiproc egl_function(const char* name) {
  return reinterpret_cast<GLADapiproc>(Egl::get().function(name));
}

}  // namespace

std::unique_ptr<Context> create_context() {
  const char* variable = std::getenv("LOOMSTONE_GL");
  const std::string forced = variable ? variable : "";
  if (!forced.empty() && forced != "osmesa" && forced != "egl" && forced != "softpipe")
    fail<InvalidInput>(
        "the environment variable LOOMSTONE_GL must be osmesa, egl or softpipe, got '{}'; correct "
        "or unset it",
        forced);
  const auto tried = [&](const char* name) { return forced.empty() || forced == name; };
  std::unique_ptr<Context> context;
  if (tried("osmesa")) context = create_osmesa(OsMesa::of_system(), "osmesa");
  if (!context && tried("egl")) context = create_egl();
  if (!context && tried("softpipe")) context = create_osmesa(OsMesa::of_wheel(), "softpipe");
  if (!context)
    fail<Unsupported>(
        "rendering needs OpenGL 3.3 without a screen, but {} be loaded; install OSMesa or EGL "
        "(Debian: apt-get install libosmesa6, or libegl1 with libegl-mesa0 and libgl1-mesa-dri).",
        forced.empty() ? "neither OSMesa nor EGL could" : forced + " (LOOMSTONE_GL) could not");
  return context;
}

GladGLContext load_functions(Context& context) {
  GladGLContext functions{};
  const std::string& name = context.backend();
  const auto function = name == "osmesa"     ? osmesa_function
                        : name == "softpipe" ? softpipe_function
                                             : egl_function;
  if (!gladLoadGLContext(&functions, function))
    fail<Unsupported>(
        "the functions of OpenGL 3.3 could not be loaded from {}; update Mesa or force another "
        "library with LOOMSTONE_GL=osmesa, egl or softpipe",
        name);
  return functions;
}

}  // namespace loomstone
