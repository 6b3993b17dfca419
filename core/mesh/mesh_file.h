// Reads and writes triangle meshes. The extension selects the format: .obj (Wavefront) or .ply
// (Stanford). Read other formats in Python (meshio, trimesh).
#pragma once

#include <string>

#include "core/mesh/triangle_mesh.h"

namespace loomstone {

// OBJ: v, vt, f (v, v/vt, v//vn, v/vt/vn, negative indices); other statements are skipped. PLY:
// text and binary; rest coordinates from vertex properties s t, u v or texture_u texture_v, or from
// a face list texcoord. Polygons are cut into fans from their first corner. If with_uv is false,
// rest coordinates in the file are ignored: surfaces of obstacles and bodies need none, and texture
// coordinates in the wild often fold or vanish.
// Throws CacheError naming file and line for a file that cannot be read, is cut short or malformed;
// InvalidInput naming file and item for a mesh that TriangleMesh refuses; Unsupported for another
// extension.
TriangleMesh read_mesh(const std::string& path, bool with_uv = true);

// Reading a written file gives the same bits. PLY is binary (little endian) unless `text`; OBJ is
// always text. The file is written under another name and then renamed, so a file of this name is
// complete or absent. In PLY, rest coordinates that differ along seams go into the face list
// texcoord, so reading renumbers uv indices.
void write_mesh(const std::string& path, const TriangleMesh& mesh, bool text = false);

}  // namespace loomstone
