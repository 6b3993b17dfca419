// Divides a step into parts. A part that fails is repeated in two halves. A part fails if the
// solver finds no solution, if certification leaves impacts, or if strain limits that are satisfied
// at its start are exceeded at its end. It also fails if certification and fallbacks, or fallbacks
// alone, withhold too much motion (see PartResult). If the solver finds no solution for 1/64 of the
// step, the step fails. For each other cause, there is a shortest length, 1/64 or a quarter of the
// step: a part that is not longer is accepted despite this cause. A part whose error is too large,
// or which creates too much energy or loses too much of the work of scripts, is repeated with a
// shorter length.
#pragma once

#include <cstdint>
#include <vector>

namespace loomstone {

// A part of a step, in units of 1/64 of the step.
struct StepPart {
  static constexpr int whole = 64, quarter = 16, least = 1;
  int first = 0, last = whole;
  int length() const { return last - first; }
};

// The result of an attempt at a part.
struct PartResult {
  bool solved = true;               // the solver found a solution
  int longest = StepPart::whole;    // length allowed by error and energy [1/64 step]
  bool gains_energy = false;        // too much energy has been created
  std::int64_t impacts = 0;         // impacts that remain after certification
  bool withheld_much = false;       // certification and fallbacks withheld over 10 % of the motion
  bool broke_limits = false;        // limits satisfied at the start are exceeded at the end
  bool stopped_for_limits = false;  // fallbacks alone withheld over 1 % of the motion
};

// Divides a step into parts and decides whether an attempt is accepted. The decision depends only
// on the lengths of parts, the results of attempts and limits_in_solve.
class Bisection {
 public:
  // limits_in_solve: strain limits act in the implicit solve, not only in sweeps.
  explicit Bisection(bool limits_in_solve) : limits_in_solve_(limits_in_solve) {}

  bool done() const { return left_.empty(); }
  StepPart part() const { return left_.back(); }  // the part to attempt next

  // Splits the next part in two if it is longer than `longest` >= 1 [1/64 step]. The first piece is
  // 1/n of the part, rounded down, where n is the length of the part divided by `longest`, rounded
  // up.
  void shorten(int longest);

  enum class Verdict { Accepted, Repeated };
  // Decides on the result of an attempt at part(). Accepted: the next part follows. Repeated:
  // shorter parts replace this part.
  Verdict judge(const PartResult& result);

 private:
  // Response to one cause of failure. Parts are halved until a part of the shortest length that is
  // permitted for this cause fails. This part and later parts of this step are then accepted
  // despite this cause.
  enum class Answer { Halve, Accept };

  bool limits_in_solve_;
  Answer impacts_ = Answer::Halve, limits_ = Answer::Halve, withheld_ = Answer::Halve;
  std::vector<StepPart> left_ = {StepPart{}};  // the next part is at the back
};

}  // namespace loomstone
