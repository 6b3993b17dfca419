// Materials of the surfaces, made from their looks (core/base/look.h).
#pragma once

#include <vector>

#include "core/base/frame.h"
#include "renderer/gl_objects.h"

namespace loomstone {

// Material of a surface, as the shaders use it.
struct Material {
  Eigen::Vector3f front = Eigen::Vector3f::Zero(), back = Eigen::Vector3f::Zero();  // linear RGB
  bool own_color = false;  // whether the look has a colour or texture; false for cloth
  float roughness = 0.0f;
  float pattern_size = 1.0f;  // edge of a square with the area of the cloth's box in uv [m]
  GLuint texture = 0;         // 0: none
  Eigen::Vector2f texture_low = Eigen::Vector2f::Zero();  // uv of the image's lower left corner [m]
  Eigen::Vector2f texture_size = Eigen::Vector2f::Ones();  // size of the image in uv [m]

  void set(const Program& program, int texture_unit) const;  // the program must be in use
};

class Materials {
 public:
  Materials(const GL& gl, const FrameTopology& topology);
  const Material& cloth(Index number) const { return cloths_[static_cast<std::size_t>(number)]; }
  // Returns the material of a body or obstacle, or that of the curves if `number` equals the number
  // of bodies and obstacles.
  const Material& body(Index number) const { return bodies_[static_cast<std::size_t>(number)]; }

 private:
  std::vector<GlObject> textures_;
  std::vector<Material> cloths_, bodies_;
};

}  // namespace loomstone
