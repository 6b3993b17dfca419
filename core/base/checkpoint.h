// The contents of a checkpoint: the state of a simulation as named arrays of numbers, lists of
// integers, strings, and blocks of bytes.
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

}  // namespace loomstone
