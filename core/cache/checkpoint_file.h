// A checkpoint: named arrays and texts that hold a State exactly. Written under another name and renamed.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace loomstone {

struct Checkpoint {
  struct Array {
    std::vector<std::int64_t> shape;
    std::vector<double> values;
  };
  std::map<std::string, Array> arrays;
  std::map<std::string, std::vector<std::int64_t>> integers;
  std::map<std::string, std::vector<unsigned char>> bytes;
  std::map<std::string, std::string> texts;
};

void write_checkpoint(const std::string& path, const Checkpoint& checkpoint);
Checkpoint read_checkpoint(const std::string& path);  // throws CacheError naming what is wrong

}  // namespace loomstone
