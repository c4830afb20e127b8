// SPDX-License-Identifier: GPL-3.0-or-later
// Backward: which of the effects that were added may go again, and those that must.
//
// Each function takes effects out of `accepted`, refits `current` without them, and writes the
// steps and their reasons into the diagnosis. A refit that fails leaves its effect where it is and
// says so in the checklist.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "server/diagnosis/diagnose.h"

namespace tenter::diagnosis {

struct Accepted {
  Trial trial;
  double before_chi2 = 0.0;                  ///< of the model that it was added to
  std::array<double, 2> taken = {0.0, 0.0};  ///< of that, from stresses, from stretches
  std::vector<Trial> rivals;                 ///< other effects of the same round, best first
};

/// The effect as it came in: added to `before`.
Accepted added_to(const Reference& before, Trial trial, const Diagnosis& d);

/// Whether what a trial adds to `current` is no more than what the form of the effects that were
/// found may miss of those channels, stresses or stretches, in which it shows most. An exact effect
/// that leaves nothing is not: what a form misses has a form of its own.
std::string objection_of_form(const Trial& trial, const Reference& current,
                              const std::vector<Accepted>& accepted, const Diagnosis& d);

/// A step of the path, with the error on all rows that the fit at `at` has.
PathStep step_of(const std::string& action, const std::string& effect, const std::string& why,
                 const Reference& at, const Diagnosis& d);

/// What a failed refit leaves undone is said: the effect stays without having been asked again.
void could_not_refit_without(Diagnosis& d, const std::string& id, const Error& error);

/// What later additions made needless goes.
void go_backward(Diagnosis& d, Reference& current, std::vector<Accepted>& accepted);

/// Where the model still misses more than the noise, an effect that explained little of what was
/// missed when it came in is a stand-in for something that the catalogue lacks: it gets no name.
/// `d.extended` and `d.last_screen` are those of `current`.
void drop_stand_ins(Diagnosis& d, Reference& current, std::vector<Accepted>& accepted);

/// Many effects, and the first, which is the best one alone, explained little of what they explain
/// together: terms of a series for something that the catalogue lacks, and none gets a name.
void drop_series(Diagnosis& d, Reference& current, std::vector<Accepted>& accepted);

/// Of two paths to the same data, one of which was found before these were weighed anew, the one
/// that the information criterion prefers: `current` and `accepted`, or the effects `found` with
/// the model `first`, which is fitted again then, one effect after the other.
void keep_better_path(Diagnosis& d, const Reference& first, std::vector<Accepted> found,
                      Reference& current, std::vector<Accepted>& accepted);

}  // namespace tenter::diagnosis
