#include "core/base/choice.h"

#include <algorithm>
#include <numeric>

#include "core/base/message.h"

namespace loomstone {

namespace {

// Levenshtein distance: the smallest number of single-letter insertions, deletions and replacements
// that turn `a` into `b`.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + 1, row[j + 1] + 1});
    }
  }
  return row.back();
}

// Returns the name closest to `given`, or an empty string if no name is close. A name is close if
// its edit distance from `given` is at most one, or at most a third of the length of `given`. If
// the name is a prefix of `given` or vice versa, and `given` has at least two letters, the distance
// counts as one.
std::string_view near_miss(const std::vector<std::string_view>& names, std::string_view given) {
  std::string_view best;
  std::size_t least = std::max<std::size_t>(1, given.size() / 3) + 1;
  for (const std::string_view name : names) {
    const bool begins = given.size() >= 2 && (name.starts_with(given) || given.starts_with(name));
    const std::size_t distance = begins ? 1 : edit_distance(given, name);
    if (distance < least) best = name, least = distance;
  }
  return best;
}

}  // namespace

std::string choices_text(const std::vector<std::string_view>& names,
                         const std::vector<std::string_view>& meanings) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) {
    text += (i == 0 ? "" : " | ") + std::string(names[i]);
    if (!meanings[i].empty()) text += " (" + std::string(meanings[i]) + ")";
  }
  return text;
}

void throw_no_choice(std::string_view where, const std::vector<std::string_view>& names,
                     std::string_view given) {
  std::string list;
  for (const std::string_view name : names) list += (list.empty() ? "" : " | ") + std::string(name);
  const std::string_view near = near_miss(names, given);
  const std::string hint =
      near.empty() ? "choose one of them" : formatted("did you mean \"{}\"?", near);
  fail<InvalidInput>("{} must be one of {}, got \"{}\"; {}", where, list, given, hint);
}

}  // namespace loomstone
