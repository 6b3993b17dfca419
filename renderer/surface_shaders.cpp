// GLSL shading of all surfaces. Colours of materials are linear until encode() converts them to
// sRGB. The constants were chosen by eye on draped cloth. They describe a warm key light, a sky
// that is brighter and cooler than the ground, and a backdrop without a horizon.
#include "renderer/surface_shaders.h"

namespace loomstone {
namespace {

const char* vertex_text = R"(
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec2 uv;
layout(location = 3) in float value;
layout(location = 4) in float other;
uniform mat4 view, projection;
// Fraction of its distance by which a point moves towards the eye; > 0 only for the wireframe
uniform float towards_eye;
out vec3 eye_position, eye_normal;
out vec2 surface_uv;
out float surface_value, surface_other;
void main() {
  vec4 p = view * vec4(position, 1.0);
  eye_position = p.xyz;
  eye_normal = mat3(view) * normal;
  surface_uv = uv;
  surface_value = value;
  surface_other = other;
  p.xyz *= 1.0 - towards_eye;
  gl_Position = projection * p;
}
)";

// Declarations and functions of the fragment shaders of cloth, bodies, floors and the backdrop.
const char* common = R"(
out vec4 color;
uniform vec2 size;                 // size of the picture in pixels
// Half-size picture: visible fractions of the light (x) and the surroundings (y), depth [m] (z)
uniform sampler2D light_seen;
uniform vec3 towards_light, up;    // unit vectors in eye space

const vec3 sun = vec3(1.06, 0.99, 0.89);
const vec3 sky = vec3(0.31, 0.335, 0.38);
const vec3 ground = vec3(0.19, 0.175, 0.16);

vec4 encode(vec3 linear) {   // to sRGB, with noise of up to half an 8-bit step to avoid banding
  vec3 c = clamp(linear, 0.0, 1.0);
  c = mix(12.92 * c, 1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, c));
  float noise = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715)))) - 0.5;
  return vec4(c + noise / 255.0, 1.0);
}

// Encodes a linear colour after compressing values above 0.7 into the range from 0.7 to 1, so that
// bright surfaces and highlights are not clipped to flat white.
vec4 toned(vec3 linear) {
  vec3 bright = 1.0 - 0.3 * exp(-max(vec3(0.0), linear - 0.7) / 0.3);
  return encode(mix(linear, bright, step(0.7, linear)));
}

vec3 backdrop() {
  vec2 s = gl_FragCoord.xy / size;
  vec2 d = (s - vec2(0.5, 0.52)) * vec2(1.0, 0.85);
  vec3 c = mix(vec3(0.70, 0.72, 0.74), vec3(0.80, 0.80, 0.80), smoothstep(0.9, 0.1, s.y));
  return c * (1.0 - 0.55 * dot(d, d));
}

// Returns the visible fractions of light and surroundings at a depth: the weighted mean over the
// four nearest pixels of the half-size picture. Pixels of a different depth usually belong to other
// surfaces, and have almost no weight.
vec2 seen_at(float depth) {
  vec2 half_size = vec2(textureSize(light_seen, 0));
  vec2 at = gl_FragCoord.xy * half_size / size - 0.5;
  ivec2 low = ivec2(floor(at)), last = ivec2(half_size) - 1;
  vec2 f = at - vec2(low);
  vec2 sum = vec2(0.0);
  float weight = 0.0;
  for (int k = 0; k < 4; ++k) {
    ivec2 step_ = ivec2(k & 1, k >> 1);
    vec3 s = texelFetch(light_seen, clamp(low + step_, ivec2(0), last), 0).xyz;
    vec2 g = mix(1.0 - f, f, vec2(step_));
    float w = (g.x * g.y + 1e-3) / (1e-3 + abs(s.z - depth) / depth);
    sum += w * s.xy;
    weight += w;
  }
  return sum / weight;
}

vec3 ambient(vec3 n) { return mix(ground, sky, 0.5 + 0.5 * dot(n, up)); }
)";

// Shading by the materials of cloth, bodies and floors; see Material in materials.h.
const char* material = R"(
uniform vec3 front_color, back_color;
uniform float roughness;
uniform int textured;
uniform sampler2D image;          // its first row is the upper edge
uniform vec2 texture_low, texture_size;

vec3 with_texture(vec3 albedo, vec2 uv) {
  if (textured == 0) return albedo;
  vec2 at = (uv - texture_low) / texture_size;
  vec4 t = texture(image, vec2(at.x, 1.0 - at.y));
  return mix(albedo, t.rgb, t.a);
}

// Returns the specularly reflected light. Sunlight uses the GGX distribution of microfacet normals
// (B. Walter et al., "Microfacet models for refraction through rough surfaces", 2007), the
// visibility term of E. Hammon, "PBR diffuse lighting for GGX+Smith microsurfaces", 2017, and the
// Fresnel reflectance of C. Schlick, "An inexpensive BRDF model", 1994. Ambient light is added.
vec3 mirrored(vec3 n, vec3 v, vec2 seen) {
  float a = max(roughness * roughness, 0.004);
  vec3 h = normalize(towards_light + v);
  float nl = max(0.0, dot(n, towards_light)), nv = max(1e-3, dot(n, v)), nh = max(0.0, dot(n, h));
  float d = (nh * a * a - nh) * nh + 1.0;
  float visible = 0.5 / mix(2.0 * nl * nv, nl + nv, a);
  float reflectance = 0.04 + 0.96 * pow(1.0 - max(0.0, dot(v, h)), 5.0);
  float around = 0.04 + max(0.0, 0.96 - roughness) * pow(1.0 - nv, 5.0);
  return sun * (nl * a * a / (d * d) * visible * reflectance * seen.x) +
         ambient(reflect(-v, n)) * (around * seen.y);
}
)";

const char* surface_inputs = R"(
in vec3 eye_position, eye_normal;
in vec2 surface_uv;
in float surface_value, surface_other;
)";

// The inputs of the material shaders, moved from the sample to the centre of its pixel. On a
// triangle, an input divided by the depth is a linear function of the position in the picture.
const char* moved_inputs = R"(
uniform vec2 to_centre;   // vector from the sample to the centre of the pixel [pixels]
in vec3 eye_position, eye_normal;
in vec2 surface_uv;
in float surface_value, surface_other;
float closeness() { return -1.0 / eye_position.z; }
#define LINEAR(v) (v + to_centre.x * dFdx(v) + to_centre.y * dFdy(v))
#define MOVED(v) (LINEAR((v * closeness())) / LINEAR(closeness()))
#define eye_position MOVED(eye_position)
#define eye_normal MOVED(eye_normal)
#define surface_uv MOVED(surface_uv)
#define surface_value MOVED(surface_value)
#define surface_other MOVED(surface_other)
)";

const char* background_text = R"(
void main() { color = encode(backdrop()); }
)";

// A floor without a colour or texture shows the backdrop, slightly brighter near the centre and
// darkened by shadows and occlusion. All these effects vanish towards the floor's border, which is
// thus invisible. Floors with a colour or texture fade into the backdrop.
const char* floor_text = R"(
uniform int transparent;   // 1: no backdrop; a floor without colour and texture shows only shadows
uniform int colored;       // 1: the floor has a colour or texture of its own
uniform vec2 centre_uv, side_a_uv, side_b_uv;   // uv over the square; see SquareUv
void main() {
  vec3 albedo =
      with_texture(front_color, centre_uv + surface_uv.x * side_a_uv + surface_uv.y * side_b_uv);
  float distance = length(surface_uv) * 6.0;   // from the centre [radii of the framed region]
  float fade = 1.0 - smoothstep(2.6, 5.0, distance);
  float pool = 1.0 + 0.10 * exp(-0.8 * distance * distance);
  if (fade == 0.0) { color = transparent == 1 ? vec4(0.0) : encode(backdrop()); return; }
  vec2 seen = mix(vec2(1.0), seen_at(-eye_position.z), fade);
  vec3 n = normalize(eye_normal);
  vec3 direct = sun * max(0.0, dot(n, towards_light));
  if (colored == 1) {
    vec3 light = ambient(n) * seen.y + sun * max(0.0, dot(n, towards_light)) * seen.x;
    vec3 lit = albedo * light + mirrored(n, normalize(-eye_position), seen);
    color = transparent == 1 ? toned(lit) * fade : mix(encode(backdrop()), toned(lit), fade);
    return;
  }
  vec3 around = sky * 1.25;
  vec3 share = (around * seen.y + direct * seen.x) / (around + direct);
  if (transparent == 1)
    color = vec4(0.0, 0.0, 0.0, 1.0 - dot(share, vec3(0.2126, 0.7152, 0.0722)));
  else
    color = encode(backdrop() * share * pool);
}
)";

const char* body_text = R"(
uniform int curves;
void main() {
  vec3 n = normalize(gl_FrontFacing ? eye_normal : -eye_normal);
  vec3 v = normalize(-eye_position);
  vec2 seen = seen_at(-eye_position.z);
  vec3 albedo = with_texture(front_color, surface_uv);
  // North poles are red, and south poles are blue.
  albedo = mix(albedo, vec3(0.55, 0.05, 0.04), smoothstep(0.02, 0.04, surface_value));
  albedo = mix(albedo, vec3(0.04, 0.12, 0.50), smoothstep(0.02, 0.04, -surface_value));
  // Curves are red at the value 1, yellow at 0 and blue at -1.
  if (curves == 1) {
    vec3 end = surface_value > 0.0 ? vec3(0.60, 0.07, 0.04) : vec3(0.05, 0.16, 0.58);
    albedo = mix(vec3(0.72, 0.56, 0.22), end, surface_value * surface_value);
  }
  float facing = dot(n, towards_light);
  vec3 light = ambient(n) * seen.y + sun * max(0.0, facing) * seen.x;
  color = toned(albedo * light + mirrored(n, v, seen));
}
)";

const char* cloth_text = R"(
uniform vec3 checker_color;
uniform int pattern;              // 0 plain, 1 weave, 2 checker
uniform float pattern_size;       // edge of a square with the area of the cloth's box in uv [m]
uniform int colored;
uniform vec2 value_range;
uniform float split;              // column right of which surface_other is shown [pixels]
uniform sampler2D color_table;

float hash(vec2 p) {
  vec3 q = fract(vec3(p.xyx) * vec3(0.1031, 0.1030, 0.0973));
  q += dot(q, q.yzx + 33.33);
  return fract((q.x + q.y) * q.z);
}

// Brightness of a plain weave. At each crossing, the upper thread is darker at its sides and where
// it passes under the next threads. The mean is 1. The pattern fades to that mean as the width of
// the threads falls from 4.5 to 2 pixels.
float crossings(vec2 t, float pixel) {
  float strength = 1.0 - smoothstep(0.22, 0.5, pixel);
  if (strength == 0.0) return 1.0;
  vec2 cell = floor(t), f = fract(t) - 0.5;
  if (mod(cell.x + cell.y, 2.0) > 0.5) f = f.yx;
  float h = (1.0 - 4.0 * f.y * f.y) * (0.7 + 0.3 * cos(3.14159 * f.x));
  return 1.0 + strength * 0.42 * (h - 0.594);
}

// Brightness due to slubs: thickness and dye vary from thread to thread and along each thread.
float slubs(vec2 t, float pixel) {
  float strength = 1.0 - smoothstep(0.35, 0.9, pixel);
  if (strength == 0.0) return 1.0;
  vec2 cell = floor(t), along = t / 23.0;
  vec2 f = smoothstep(0.0, 1.0, fract(along)), k = floor(along);
  float weft = mix(hash(vec2(k.x, cell.y)), hash(vec2(k.x + 1.0, cell.y)), f.x);
  float warp = mix(hash(vec2(cell.x + 517.0, k.y)), hash(vec2(cell.x + 517.0, k.y + 1.0)), f.y);
  return 1.0 + strength * 0.16 * (weft + warp - 1.0);
}

// Checkerboard averaged over a pixel, by the integral of a square wave in each direction.
float squares(vec2 t) {
  vec2 w = max(fwidth(t), 1e-4);
  vec2 i = 2.0 * (abs(fract((t - 0.5 * w) * 0.5) - 0.5) - abs(fract((t + 0.5 * w) * 0.5) - 0.5)) / w;
  return 0.5 - 0.5 * i.x * i.y;
}

void main() {
  vec3 n = normalize(gl_FrontFacing ? eye_normal : -eye_normal);
  vec3 v = normalize(-eye_position);
  vec2 seen = seen_at(-eye_position.z);
  float facing = dot(n, towards_light);

  vec2 threads = surface_uv * (170.0 / pattern_size);
  vec2 change = fwidth(threads);
  float pixel = max(change.x, change.y);
  if (colored == 1) {
    float value = gl_FragCoord.x < split ? surface_value : surface_other;
    float t = clamp((value - value_range.x) / (value_range.y - value_range.x), 0.0, 1.0);
    vec3 c = texture(color_table, vec2((t * 255.0 + 0.5) / 256.0, 0.5)).rgb;
    vec3 light = ambient(n) * seen.y + sun * max(0.0, (facing + 0.2) / 1.2) * seen.x;
    c = pow(c, vec3(2.2)) * (0.36 + 0.58 * light);
    color = encode(mix(vec3(0.02), c, smoothstep(0.4, 1.2, abs(gl_FragCoord.x - split))));
    return;
  }
  vec3 albedo = with_texture(gl_FrontFacing ? front_color : back_color, surface_uv);
  if (pattern == 2 && textured == 0) albedo = mix(albedo, checker_color, squares(surface_uv * (12.0 / pattern_size)));
  if (pattern == 1 && textured == 0) {
    albedo *= crossings(threads, pixel) * slubs(threads, pixel) * slubs(threads / 5.0 + 91.0, pixel / 5.0);
  }
  // Fibres scatter light slightly beyond the terminator, and thin cloth transmits a little light.
  float direct = max(0.0, (facing + 0.18) / 1.18);
  float through = 0.16 * max(0.0, -facing);
  vec3 light = ambient(n) * seen.y + sun * (direct + through) * seen.x;
  float grazing = pow(1.0 - max(0.0, dot(n, v)), 3.0);
  vec3 sheen = (0.5 * albedo + 0.05) * grazing * (0.35 * seen.y + 0.5 * seen.x * max(0.0, facing));
  sheen *= roughness;
  color = toned(albedo * light + sheen + mirrored(n, v, seen));
}
)";

const char* edge_text = R"(
uniform int colored;
void main() { color = colored == 1 ? vec4(1.0, 1.0, 1.0, 0.24) : vec4(0.03, 0.03, 0.05, 0.34); }
)";

const char* overlay_text = R"(
uniform sampler2D things;
out vec4 color;
void main() { color = texelFetch(things, ivec2(gl_FragCoord.xy), 0); }
)";

}  // namespace

std::string whole_picture_vertex_shader() {
  return "void main() { gl_Position = vec4(vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0, "
         "1.0, 1.0); }";
}
std::string surface_vertex_shader() { return vertex_text; }
std::string background_fragment_shader() { return std::string(common) + background_text; }
std::string floor_fragment_shader() {
  return std::string(common) + surface_inputs + material + floor_text;
}
std::string cloth_fragment_shader(bool moved) {
  return std::string(common) + (moved ? moved_inputs : surface_inputs) + material + cloth_text;
}
std::string body_fragment_shader(bool moved) {
  return std::string(common) + (moved ? moved_inputs : surface_inputs) + material + body_text;
}
std::string edge_fragment_shader() { return std::string("out vec4 color;\n") + edge_text; }

std::string overlay_fragment_shader() { return overlay_text; }

}  // namespace loomstone
