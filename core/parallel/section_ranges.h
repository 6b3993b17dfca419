// Division, among ranks, of pieces of work that form sections. Each section with a large fraction
// of the total cost is cut into one contiguous range for each rank. All other sections are cut
// together: they are joined and cut like one section. Each rank thus gets about an equal part of
// every expensive section. If the work has several phases, this balances each of them, provided
// that the cost of a section is distributed over its pieces in the same proportions in all phases.
#pragma once

#include <cstddef>
#include <vector>

namespace loomstone {

// Section s consists of the pieces first[s] to first[s + 1] - 1.
using SectionStarts = std::vector<std::size_t>;

// For each section, the first piece of each range, followed by the end of the section:
// (sections) x (ranges + 1).
using SectionRanges = std::vector<std::vector<std::size_t>>;

SectionRanges section_ranges(const std::vector<float>& costs, const SectionStarts& first,
                             int n_ranges);

// Like section_ranges() above, for as many ranges as `present` has. Keeps a boundary of `present`
// if the cost between it and the new boundary is at most `tolerance` times the mean cost per range
// of the sections that are cut together, and if it does not precede the boundary before it.
SectionRanges section_ranges(const std::vector<float>& costs, const SectionStarts& first,
                             const SectionRanges& present, double tolerance);

// Returns the imbalance of ranges [1]: A / B. A is the sum, over all groups of sections that are
// cut together, of the cost of the most expensive range of the group. A section that is cut
// separately is a group, too. B is the mean cost per rank. The imbalance is 1 if, in every group,
// all ranges cost the same. It is also 1 without ranges or costs.
double imbalance(const std::vector<float>& costs, const SectionStarts& first,
                 const SectionRanges& ranges);

}  // namespace loomstone
