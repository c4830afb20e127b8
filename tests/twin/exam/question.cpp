// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/twin/exam/question.h"

#include <algorithm>
#include <sstream>

#include "tests/twin/hidden_effects.h"
#include "tests/twin/suite.h"

namespace tenter::exam {
namespace {

bool is_rate_question(const std::string& id) {
  return id == "internal_friction" || id == "strain_dependent_friction" || id == "viscosity";
}

bool hides_rate(const std::string& suite) {
  return suite == "single_rate" || suite == "no_time";
}

bool can_show(const std::string& suite, const twin::HiddenEffect& effect) {
  if (suite == "knit_like") return !effect.needs_loops;
  if (suite == "no_time") return !effect.needs_time || is_rate_question(effect.id);
  return true;
}

std::vector<std::string> forms_of(const twin::HiddenEffect& effect) {
  std::vector<std::string> forms;
  for (const std::string& variant : effect.variants) {
    const std::string name = effect.id + ":" + variant;
    if (std::find(forms.begin(), forms.end(), name) == forms.end()) forms.push_back(name);
  }
  if (forms.empty()) forms.push_back(effect.id);
  return forms;
}

/// The same null in the light of each baseline.
twin::TwinCase null_twin(const std::string& suite, int turn, std::uint64_t seed) {
  twin::TwinCase twin;
  twin.suite = suite;
  twin.seed = seed;
  if (turn % 4 == 2) twin.effects = {"anisotropy"};
  if (turn % 4 == 3) twin.effects = {"poisson_coupling"};
  return twin;
}

}  // namespace

std::string Question::name() const {
  std::ostringstream words;
  words << twin.suite << " ";
  if (kind == Kind::null) words << "null ";
  for (const std::string& effect : twin.effects) words << effect << " ";
  if (kind != Kind::null) words << "size " << twin.size << " ";
  words << "seed " << twin.seed;
  return words.str();
}

Expected<std::vector<Question>> set_questions(const Paper& paper) {
  for (const std::string& suite : paper.suites) {
    const auto& known = twin::suite_names();
    if (std::find(known.begin(), known.end(), suite) == known.end())
      return bad_input("there is no suite '" + suite + "'");
  }
  for (const std::string& id : paper.effects)
    if (twin::find_hidden_effect(id) == nullptr)
      return bad_input("the twins know no effect '" + id + "'");

  std::vector<Question> questions;
  for (const std::string& suite : paper.suites) {
    for (const twin::HiddenEffect& effect : twin::hidden_effects()) {
      const bool asked = paper.effects.empty()
                             ? paper.foreign || !effect.foreign
                             : std::find(paper.effects.begin(), paper.effects.end(), effect.id) !=
                                   paper.effects.end();
      if (!asked || !can_show(suite, effect)) continue;
      const std::vector<std::string> forms = forms_of(effect);
      for (const double size : paper.sizes) {
        for (int turn = 0; turn < paper.seeds; ++turn) {
          Question question;
          question.kind = effect.foreign ? Kind::foreign : Kind::effect;
          question.truth = effect.id;
          question.twin.effects = {forms[static_cast<std::size_t>(turn) % forms.size()]};
          question.twin.size = size;
          question.twin.suite = suite;
          question.twin.seed = paper.first_seed + static_cast<std::uint64_t>(turn);
          question.rate_hidden = hides_rate(suite) && is_rate_question(effect.id);
          questions.push_back(std::move(question));
        }
      }
    }
    for (int turn = 0; turn < paper.nulls; ++turn) {
      Question question;
      question.kind = Kind::null;
      question.twin = null_twin(suite, turn, paper.first_seed + static_cast<std::uint64_t>(turn));
      questions.push_back(std::move(question));
    }
  }
  return questions;
}

}  // namespace tenter::exam
