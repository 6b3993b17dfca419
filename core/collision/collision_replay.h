// Repeats the searches for contacts and impacts in a recorded motion, and measures their work on
// one thread. From these measurements, core/parallel/pool_replay.h predicts times on many ranks.
// perform() measures times on actual ranks instead.
#pragma once

#include <memory>
#include <vector>

#include "core/collision/broad_phase/decomposition.h"
#include "core/collision/model/collision_model.h"
#include "core/parallel/communicator.h"
#include "core/parallel/pool_replay.h"
#include "core/parallel/team.h"

namespace loomstone {

class SharedSearch;

// Motion of all surfaces, as certification receives it.
struct CollisionRecord {
  // CollisionStage stores at most this many positions in `earlier`. With fewer, lists are newer
  // than in a simulation. Our choice.
  static constexpr std::size_t most_earlier = 16;

  std::vector<CollisionSurface> surfaces;
  Triangles triangles;
  double gap_floor = 0.0;  // upper bound of gap_floor() [m], see CollisionModel
  Points x0, x1;           // [m]
  // Positions at the starts of the preceding motions, the oldest first [m]. May be empty.
  std::vector<Points> earlier = {};
};

class CollisionReplay {
 public:
  // Before the first motion of the record, vertices are assumed to have moved as in that motion.
  // Throws InvalidInput if the numbers and indices of vertices and triangles are inconsistent, if
  // positions or gap_floor are not finite, or if gap_floor is negative.
  explicit CollisionReplay(CollisionRecord record);
  ~CollisionReplay();

  // The two searches of a step: for contacts at its start, and for impacts in its motion.
  enum class Search { Contacts, Impacts };

  // Measures the tests of a search that is divided among `n_ranks` ranks. Each cost is the smallest
  // of `repetitions` measurements. In dynamic division, the tests with which the ranks start are
  // distributed so that the total cost of these tests and of those that follow from them is about
  // the same on each rank. The costs for this distribution are measured in an earlier motion of
  // the record. In static division, the top-level tests are dealt to the ranks in turn. Throws
  // InvalidInput if `n_ranks` or `repetitions` is less than 1, and Unsupported if `decomposition`
  // is Predicted.
  RecordedTests measure(Search search, int n_ranks, Decomposition decomposition,
                        int repetitions = 3) const;

  // Measures the work on neighbour lists in both searches of a step. Each list belongs to two
  // clusters (see ClusterOwners), and a piece of an OrderedWork is the work on all lists with the
  // same first cluster. The pieces are sorted by surface pair, then by first cluster. The searches
  // of the earlier motions are performed first. As in a simulation, the expected costs are those
  // between the last two searches for cluster pairs. Each measured cost is the smallest of
  // `repetitions` measurements. Throws InvalidInput if `repetitions` is below 1.
  struct Lists {
    OrderedWork contacts, impacts;
  };
  Lists measure_lists(int repetitions = 3) const;

  // Threads and ranks on which perform() performs a search, and how they divide the search.
  struct Execution {
    Decomposition decomposition;
    Traversal traversal;
    Team team;
    std::shared_ptr<const Communicator> communicator;
  };
  // Collective. Performs a search `repetitions` times. Returns, for each repetition, the largest
  // time that a rank needs from the end of its first refit until it has all results [s]; see
  // SharedSearch::seconds(). Throws InvalidInput if `repetitions` is less than 1, and Unsupported
  // if execution.decomposition is Predicted.
  std::vector<double> perform(Search search, const Execution& execution, int repetitions) const;

 private:
  std::size_t find(Search search, const Team& team, SharedSearch& shared,
                   int motions_ago = 0) const;

  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace loomstone
