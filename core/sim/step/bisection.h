// A step that fails is taken again in halves: where the solver finds no solution, where
// certification leaves impacts or withholds much of the motion, and where strain limits that held
// at the start do not hold at the end.
#pragma once

#include <cstdint>
#include <vector>

namespace loomstone {

// A part of a step, in 64ths of it.
struct StepPart {
  static constexpr int whole = 64, quarter = 16, least = 1;
  int first = 0, last = whole;
  int length() const { return last - first; }
};

// The goals that an attempt at a part missed.
struct PartResult {
  bool solved = true;               // the solver found a solution
  std::int64_t impacts = 0;         // left by certification
  bool withheld_much = false;       // certification withheld much of the motion
  bool broke_limits = false;        // strain limits that held at the start do not hold at the end
  bool stopped_for_limits = false;  // the cloth lost much of its motion so that its limits hold
};

// The parts of a step in order, and whether an attempt is accepted. Decides from results alone.
class Bisection {
 public:
  // limits_in_solve: strain limits act in the implicit solve, not by sweeps alone.
  explicit Bisection(bool limits_in_solve) : limits_in_solve_(limits_in_solve) {}

  bool done() const { return left_.empty(); }
  StepPart part() const { return left_.back(); }  // to be attempted

  enum class Verdict { Accepted, Halved };
  // Accepted: the part is done and the next one follows. Halved: its halves take its place.
  Verdict judge(const PartResult& result);

 private:
  // A cause of failure halves parts until one of the least length fails for it. From then on the
  // rest of the step is accepted with what that cause leaves undone.
  enum class Answer { Halve, Accept };

  bool limits_in_solve_;
  Answer impacts_ = Answer::Halve, limits_ = Answer::Halve, withheld_ = Answer::Halve;
  std::vector<StepPart> left_ = {StepPart{}};  // the last comes first
};

}  // namespace loomstone
