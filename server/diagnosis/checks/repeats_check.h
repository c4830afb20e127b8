// SPDX-License-Identifier: GPL-3.0-or-later
// A/A check: one repeat as the model of another must raise nothing (design, step 5).
//
// The readings of a repeat less those of the next at the same strain hold no effect that the
// repeats share; screened against the null twins they must stay below the threshold. What is above
// it either differs from repeat to repeat or is a threshold that is too low for this noise. First
// runs are kept apart where there are three or more. Of n pairs each is allowed 5 % / n of false
// alarms. Under three repeats the twins are drawn from the very difference in question: no check.
// Costs n (at most four) small screens.
#pragma once

#include <string>

#include "server/diagnosis/diagnose.h"

namespace tenter::diagnosis {

struct RepeatsCheck {
  int repeats = 0;       ///< of the largest group, without its first run
  int pairs = 0;         ///< held against each other; none under three repeats
  double ratio = 0.0;    ///< largest of the screens
  double allowed = 1.0;  ///< for a false alarm rate of 5 % over all pairs
  std::string effect;    ///< with the largest ratio
  std::string variant;   ///< of it, in words
  bool raised() const { return pairs > 0 && ratio > allowed; }
};

RepeatsCheck check_repeats(const Reference& at, const DataPointer& data,
                           const estimation::Noise& noise, const Excitation& excitation,
                           unsigned long long seed);

/// Its line of the checklist.
void report_repeats(Diagnosis& d, const RepeatsCheck& check);

}  // namespace tenter::diagnosis
