// Each glyph is its width, followed by lines "l x0 y0 x1 y1" and arcs "a x y rx ry from to"
// (degrees). Digits are 1 high and y points upwards. The coverage of a pixel follows from its
// distance to the nearest stroke.
#include "renderer/stroke_font.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>
#include <vector>

#include "core/base/types.h"

namespace loomstone {
namespace {

const std::map<char, const char*> glyph_texts = {
    {'0', "0.60 a .3 .5 .27 .5 0 360"},
    {'1', "0.60 l .14 .8 .34 1 l .34 1 .34 0"},
    {'2', "0.60 a .3 .71 .26 .29 165 -40 l .5 .525 .04 0 l .04 0 .57 0"},
    {'3', "0.60 a .28 .75 .23 .25 150 -90 a .28 .25 .27 .25 90 -150"},
    {'4', "0.60 l .44 0 .44 1 l .44 1 .02 .3 l .02 .3 .6 .3"},
    {'5', "0.60 l .52 1 .14 1 l .14 1 .1 .56 a .28 .32 .28 .32 130 -150"},
    {'6', "0.60 a .3 .31 .26 .31 0 360 l .43 1 .09 .48"},
    {'7', "0.60 l .03 1 .57 1 l .57 1 .2 0"},
    {'8', "0.60 a .3 .755 .22 .245 0 360 a .3 .255 .27 .255 0 360"},
    {'9', "0.60 a .3 .69 .26 .31 0 360 l .17 0 .51 .52"},
    {'.', "0.20 l .1 .01 .1 .02"},
    {'-', "0.52 l .06 .38 .46 .38"},
    {'+', "0.56 l .06 .38 .5 .38 l .28 .16 .28 .6"},
    {'/', "0.40 l .03 -.08 .37 1.06"},
    {'[', "0.26 l .24 1.08 .08 1.08 l .08 1.08 .08 -.18 l .08 -.18 .24 -.18"},
    {']', "0.26 l .02 1.08 .18 1.08 l .18 1.08 .18 -.18 l .18 -.18 .02 -.18"},
    {' ', "0.34"},
    {'a', "0.56 a .27 .34 .24 .34 0 360 l .51 .68 .51 0"},
    {'b', "0.56 l .05 1 .05 0 a .29 .34 .24 .34 0 360"},
    {'c', "0.50 a .28 .34 .25 .34 45 315"},
    {'d', "0.56 a .27 .34 .24 .34 0 360 l .51 1 .51 0"},
    {'e', "0.56 l .03 .36 .52 .36 a .28 .34 .25 .34 4 315"},
    {'f', "0.36 a .34 .79 .16 .22 75 180 l .18 .79 .18 0 l .03 .66 .35 .66"},
    {'g', "0.56 a .27 .34 .24 .34 0 360 l .51 .68 .51 -.08 a .27 -.08 .24 .22 0 -150"},
    {'h', "0.56 l .05 1 .05 0 a .28 .42 .23 .26 180 0 l .51 .42 .51 0"},
    {'i', "0.14 l .07 .68 .07 0 l .07 .93 .07 .94"},
    {'j', "0.20 l .13 .68 .13 -.1 a -.01 -.1 .14 .18 0 -90 l .13 .93 .13 .94"},
    {'k', "0.48 l .05 1 .05 0 l .44 .68 .05 .27 l .19 .41 .46 0"},
    {'l', "0.14 l .07 1 .07 0"},
    {'m',
     "0.84 l .05 .68 .05 0 a .23 .46 .18 .22 180 0 l .41 .46 .41 0 a .59 .46 .18 .22 180 0 l .77 "
     ".46 .77 0"},
    {'n', "0.56 l .05 .68 .05 0 a .28 .42 .23 .26 180 0 l .51 .42 .51 0"},
    {'o', "0.56 a .28 .34 .25 .34 0 360"},
    {'p', "0.56 l .05 .68 .05 -.3 a .29 .34 .24 .34 0 360"},
    {'q', "0.56 a .27 .34 .24 .34 0 360 l .51 .68 .51 -.3"},
    {'r', "0.36 l .05 .68 .05 0 a .27 .42 .22 .26 180 70"},
    {'s', "0.46 a .23 .51 .18 .17 40 270 a .23 .17 .2 .17 90 -145"},
    {'t', "0.36 l .17 .92 .17 .18 a .33 .18 .16 .18 180 275 l .02 .66 .34 .66"},
    {'u', "0.56 l .05 .68 .05 .26 a .28 .26 .23 .26 180 360 l .51 .68 .51 0"},
    {'v', "0.50 l .01 .68 .25 0 l .25 0 .49 .68"},
    {'w', "0.76 l 0 .68 .19 0 l .19 0 .38 .62 l .38 .62 .57 0 l .57 0 .76 .68"},
    {'x', "0.48 l .03 .68 .45 0 l .45 .68 .03 0"},
    {'y', "0.50 l .01 .68 .25 0 l .49 .68 .2 -.15 l .2 -.15 .06 -.28"},
    {'z', "0.48 l .04 .68 .44 .68 l .44 .68 .04 0 l .04 0 .45 0"}};

constexpr double gap = 0.14;     // between glyphs, as a fraction of a digit's height
constexpr double weight = 0.12;  // stroke width, as a fraction of a digit's height

struct Glyph {
  double width = 0.0;
  std::vector<std::pair<Vec2, Vec2>> segments;
};

Glyph parsed(const char* text) {
  std::istringstream in(text);
  Glyph glyph;
  in >> glyph.width;
  for (char kind; in >> kind;) {
    double v[6] = {};
    for (int i = 0; i < (kind == 'l' ? 4 : 6); ++i) in >> v[i];
    if (kind == 'l') {
      glyph.segments.push_back({Vec2(v[0], v[1]), Vec2(v[2], v[3])});
      continue;
    }
    const auto on_arc = [&](double share) {
      const double angle = (v[4] + share * (v[5] - v[4])) * 3.14159265358979323846 / 180.0;
      return Vec2(v[0] + v[2] * std::cos(angle), v[1] + v[3] * std::sin(angle));
    };
    constexpr int parts = 20;
    for (int i = 0; i < parts; ++i)
      glyph.segments.push_back({on_arc(static_cast<double>(i) / parts), on_arc((i + 1.0) / parts)});
  }
  return glyph;
}

const Glyph& glyph_of(char sign) {
  static const std::map<char, Glyph> glyphs = [] {
    std::map<char, Glyph> all;
    for (const auto& [name, text] : glyph_texts) all[name] = parsed(text);
    return all;
  }();
  const auto found = glyphs.find(sign);
  return found == glyphs.end() ? glyphs.at(' ') : found->second;
}

double distance(const Vec2& p, const Vec2& a, const Vec2& b) {
  const Vec2 d = b - a;
  const double t = std::clamp((p - a).dot(d) / std::max(d.squaredNorm(), 1e-12), 0.0, 1.0);
  return (p - a - t * d).norm();
}

}  // namespace

double text_width(const std::string& text, double height) {
  double width = 0.0;
  for (char sign : text) width += glyph_of(sign).width + gap;
  return text.empty() ? 0.0 : height * (width - gap);
}

void draw_text(Image& image, const std::string& text, double left, double baseline, double height,
               const Color& color) {
  const double half_stroke = std::max(0.55, 0.5 * weight * height);
  for (char sign : text) {
    const Glyph& glyph = glyph_of(sign);
    const int first_x = std::max(0, static_cast<int>(left - 2.0 - half_stroke));
    const int last_x = std::min(image.width - 1,
                                static_cast<int>(left + glyph.width * height + 2.0 + half_stroke));
    const int first_y = std::max(0, static_cast<int>(baseline - 1.2 * height - 2.0));
    const int last_y = std::min(image.height - 1, static_cast<int>(baseline + 0.4 * height + 2.0));
    for (int y = first_y; y <= last_y && !glyph.segments.empty(); ++y) {
      for (int x = first_x; x <= last_x; ++x) {
        const Vec2 p((x + 0.5 - left) / height, (baseline - y - 0.5) / height);
        double nearest = 1e9;
        for (const auto& [a, b] : glyph.segments) nearest = std::min(nearest, distance(p, a, b));
        const double cover = std::clamp(half_stroke + 0.5 - nearest * height, 0.0, 1.0);
        std::uint8_t* pixel = &image.rgb[3 * (static_cast<std::size_t>(y) * image.width + x)];
        for (int channel = 0; channel < 3; ++channel)
          pixel[channel] = static_cast<std::uint8_t>(
              std::lround(pixel[channel] + cover * (color[channel] - pixel[channel])));
      }
    }
    left += (glyph.width + gap) * height;
  }
}

}  // namespace loomstone
