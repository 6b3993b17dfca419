// Triangle meshes from and to files. The ending of the name decides: .obj (Wavefront) or .ply
// (Stanford). Other formats go through Python (meshio, trimesh).
#pragma once

#include <string>

#include "core/mesh/triangle_mesh.h"

namespace loomstone {

// OBJ: v, vt, f (v, v/vt, v//vn, v/vt/vn, negative indices); everything else is skipped. PLY: text
// and binary; rest coordinates from vertex properties s t, u v or texture_u texture_v, or from a
// face list texcoord. Polygons are cut into fans from their first corner. With `with_uv` false rest
// coordinates in the file are not looked at: surfaces of obstacles and bodies need none, and
// texture coordinates in the wild often fold or vanish. Throws CacheError naming file and line for
// a file that cannot be read, is cut short or malformed; InvalidInput naming file and item for a
// mesh that TriangleMesh refuses; Unsupported for another ending.
TriangleMesh read_mesh(const std::string& path, bool with_uv = true);

// Numbers are written so that reading gives back the same bits. PLY is binary (little endian)
// unless `text`; OBJ is always text. Written beside under another name first, then renamed: a file
// of this name is whole or absent. In PLY rest coordinates that differ along seams go into the face
// list texcoord, so uv indices are renumbered on reading.
void write_mesh(const std::string& path, const TriangleMesh& mesh, bool text = false);

}  // namespace loomstone
