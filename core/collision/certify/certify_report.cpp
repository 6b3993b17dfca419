#include "core/collision/certify/certify_report.h"

#include <algorithm>

namespace loomstone {

void CertifyReport::merge(const std::vector<WithheldMotion>& others) {
  std::vector<WithheldMotion> both(withheld.size() + others.size());
  const auto before = [](const WithheldMotion& a, const WithheldMotion& b) {
    return a.vertex < b.vertex;
  };
  std::merge(withheld.begin(), withheld.end(), others.begin(), others.end(), both.begin(), before);
  withheld.clear();
  for (const WithheldMotion& each : both) {
    if (withheld.empty() || withheld.back().vertex != each.vertex)
      withheld.push_back(each);
    else
      withheld.back().displacement += each.displacement;
  }
}

double CertifyReport::withheld_length() const {
  double sum = 0.0;
  for (const WithheldMotion& each : withheld) sum += each.displacement.norm();
  return sum;
}

double CertifyReport::withheld_moment() const {
  double sum = 0.0;
  for (const WithheldMotion& each : withheld) sum += each.mass * each.displacement.norm();
  return sum;
}

}  // namespace loomstone
