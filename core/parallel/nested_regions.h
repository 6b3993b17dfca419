// While a NoNestedRegions object exists, OpenMP parallel regions of the thread that created it, for
// example in other libraries, run on one thread.
#pragma once

namespace loomstone {

class NoNestedRegions {
 public:
  NoNestedRegions();
  ~NoNestedRegions();
  NoNestedRegions(const NoNestedRegions&) = delete;
  NoNestedRegions& operator=(const NoNestedRegions&) = delete;

 private:
  int levels_;
};

}  // namespace loomstone
