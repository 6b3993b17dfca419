// A small synthetic run. Every number of a frame depends only on the index of the frame and on the
// place of the number in the frame, so that each part of a file can be checked alone.
#pragma once

#include <string>

#include "core/base/frame.h"
#include "core/cache/frame_file.h"

namespace loomstone::testing {

// A new temporary directory. The destructor removes it with its content.
class TemporaryDirectory {
 public:
  TemporaryDirectory();
  TemporaryDirectory(const TemporaryDirectory&) = delete;
  ~TemporaryDirectory();
  const std::string& path() const { return path_; }
  std::string operator/(const std::string& name) const { return path_ + "/" + name; }

 private:
  std::string path_;
};

// Topology of two cloths of side x side vertices each. In the arrays, the second cloth follows the
// first one. If `with_bodies` is true, the bodies are a tetrahedron and a floor.
FrameTopology example_topology(int side, bool with_bodies);
Frame example_frame(const FrameTopology& topology, int index);

// Writes the example frame `index`.
void write_example(FrameWriter& writer, const FrameTopology& topology, int index);

// These functions return whether a and b are equal. Arrays must have the same bits. Coil currents
// are not compared.
bool same(const FrameTopology& a, const FrameTopology& b);
bool same(const Frame& a, const Frame& b);

}  // namespace loomstone::testing
