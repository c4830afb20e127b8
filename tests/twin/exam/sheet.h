// SPDX-License-Identifier: GPL-3.0-or-later
// The results of an examination: figures against their targets, recall by effect, confusion matrix,
// failures.
#pragma once

#include <iosfwd>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tests/twin/exam/answer.h"
#include "tests/twin/exam/mark.h"
#include "tests/twin/exam/question.h"

namespace tenter::exam {

struct Entry {
  Question question;
  Answer answer;
  Mark mark;
};

/// A share with its target, e.g. 133 of 140 against at least 0.95.
struct Figure {
  std::string name;
  int count = 0;
  int of = 0;
  std::optional<double> at_least, at_most;
  std::optional<double> mean;  ///< judged instead of the share, where there is one

  double share() const { return of > 0 ? static_cast<double>(count) / of : 0.0; }
  bool met() const;  ///< nothing asked: met
};

/// Effects that the generator could not make at least 0.8 of the size asked for count towards wrong
/// names, not towards recall; neither do sizes below 3 (design/diagnosis.md, "How it is proved").
std::vector<Figure> figures(const std::vector<Entry>& entries);

/// Curves and sheets apart, of each kind that there is: "curves" and "sheets".
std::vector<std::pair<std::string, std::vector<Entry>>> apart(const std::vector<Entry>& entries);

/// Of curves and of sheets apart.
void write_table(const std::vector<Entry>& entries, std::ostream& out);

/// Every answer that is not right, one paragraph each: question, verdicts, path.
void write_failures(const std::vector<Entry>& entries, std::ostream& out);

void write_json(const std::vector<Entry>& entries, std::ostream& out);

}  // namespace tenter::exam
