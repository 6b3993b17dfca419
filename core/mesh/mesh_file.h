// Reads and writes triangle meshes. The extension selects the format: .obj (Wavefront) or .ply
// (Stanford). The Python package reads and writes other formats. No library is used for OBJ and
// PLY, because seams of panels need several uv at one vertex, and errors should give the position
// in the file.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "core/mesh/triangle_mesh.h"

namespace loomstone {

// Reads a mesh. In OBJ files, only the statements v, vt and f are read (f with v, v/vt, v//vn or
// v/vt/vn, also with negative indices). PLY files may be text or binary. They can contain rest
// coordinates as vertex properties (s t, u v or texture_u texture_v) or as the list property
// texcoord of each face. Polygons are split by split_polygon() (polygons.h). If with_uv is false,
// rest coordinates in the file are ignored: obstacles and bodies without a texture need none, and
// folded or degenerate texture coordinates would be rejected. Throws CacheError if the file cannot
// be read, or if it is truncated or malformed; where possible, the message then gives the position
// in the file. Throws InvalidInput if TriangleMesh rejects the mesh, and Unsupported for other
// extensions.
TriangleMesh read_mesh(const std::string& path, bool with_uv = true);

// Colours in a mesh file. OBJ files can contain materials, and PLY files colours of vertices.
struct MeshColors {
  std::string library;  // name of the file (.mtl) that describes the materials
  // Names of materials, each with its first triangle, in ascending order of these triangles.
  std::vector<std::pair<Index, std::string>> materials;
  std::vector<std::array<std::uint8_t, 3>> vertices;  // (n) red, green and blue in sRGB, or empty
};

// Writes a mesh. Reading the file restores positions and uv exactly. PLY is binary (little endian)
// unless `text` is set; OBJ is always text. The file is written under a temporary name and then
// renamed, so an incomplete file never has the given name. PLY stores the uv as vertex properties
// if each vertex has exactly one uv and the uv are in the order of the vertices. Otherwise, it
// stores them in the face list texcoord, and reading renumbers them. Throws InvalidInput for
// colours that the format cannot contain or that do not match the mesh, Unsupported for other
// extensions, and CacheError if the file cannot be written.
void write_mesh(const std::string& path, const TriangleMesh& mesh, bool text = false,
                const MeshColors& colors = {});

}  // namespace loomstone
