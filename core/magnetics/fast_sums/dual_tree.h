// Dual-tree traversal of a tree of observers and a tree of dipoles, starting at both roots. Pairs
// of cells that are far apart interact by expansions. In pairs of near leaves, the field of each
// dipole is evaluated at each observer [Dehnen2002].
#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <vector>

#include "core/magnetics/fast_sums/point_tree.h"
#include "core/magnetics/fast_sums/taylor_expansion.h"
#include "core/magnetics/sources/dipoles.h"

namespace loomstone {

// Largest number of subtrees of observers that are traversed as separate tasks. Neither the
// division into tasks nor the result of the traversal depends on the number of threads.
inline constexpr std::size_t most_tasks = 256;

// Returns `rows`, one for each point of a tree, in the order of this tree.
inline Points ordered(const ConstPointsRef& rows, const PointTree& tree) {
  Points out(rows.rows(), 3);
  for (std::size_t i = 0; i < tree.order.size(); ++i) out.row(i) = rows.row(tree.order[i]);
  return out;
}

// Tree of the source dipoles with the multipole moments of its cells.
struct SourceTree {
  PointTree tree;
  Points positions, moments;       // in the order of the tree [m], [A m^2]
  std::vector<double> expansions;  // multipole moments, `stride` numbers per cell; see expand()
  int stride = 0;

  // Computes the multipole moments of all cells.
  void expand(const Team& team, const TaylorExpansion& expansion) {
    if (stride == expansion.moments_size()) return;  // moments of this order are up to date
    stride = expansion.moments_size();
    expansions.assign(tree.cells.size() * stride, 0.0);
    // Cells are stored level by level.
    std::vector<Index> starts(tree.levels + 1, static_cast<Index>(tree.cells.size()));
    for (Index c = static_cast<Index>(tree.cells.size()) - 1; c >= 0; --c)
      starts[tree.cells[c].level] = c;
    for (int level = tree.levels - 1; level >= 0; --level) {
      parallel_for(
          team, starts[level + 1] - starts[level],
          [&](Index i) {
            const Index c = starts[level] + i;
            const PointCell& cell = tree.cells[c];
            double* out = expansions.data() + static_cast<std::size_t>(c) * stride;
            if (cell.leaf()) {
              const std::ptrdiff_t first = 3 * static_cast<std::ptrdiff_t>(cell.begin);
              expansion.add_dipoles(positions.data() + first, moments.data() + first,
                                    cell.end - cell.begin, cell.centre, out);
              return;
            }
            for (const Index child : cell.children)
              expansion.add_moments(moments_of(child), cell.centre - tree.cells[child].centre, out);
          },
          16);
    }
  }
  const double* moments_of(Index cell) const {
    return expansions.data() + static_cast<std::size_t>(cell) * stride;
  }
};

// A leaf `cell` of observers, the coefficients `local` of its local expansion, and the dipoles
// `near` that are summed directly.
struct LeafSums {
  const TaylorExpansion& expansion;
  const PointCell& cell;
  const double* local;
  DipoleTable near;
};

// One traversal of the observers' tree from its root. `write` receives the LeafSums of each visited
// leaf. `chosen` is non-zero for the cells to visit; if it is empty, all cells are visited.
template <class Write>
class DualTreeDescent {
 public:
  DualTreeDescent(const TaylorExpansion& expansion, const SourceTree& by,
                  const PointTree& observers, double opening,
                  const std::vector<std::uint8_t>& chosen, const Write& write)
      : expansion_(expansion),
        by_(by),
        observers_(observers),
        opening_(opening),
        chosen_(chosen),
        write_(write) {}

  void run(const Team& team) const {
    std::deque<Visit> open;
    std::vector<Visit> tasks;
    open.push_back({0, {0}, std::vector<double>(expansion_.local_size())});
    Scratch scratch;
    while (!open.empty() && open.size() + tasks.size() < most_tasks) {
      Visit visit = std::move(open.front());
      open.pop_front();
      if (observers_.cells[visit.cell].leaf())
        tasks.push_back(std::move(visit));
      else
        for (Visit& child : opened(visit, scratch)) open.push_back(std::move(child));
    }
    for (Visit& visit : open) tasks.push_back(std::move(visit));
    parallel_tasks(team, static_cast<Index>(tasks.size()), [&](Index i) {
      Scratch own;
      descend(tasks[i], own);
    });
  }

 private:
  // A cell of observers, the cells of dipoles that have not interacted with it yet, and its local
  // expansion so far.
  struct Visit {
    Index cell;
    std::vector<Index> candidates;
    std::vector<double> local;
  };
  struct Scratch {
    std::vector<Index> open, near, deferred;
    std::vector<TaylorExpansion::Far> far;
    std::vector<double> positions, moments;
  };

  // Classifies the candidates of a cell as far, near or deferred to its children. Two cells that
  // are not far apart are near if both are leaves. If only one is a leaf, the other is opened. If
  // neither is a leaf, the one with the larger radius is opened, or both if the radii are equal.
  // If both trees are the same, two cells thus interact in both directions or not at all.
  void sort(const Visit& visit, Scratch& s) const {
    const PointCell& mine = observers_.cells[visit.cell];
    s.open = visit.candidates;
    s.near.clear();
    s.deferred.clear();
    s.far.clear();
    for (std::size_t i = 0; i < s.open.size(); ++i) {
      const Index other = s.open[i];
      const PointCell& cell = by_.tree.cells[other];
      const Vec3 arm = mine.centre - cell.centre;
      const double reach = mine.radius + cell.radius;
      if (reach * reach < opening_ * opening_ * arm.squaredNorm()) {
        s.far.push_back({by_.moments_of(other), {arm[0], arm[1], arm[2]}});
      } else if (cell.leaf()) {
        (mine.leaf() ? s.near : s.deferred).push_back(other);
      } else if (mine.leaf() || cell.radius > mine.radius) {
        s.open.insert(s.open.end(), cell.children, cell.children + 2);
      } else if (mine.radius > cell.radius) {
        s.deferred.push_back(other);
      } else {
        s.deferred.insert(s.deferred.end(), cell.children, cell.children + 2);
      }
    }
  }

  void add_far(Visit& visit, const Scratch& s) const {
    if (!s.far.empty())
      expansion_.add_far(s.far.data(), static_cast<Index>(s.far.size()), visit.local.data());
    expansion_.complete(visit.local.data());
  }

  std::vector<Visit> opened(Visit& visit, Scratch& s) const {
    sort(visit, s);
    add_far(visit, s);
    const PointCell& cell = observers_.cells[visit.cell];
    std::vector<Visit> children;
    for (const Index child : cell.children) {
      if (!chosen_.empty() && !chosen_[child]) continue;
      children.push_back({child, s.deferred, std::vector<double>(expansion_.local_size())});
      const Vec3 shift = observers_.cells[child].centre - cell.centre;
      expansion_.add_local(visit.local.data(), shift, children.back().local.data());
    }
    return children;
  }

  void descend(Visit& visit, Scratch& s) const {
    const PointCell& cell = observers_.cells[visit.cell];
    if (!cell.leaf()) {
      for (Visit& child : opened(visit, s)) descend(child, s);
      return;
    }
    sort(visit, s);
    add_far(visit, s);
    s.positions.clear();
    s.moments.clear();
    for (const Index other : s.near) {
      const PointCell& near = by_.tree.cells[other];
      const std::ptrdiff_t begin = 3 * static_cast<std::ptrdiff_t>(near.begin);
      const std::ptrdiff_t end = 3 * static_cast<std::ptrdiff_t>(near.end);
      s.positions.insert(s.positions.end(), by_.positions.data() + begin,
                         by_.positions.data() + end);
      s.moments.insert(s.moments.end(), by_.moments.data() + begin, by_.moments.data() + end);
    }
    const DipoleTable near{s.positions.data(), s.moments.data(),
                           static_cast<Index>(s.positions.size() / 3)};
    write_(LeafSums{expansion_, cell, visit.local.data(), near});
  }

  const TaylorExpansion& expansion_;
  const SourceTree& by_;
  const PointTree& observers_;
  double opening_;
  const std::vector<std::uint8_t>& chosen_;
  const Write& write_;
};

}  // namespace loomstone
