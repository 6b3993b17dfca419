// Finds a part of a scene, such as a cloth or a body, by its name. Parts of a scene refer to each
// other by name.
#pragma once

#include <string>

#include "core/base/message.h"

namespace loomstone {

// Returns the index of the entry of `list` whose name is `name`. If there is none, throws
// InvalidInput with the names of all entries. The message begins with `where`, the place of `name`
// in the user's input, for example "attachments[0].cloth".
template <class List>
std::size_t find_by_name(const List& list, const std::string& name, const std::string& where) {
  std::string known;
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (list[i].name == name) return i;
    known += (known.empty() ? "\"" : ", \"") + list[i].name + "\"";
  }
  if (known.empty())
    fail<InvalidInput>("{} must be an existing name, got \"{}\", but there are no names", where,
                       name);
  fail<InvalidInput>("{} must be one of the names {}, got \"{}\"", where, known, name);
}

}  // namespace loomstone
