// Frames in HDF5 (VTKHDF temporal PolyData that ParaView opens), readable and right at any moment
// of a killed run.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/base/frame.h"

namespace loomstone {

// Writes run.vtkhdf (all cloth) and bodies.vtkhdf (bodies and obstacles, where there are any) into
// a directory.
class FrameWriter {
 public:
  // Creates the files (under another name, then renamed); `metadata` is free text (JSON) kept
  // beside the frames.
  FrameWriter(const std::string& directory, const FrameTopology& topology,
              const std::string& metadata);
  // Continues a run: its whole frames and reports up to and including `after_time` [s] are copied
  // into new files, which then replace the old ones.
  static FrameWriter reopen(const std::string& directory, double after_time);
  ~FrameWriter();
  FrameWriter(FrameWriter&&) noexcept;
  FrameWriter& operator=(FrameWriter&&) noexcept;
  void write(
      const Frame& frame);  // throws CacheError (disk full, ...), earlier frames stay readable
  void record(
      const StepReport& report);  // of every step; reaches the file with the next frame or flush()
  void flush();  // call it before a checkpoint, so that a resumed run has all reports up to it
  int n_frames() const;

 private:
  FrameWriter();
  struct Data;
  std::unique_ptr<Data> data_;
};

class FrameReader {
 public:
  // `path`: directory or run.vtkhdf. Throws CacheError for missing, truncated, foreign or newer
  // files.
  explicit FrameReader(const std::string& path);
  ~FrameReader();
  FrameReader(FrameReader&&) noexcept;
  FrameReader& operator=(FrameReader&&) noexcept;
  int n_frames() const;
  const FrameTopology& topology() const;
  const std::string& metadata() const;
  const std::vector<double>& times() const;
  Frame frame(int index) const;
  std::vector<StepReport> reports() const;  // of all steps recorded

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace loomstone
