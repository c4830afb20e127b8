// SPDX-License-Identifier: GPL-3.0-or-later
// What the examination asks: one twin each, and which answer would be right.
//
//   Expected<std::vector<Question>> paper = set_questions({.sizes = {3, 10}, .seeds = 3, .nulls =
//   20});
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/base/error.h"
#include "tests/twin/generator.h"

namespace tenter::exam {

enum class Kind {
  effect,   ///< something of the catalogue hides
  pair,     ///< two of the catalogue at once
  null,     ///< nothing hides
  foreign,  ///< something hides that the catalogue lacks
};

struct Question {
  Kind kind = Kind::effect;
  std::vector<std::string> truths;  ///< ids of what hides, none in a null twin
  twin::TwinCase twin;
  /// No time, or one rate without a hold: friction and viscosity look the same, and the right
  /// answer is a group that holds both.
  bool rate_hidden = false;
  bool compare = false;  ///< with the model that is extended by what hides
  bool resolve = false;  ///< an AMBIGUOUS answer gets the capture that it asks for

  std::string truth() const;  ///< "viscosity", "outliers + plastic_set", "" for a null twin
  std::string name() const;   ///< "rich viscosity:maxwell size 3 seed 2"
};

/// Effects that only a second rate or a hold tells from each other.
bool is_rate_question(const std::string& id);

struct Paper {
  std::vector<std::string> effects;  ///< ids; empty: all that the twins can hide
  std::vector<double> sizes = {3.0, 10.0};
  std::vector<std::string> suites = {"rich"};
  int seeds = 3;  ///< of each effect and size; variants take turns
  int nulls = 0;  ///< null twins in each suite
  bool foreign = false;
  bool compare = false;  ///< errors on left-out data with those of the true model
  bool resolve = false;  ///< AMBIGUOUS answers get the capture that they ask for
  int pairs = 0;  ///< twins in which two effects hide, in each suite and size; drawn by the seed
  std::uint64_t first_seed = 1;
};

/// Leaves out what a suite cannot show at all: loops where unloading was not recorded, drifts and
/// delays where there is no time. Fails on an unknown effect or suite.
Expected<std::vector<Question>> set_questions(const Paper& paper);

}  // namespace tenter::exam
