// Soft shadows: blockers are the surfaces between a point and the light. Their mean depth
// determines the width of the penumbra. Visibility in the shadow map is averaged over this width
// (R. Fernando, "Percentage-closer soft shadows", 2005). Ambient occlusion is a weighted sum over
// neighbours above the tangent plane of the point (M. McGuire, M. Mara, D. Luebke, "Scalable
// ambient obscurance", 2012). Both use few samples, rotated by a 4 x 4 pattern of angles. A blur
// that is four pixels wide then averages over this pattern. The blur does not cross depth edges.
#include "renderer/light_pass.h"

namespace loomstone {
namespace {

const char* whole_picture = R"(
void main() { gl_Position = vec4(vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0, 0.0, 1.0); }
)";

const char* light_fragment_shader = R"(
uniform sampler2D surface, shadow_map;
uniform mat4 light_from_eye;    // from eye space to the light's cube [-1, 1]^3
uniform vec3 towards_light;     // unit vector in eye space
uniform vec2 tangent, size;     // tangents of half the angles of view; size of this pass in pixels
uniform float scale, light_radius;
uniform int with_shadows, with_occlusion;
out vec4 result;

const float golden = 2.39996323;
const int blocker_samples = 8, shadow_samples = 12, occlusion_samples = 9;

vec3 eye_position(vec2 pixel, float depth) {
  return vec3((pixel / size * 2.0 - 1.0) * tangent, -1.0) * depth;
}

vec2 spiral(int i, int n, float turn) {
  float angle = golden * float(i) + turn;
  return sqrt((float(i) + 0.5) / float(n)) * vec2(cos(angle), sin(angle));
}

float light_seen(vec3 p, vec3 n, float turn) {
  float facing = dot(n, towards_light);
  vec3 lit_side = facing < 0.0 ? -n : n;
  float texel = 2.0 / float(textureSize(shadow_map, 0).x);   // texel width in the cube [-1, 1]^3
  p += lit_side * light_radius * texel * 1.5;
  vec3 q = (light_from_eye * vec4(p, 1.0)).xyz * 0.5 + 0.5;
  if (abs(q.x - 0.5) > 0.5 || abs(q.y - 0.5) > 0.5) return 1.0;
  // Slope of the surface's depth over the shadow map. The depth that is compared with a texel is
  // changed by this slope times the offset of the texel, so that an inclined surface does not
  // shadow itself.
  vec3 m = normalize(mat3(light_from_eye) * lit_side);
  vec2 slope = clamp(-m.xy / min(m.z, -0.05), vec2(-4.0), vec2(4.0));
  float bias = 0.75 * texel;
  float deepest = 0.9999;   // less than the depth 1 of empty texels, which thus cast no shadow

  const float softness = 0.11;   // penumbra radius / blocker distance (lamp 12 degrees wide)
  float search = 0.022;
  float blockers = 0.0, depth_sum = 0.0;
  for (int i = 0; i < blocker_samples; ++i) {
    vec2 offset = spiral(i, blocker_samples, turn) * search;
    float z = textureLod(shadow_map, q.xy + offset, 0.0).r;
    float blocks = step(z, min(q.z + dot(slope, offset) - bias - 0.2 * search, deepest));
    blockers += blocks;
    depth_sum += blocks * z;
  }
  float gap = blockers > 0.0 ? q.z - depth_sum / blockers : 0.0;
  float width = clamp(softness * gap, 0.8 * texel, 0.03);
  float seen = 0.0;
  for (int i = 0; i < shadow_samples; ++i) {
    vec2 offset = spiral(i, shadow_samples, turn) * width;
    float z = textureLod(shadow_map, q.xy + offset, 0.0).r;
    seen += step(min(q.z + dot(slope, offset) - bias, deepest), z);
  }
  return seen / float(shadow_samples);
}

float surroundings_seen(vec3 p, vec3 n, float turn) {
  float radius = 0.16 * scale;
  float reach = radius / (-p.z * tangent.y) * 0.5 * size.y;   // `radius` in pixels
  reach = clamp(reach, 2.0, 0.2 * size.y);
  float sum = 0.0;
  for (int i = 0; i < occlusion_samples; ++i) {
    float share = (float(i) + 0.5) / float(occlusion_samples);
    float angle = 3.0 * 6.2831853 * share + turn;
    vec2 pixel = gl_FragCoord.xy + share * reach * vec2(cos(angle), sin(angle));
    pixel = clamp(floor(pixel) + 0.5, vec2(0.5), size - 0.5);
    float depth = texelFetch(surface, ivec2(pixel), 0).w;
    if (depth == 0.0) depth = 1e6;
    vec3 v = eye_position(pixel, depth) - p;
    float vv = dot(v, v), vn = dot(v, n);
    float near = max(0.0, 1.0 - vv / (radius * radius));
    sum += near * near * max(0.0, vn * inversesqrt(vv + 1e-12) - 0.12);
  }
  return clamp(1.0 - 3.2 * sum / float(occlusion_samples), 0.0, 1.0);
}

void main() {
  vec4 here = texelFetch(surface, ivec2(gl_FragCoord.xy), 0);
  if (here.w == 0.0) { result = vec4(1.0, 1.0, 0.0, 0.0); return; }
  vec3 p = eye_position(gl_FragCoord.xy, here.w);
  // Angle by which the samples of this pixel are rotated. In a block of 4 x 4 pixels, the angles
  // have the order of a Bayer matrix (bits interleaved), so that those of neighbouring pixels
  // differ strongly.
  ivec2 c = ivec2(gl_FragCoord.xy) & 3;
  int x = c.x ^ c.y;
  float turn = 6.2831853 / 16.0 * float(((x & 1) << 3) | ((c.y & 1) << 2) | (x & 2) | ((c.y & 2) >> 1));
  float seen = with_shadows == 1 ? light_seen(p, here.xyz, turn) : 1.0;
  float open = with_occlusion == 1 ? surroundings_seen(p, here.xyz, turn) : 1.0;
  result = vec4(seen, open, here.w, 0.0);
}
)";

const char* blur_fragment_shader = R"(
uniform sampler2D raw;
uniform ivec2 step_;
out vec4 result;
void main() {
  ivec2 here = ivec2(gl_FragCoord.xy), last = textureSize(raw, 0) - 1;
  vec4 centre = texelFetch(raw, here, 0);
  if (centre.z == 0.0) { result = centre; return; }
  vec2 sum = centre.xy;
  float weight = 1.0;
  for (int i = -2; i <= 2; ++i) {
    if (i == 0) continue;
    vec4 there = texelFetch(raw, clamp(here + i * step_, ivec2(0), last), 0);
    float w = abs(i) == 2 ? 0.5 : 1.0;
    w *= max(0.0, 1.0 - 40.0 * abs(there.z - centre.z) / centre.z);
    sum += w * there.xy;
    weight += w;
  }
  result = vec4(sum / weight, centre.z, 0.0);
}
)";

}  // namespace

LightPass::LightPass(const GL& gl, int width, int height)
    : gl_(&gl),
      width_(width),
      height_(height),
      light_program_(gl, "light", whole_picture, light_fragment_shader),
      blur_program_(gl, "blur", whole_picture, blur_fragment_shader),
      first_(make_texture(gl, {GL_RGBA32F, width, height})),
      second_(make_texture(gl, {GL_RGBA32F, width, height})),
      first_framebuffer_(make_framebuffer(gl)),
      second_framebuffer_(make_framebuffer(gl)),
      empty_(make_vertex_array(gl)) {
  gl.BindFramebuffer(GL_FRAMEBUFFER, first_framebuffer_.name());
  gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, first_.name(), 0);
  check_framebuffer(gl, "light pass");
  gl.BindFramebuffer(GL_FRAMEBUFFER, second_framebuffer_.name());
  gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, second_.name(), 0);
  check_framebuffer(gl, "light pass");
}

void LightPass::draw(const View& view, const LightView& light, const LightPassOptions& options,
                     const DepthPass& depth, const ShadowPass& shadow) const {
  const Float4x4 to_eye = view.view();
  gl_->BindVertexArray(empty_.name());
  gl_->Viewport(0, 0, width_, height_);
  gl_->Disable(GL_DEPTH_TEST);

  gl_->BindFramebuffer(GL_FRAMEBUFFER, first_framebuffer_.name());
  light_program_.use();
  light_program_.set_texture("surface", 0, depth.surface());
  light_program_.set_texture("shadow_map", 1, shadow.depth());
  light_program_.set("light_from_eye", Float4x4(light.matrix * to_eye.inverse()));
  light_program_.set("towards_light",
                     Eigen::Vector3f(to_eye.topLeftCorner<3, 3>() * light.towards));
  light_program_.set("tangent", Eigen::Vector2f(static_cast<float>(view.tangent_x),
                                                static_cast<float>(view.tangent_y)));
  light_program_.set("size",
                     Eigen::Vector2f(static_cast<float>(width_), static_cast<float>(height_)));
  light_program_.set("scale", static_cast<float>(options.scale));
  light_program_.set("light_radius", light.radius);
  light_program_.set("with_shadows", options.shadows ? 1 : 0);
  light_program_.set("with_occlusion", options.ambient_occlusion ? 1 : 0);
  gl_->DrawArrays(GL_TRIANGLES, 0, 3);

  blur_program_.use();
  for (const auto& [target, source, across, down] :
       {std::tuple{&second_framebuffer_, &first_, 1, 0}, {&first_framebuffer_, &second_, 0, 1}}) {
    gl_->BindFramebuffer(GL_FRAMEBUFFER, target->name());
    blur_program_.set_texture("raw", 0, source->name());
    blur_program_.set("step_", across, down);
    gl_->DrawArrays(GL_TRIANGLES, 0, 3);
  }
}

}  // namespace loomstone
