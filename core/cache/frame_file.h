// Frames in HDF5 (VTKHDF temporal PolyData that ParaView opens), readable and right at any moment of a killed run.
#pragma once

#include <memory>
#include <string>

#include "core/base/frame.h"

namespace loomstone {

// Writes run.vtkhdf (all cloth) and bodies.vtkhdf (bodies and obstacles, where there are any) into a directory.
class FrameWriter {
 public:
  // Creates the files (under another name, then renamed); `metadata` is free text (JSON) kept as an attribute.
  // With `append`, existing files are reopened, rows past the last whole frame trimmed, frames later than `after` dropped.
  FrameWriter(const std::string& directory, const FrameTopology& topology, const std::string& metadata);
  static FrameWriter reopen(const std::string& directory, double after_time);
  ~FrameWriter();
  FrameWriter(FrameWriter&&) noexcept;
  void write(const Frame& frame);   // throws CacheError (disk full, ...), earlier frames stay readable
  int n_frames() const;

 private:
  FrameWriter();
  struct Data;
  std::unique_ptr<Data> data_;
};

class FrameReader {
 public:
  // `path`: directory or run.vtkhdf. Throws CacheError for missing, truncated, foreign or newer files.
  explicit FrameReader(const std::string& path);
  ~FrameReader();
  FrameReader(FrameReader&&) noexcept;
  int n_frames() const;
  const FrameTopology& topology() const;
  const std::string& metadata() const;
  const std::vector<double>& times() const;
  Frame frame(int index) const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace loomstone
