// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/twin/exam/question.h"

#include <algorithm>
#include <sstream>
#include <utility>

#include "tests/twin/hidden_effects.h"
#include "tests/twin/random.h"
#include "tests/twin/sheets/sheet_effects.h"
#include "tests/twin/suite.h"

namespace tenter::exam {
namespace {

bool hides_rate(const std::string& suite) {
  if (twin::is_sheet_suite(suite)) return !twin::traits_of(suite).has_rates;
  return suite == "single_rate" || suite == "no_time";
}

bool can_show(const std::string& suite, const twin::HiddenEffect& effect) {
  if (effect.needs_specimens && !twin::has_specimens(suite)) return false;
  if (suite == "knit_like") return !effect.needs_loops;
  if (suite == "no_time") return !effect.needs_time || is_rate_question(effect.id);
  return true;
}

/// An effect as questions know it, of curves or of sheets.
struct Hideable {
  std::string id;
  std::vector<std::string> variants;
  bool foreign = false;
};

/// All that a suite can show.
std::vector<Hideable> hideable_in(const std::string& suite) {
  std::vector<Hideable> list;
  if (twin::is_sheet_suite(suite)) {
    for (const twin::SheetEffect& effect : twin::sheet_effects())
      if (twin::can_show(twin::traits_of(suite), effect))
        list.push_back({effect.id, effect.variants, effect.foreign});
    return list;
  }
  for (const twin::HiddenEffect& effect : twin::hidden_effects())
    if (can_show(suite, effect)) list.push_back({effect.id, effect.variants, effect.foreign});
  return list;
}

std::vector<std::string> forms_of(const Hideable& effect) {
  std::vector<std::string> forms;
  for (const std::string& variant : effect.variants) {
    const std::string name = effect.id + ":" + variant;
    if (std::find(forms.begin(), forms.end(), name) == forms.end()) forms.push_back(name);
  }
  if (forms.empty()) forms.push_back(effect.id);
  return forms;
}

/// Pairs of which a twin can be made and whose halves are two names.
bool can_pair(const std::string& a, const std::string& b) {
  const auto are = [&](const char* one, const char* other) {
    return (a == one && b == other) || (a == other && b == one);
  };
  return !are("anisotropy", "poisson_coupling") &&
         !are("internal_friction", "strain_dependent_friction");
}

struct Pair {
  Hideable first, second;
};

/// All pairs that a suite can show, in an order drawn by the seed.
std::vector<Pair> shuffled_pairs(const Paper& paper, const std::string& suite) {
  const std::vector<Hideable> effects = hideable_in(suite);
  const auto may_hide = [&](const Hideable& effect) {
    const bool asked =
        paper.effects.empty() ||
        std::find(paper.effects.begin(), paper.effects.end(), effect.id) != paper.effects.end();
    return asked && !effect.foreign;
  };
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < effects.size(); ++i)
    for (std::size_t j = i + 1; j < effects.size(); ++j)
      if (may_hide(effects[i]) && may_hide(effects[j]) && can_pair(effects[i].id, effects[j].id))
        pairs.push_back({effects[i], effects[j]});
  twin::Random order(twin::stream_seed(paper.first_seed, suite + " pairs"));
  for (std::size_t i = pairs.size(); i > 1; --i)
    std::swap(pairs[i - 1], pairs[static_cast<std::size_t>(order.below(static_cast<int>(i)))]);
  return pairs;
}

void add_pairs(const Paper& paper, const std::string& suite, std::vector<Question>& questions) {
  if (paper.pairs <= 0) return;
  const std::vector<Pair> pairs = shuffled_pairs(paper, suite);
  if (pairs.empty()) return;
  for (const double size : paper.sizes) {
    for (int turn = 0; turn < paper.pairs; ++turn) {
      const auto t = static_cast<std::size_t>(turn);
      const Pair& pair = pairs[t % pairs.size()];
      Question question;
      question.kind = Kind::pair;
      question.twin.size = size;
      question.twin.suite = suite;
      question.twin.seed = paper.first_seed + t;
      for (const Hideable& effect : {pair.first, pair.second}) {
        const std::vector<std::string> forms = forms_of(effect);
        question.truths.push_back(effect.id);
        question.twin.effects.push_back(forms[t % forms.size()]);
        question.rate_hidden |= hides_rate(suite) && is_rate_question(effect.id);
      }
      questions.push_back(std::move(question));
    }
  }
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

bool is_rate_question(const std::string& id) {
  return id == "internal_friction" || id == "strain_dependent_friction" || id == "viscosity";
}

std::string Question::truth() const {
  std::string words;
  for (const std::string& id : truths) words += (words.empty() ? "" : " + ") + id;
  return words;
}

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
    if (!twin::is_sheet_suite(suite) && std::find(known.begin(), known.end(), suite) == known.end())
      return bad_input("there is no suite '" + suite + "'");
  }
  for (const std::string& id : paper.effects)
    if (twin::find_hidden_effect(id) == nullptr && twin::find_sheet_effect(id) == nullptr)
      return bad_input("the twins know no effect '" + id + "'");

  std::vector<Question> questions;
  for (const std::string& suite : paper.suites) {
    for (const Hideable& effect : hideable_in(suite)) {
      const bool asked = paper.effects.empty()
                             ? paper.foreign || !effect.foreign
                             : std::find(paper.effects.begin(), paper.effects.end(), effect.id) !=
                                   paper.effects.end();
      if (!asked) continue;
      const std::vector<std::string> forms = forms_of(effect);
      for (const double size : paper.sizes) {
        for (int turn = 0; turn < paper.seeds; ++turn) {
          Question question;
          question.kind = effect.foreign ? Kind::foreign : Kind::effect;
          question.truths = {effect.id};
          question.twin.effects = {forms[static_cast<std::size_t>(turn) % forms.size()]};
          question.twin.size = size;
          question.twin.suite = suite;
          question.twin.seed = paper.first_seed + static_cast<std::uint64_t>(turn);
          question.rate_hidden = hides_rate(suite) && is_rate_question(effect.id);
          questions.push_back(std::move(question));
        }
      }
    }
    add_pairs(paper, suite, questions);
    for (int turn = 0; turn < paper.nulls; ++turn) {
      Question question;
      question.kind = Kind::null;
      question.twin = null_twin(suite, turn, paper.first_seed + static_cast<std::uint64_t>(turn));
      questions.push_back(std::move(question));
    }
  }
  for (Question& question : questions) {
    question.resolve = paper.resolve;
    question.compare = paper.compare;
  }
  return questions;
}

}  // namespace tenter::exam
