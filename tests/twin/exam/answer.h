// SPDX-License-Identifier: GPL-3.0-or-later
// What the diagnosis answers to a question, in the words of its verdicts.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/base/error.h"
#include "tests/twin/exam/question.h"

namespace tenter::exam {

struct Said {
  std::string verdict;  ///< "NAMED", "AMBIGUOUS", ... as on the wire
  std::string effect;   ///< id, "" where none
  std::vector<std::string> alternatives;
  double size = 0.0;  ///< share of the force
  double size_lo = 0.0;
  double size_hi = 0.0;

  /// The effect and its alternatives, each once.
  std::vector<std::string> group() const;
  std::string line() const;  ///< "AMBIGUOUS viscosity|internal_friction 2.1 %"
};

struct Answer {
  std::vector<Said> said;
  std::vector<std::string> path;  ///< additions and rejections, one line each
  std::string trouble;            ///< why there is no answer, "" where there is one
  double achieved_size = 0.0;     ///< of what hides (the smaller of two), as it could be made
  double true_share = 0.0;        ///< of the force, where one effect hides; 0: not known
  double noise_floor = 0.0;
  double error_before = 0.0;
  double error_after = 0.0;
  std::optional<double> held_out_before, held_out_after;
  std::optional<double> held_out_truth;  ///< of the model extended by what hides, where asked
  double unexplained_share = 0.0;
  double seconds = 0.0;
  /// Of an AMBIGUOUS answer where that was asked: the capture it proposes, "" where none can be
  /// done, and what is said with that capture beside the others.
  bool was_ambiguous = false;
  std::string proposed;
  std::vector<Said> said_next;

  std::string line() const;  ///< all verdicts but NOT_EXCITED
};

/// Makes the twin and diagnoses it on one thread; what fails is in `trouble`.
Answer ask(const Question& question);

}  // namespace tenter::exam
