// Frames in HDF5 files (VTKHDF, temporal PolyData), which ParaView can open. If the run is killed,
// FrameReader still reads all complete frames. Other programs may show wrong values in the last
// frames if the run is killed during a flush (hdf5_driver.h).
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/base/frame.h"

namespace loomstone {

// Writes run.vtkhdf (all cloth) and bodies.vtkhdf (bodies and obstacles, if there are any) to a
// directory.
class FrameWriter {
 public:
  // Creates the files under temporary names and then renames them. `metadata` is any text, such as
  // JSON, that is stored with the frames. `compression` is the deflate level, from 0 (none) to 9
  // (smallest files, slowest writing).
  FrameWriter(const std::string& directory, const FrameTopology& topology,
              const std::string& metadata, int compression = 0);
  // Continues a run. Copies its complete frames with times up to and including `after_time` [s] to
  // new files, which then replace the old ones.
  static FrameWriter reopen(const std::string& directory, double after_time);
  ~FrameWriter();
  FrameWriter(FrameWriter&&) noexcept;
  FrameWriter& operator=(FrameWriter&&) noexcept;
  // Writes a frame. Throws InvalidInput if the frame does not fit the topology or the number of
  // coil currents of the first frame, and CacheError if writing fails, for example because the disk
  // is full. Earlier frames remain readable.
  void write(const Frame& frame);
  int n_frames() const;

 private:
  FrameWriter();
  struct Data;
  std::unique_ptr<Data> data_;
};

class FrameReader {
 public:
  // `path` is the directory of a run or the path of its run.vtkhdf. Throws CacheError if files are
  // missing or damaged, if they are not the files of one run of loomstone, or if this build cannot
  // read their format.
  explicit FrameReader(const std::string& path);
  ~FrameReader();
  FrameReader(FrameReader&&) noexcept;
  FrameReader& operator=(FrameReader&&) noexcept;
  int n_frames() const;
  const FrameTopology& topology() const;
  const std::string& metadata() const;
  int compression() const;
  const std::vector<double>& times() const;
  Frame frame(int index) const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace loomstone
