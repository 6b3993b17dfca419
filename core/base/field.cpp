#include "core/base/field.h"

#include <sstream>

namespace loomstone {

std::string to_text(const Limits& limits) {
  std::ostringstream out;
  const bool has_low = std::isfinite(limits.low), has_high = std::isfinite(limits.high);
  if (has_low && has_high)
    out << (limits.low_open ? "in (" : "in [") << limits.low << ", " << limits.high << "]";
  else if (has_low)
    out << (limits.low_open ? "> " : ">= ") << limits.low;
  else if (has_high)
    out << "<= " << limits.high;
  else
    out << (limits.allow_infinite ? "a number" : "finite");
  return out.str();
}

void throw_outside_limits(const std::string& where, const char* name, const char* unit,
                          const Limits& limits, double value) {
  std::ostringstream out;
  out << where << (where.empty() ? "" : ".") << name << " must be " << to_text(limits);
  if (*unit) out << " [" << unit << "]";
  out << ", got " << value << "; correct this value";
  throw InvalidInput(out.str());
}

}  // namespace loomstone
