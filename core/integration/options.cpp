#include "core/integration/options.h"

#include <vector>

namespace loomstone {

namespace {

// Sets `found` to the default options of the scheme called `name`, and appends the names of all
// schemes to `names`. Returns false if no scheme has this name.
template <class... Method>
bool find(std::string_view name, std::variant<Method...>& found,
          std::vector<std::string_view>& names) {
  (names.push_back(Method::name), ...);
  return ((Method::name == name && (found = Method{}, true)) || ...);
}

}  // namespace

IntegratorOptions integrator_named(std::string_view name) {
  IntegratorOptions::Methods found;
  std::vector<std::string_view> names;
  if (!find(name, found, names)) throw_no_choice("integrator", names, name);
  return std::visit([](const auto& method) { return IntegratorOptions(method); }, found);
}

}  // namespace loomstone
