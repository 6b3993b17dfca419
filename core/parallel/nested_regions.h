// Keeps outside libraries from opening parallel regions of their own while one of these lives.
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
