// SPDX-License-Identifier: GPL-3.0-or-later
// How an answer is marked.
//
// A statement is a verdict NAMED, SENSOR, or AMBIGUOUS over a group of at most three. A larger
// group is no answer. A statement holds where it names what hides, or its group does; otherwise it
// is a wrong name, an AMBIGUOUS group that lacks the truth included, for it denies the truth.
// internal_friction and strain_dependent_friction are one law (sigma_max = a + b |eps|) with and
// without b: where one hides the other holds too. Where the rate is hidden (Question::rate_hidden)
// only a group with viscosity and a friction law holds. Of a pair both must be held, each by a
// statement.
#pragma once

#include <string>
#include <vector>

#include "tests/twin/exam/answer.h"
#include "tests/twin/exam/question.h"

namespace tenter::exam {

enum class Grade {
  right,        ///< something holds and nothing is wrong; on null twins: nothing was stated;
                ///< on foreign ones: UNEXPLAINED, and nothing NAMED or SENSOR
  partly,       ///< something holds, and something is wrong or one of a pair is missed
  overclaimed,  ///< the right name, stated with more certainty than the captures give
  missed,       ///< nothing stated; foreign: neither named nor reported as unexplained
  wrong,        ///< only wrong names; null: a false alarm; foreign: a name was given
  no_answer,    ///< the diagnosis failed
};
const char* grade_name(Grade grade);

struct Mark {
  Grade grade = Grade::no_answer;
  std::vector<std::string> holding;       ///< lines of the statements that hold
  std::vector<std::string> held;          ///< which of the truths they hold, each once
  std::vector<std::string> wrong_names;   ///< NAMED or SENSOR, ids
  std::vector<std::string> wrong_groups;  ///< leaders of AMBIGUOUS groups that lack the truth
  bool certain = false;                   ///< holds as NAMED or SENSOR, not only in a group
  bool unexplained = false;               ///< UNEXPLAINED was among the verdicts
  bool resolved = false;  ///< with the capture that it asked for: certain, and nothing wrong
};

Mark mark(const Question& question, const Answer& answer);

/// Whether a statement of `named` is right where `truth` hides.
bool counts_as(const std::string& named, const std::string& truth);

}  // namespace tenter::exam
