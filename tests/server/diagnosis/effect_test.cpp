// SPDX-License-Identifier: GPL-3.0-or-later
// The catalogue and how models are edited by it.
#include "server/diagnosis/effect.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "common/model/document.h"
#include "common/model/presets.h"
#include "server/diagnosis/trials/model_edit.h"
#include "tests/server/diagnosis/prepared_twin.h"

namespace tenter::diagnosis {
namespace {

struct Ground {
  Prepared prepared;
  Excitation excitation;
};

/// One for each baseline that the twins start from.
const std::vector<Ground>& grounds() {
  static const std::vector<Ground> all = [] {
    std::vector<Ground> list;
    for (const std::vector<std::string>& effects :
         {std::vector<std::string>{}, {"anisotropy"}, {"poisson_coupling"}, {"specimen_scatter"}}) {
      const bool of_many = effects == std::vector<std::string>{"specimen_scatter"};
      Ground g;
      g.prepared = testing::prepared_twin(
          {.effects = effects, .suite = of_many ? "specimens" : "rich", .seed = 3}, 15);
      g.excitation = examine(g.prepared.data->curves);
      list.push_back(std::move(g));
    }
    return list;
  }();
  return all;
}

/// Residuals of a model at its own values.
Eigen::VectorXd residuals_of(const model::Model& model, const DataPointer& data) {
  auto evaluator = estimation::Evaluator::make(model, data);
  EXPECT_TRUE(evaluator) << (evaluator ? "" : evaluator.error().message);
  Eigen::VectorXd residuals;
  if (!evaluator) return residuals;
  EXPECT_EQ(evaluator->evaluate(estimation::parameter_values(model), residuals, nullptr),
            mechanics::PathStatus::ok);
  return residuals;
}

template <class Visit>
void for_every_variant(Visit visit) {
  for (const Ground& ground : grounds())
    for (const Effect& effect : catalogue()) {
      const model::Model& model = ground.prepared.baseline.model;
      if (effect.not_excited(model, ground.excitation)) continue;
      for (const Variant& variant : effect.variants(model, ground.excitation)) {
        visit(ground, effect, variant, variant.grid.empty() ? Setting() : variant.grid.front());
        if (variant.grid.size() > 1) visit(ground, effect, variant, variant.grid.back());
      }
    }
}

/// Of a strip of which nobody saw how it narrows, fibres across the diagonals tell nothing.
TEST(Places, ADiagonalNeedsWhatStretchesIt) {
  const auto has_diagonal = [](const Excitation& excitation, const model::Model& model) {
    return std::ranges::any_of(places(model, excitation, true),
                               [](const Place& place) { return place.name == "diagonal"; });
  };
  const Ground& ground = grounds().front();
  const model::Model& model = ground.prepared.baseline.model;
  EXPECT_TRUE(has_diagonal(ground.excitation, model));
  Excitation strip = ground.excitation;
  for (estimation::Curves& curves : strip.curves) {
    curves.path.is_free = {false, true, false};
    for (Eigen::Vector3d& q : curves.path.q) q[2] = 0.0;
    std::erase_if(curves.channels, [](const auto& channel) { return !channel.is_stress; });
  }
  EXPECT_FALSE(has_diagonal(strip, model));
  strip.curves.front().path.is_free[1] = false;
  EXPECT_TRUE(has_diagonal(strip, model));
}

TEST(Effect, ChangesNothingWhenOff) {
  std::set<std::string> seen;
  for_every_variant([&](const Ground& ground, const Effect& effect, const Variant& variant,
                        const Setting& setting) {
    const Reference& baseline = ground.prepared.baseline;
    model::Model extended = extend(baseline.model, variant, setting, effect.id);
    estimation::adapt_spline_ranges(extended, ground.prepared.data->curves);
    const Eigen::VectorXd residuals = residuals_of(extended, ground.prepared.data);
    ASSERT_EQ(residuals.size(), baseline.fit.residuals.size());
    ASSERT_GT(baseline.fit.residuals.cwiseAbs().maxCoeff(), 1.0);
    EXPECT_LT((residuals - baseline.fit.residuals).cwiseAbs().maxCoeff(), 1e-7)
        << effect.id << ", " << variant.words;
    seen.insert(effect.id);
  });
  EXPECT_GE(seen.size(), 12U);
}

TEST(Effect, AddsFreeParametersThatTheDataMove) {
  std::set<std::string> ids;
  for_every_variant([&](const Ground& ground, const Effect& effect, const Variant& variant,
                        const Setting& setting) {
    const model::Model& model = ground.prepared.baseline.model;
    const model::Model extended = extend(model, variant, setting, effect.id);
    EXPECT_GT(free_count(extended), free_count(model)) << effect.id << ", " << variant.words;
    for (const auto& [address, value] : setting) {
      const auto names = estimation::parameter_names(extended);
      EXPECT_NE(std::find(names.begin(), names.end(), address), names.end()) << address;
    }
  });
}

TEST(Without, GivesTheBaselineBack) {
  for_every_variant([&](const Ground& ground, const Effect& effect, const Variant& variant,
                        const Setting& setting) {
    // growth of friction lives in another effect's terms; freed parameters stay where they are
    if (!variant.unfix.empty()) return;
    const model::Model& model = ground.prepared.baseline.model;
    const model::Model extended = extend(model, variant, setting, effect.id);
    EXPECT_TRUE(holds(extended, effect.id)) << effect.id;
    const model::Model back = without(extended, effect.id, model);
    EXPECT_FALSE(holds(back, effect.id)) << effect.id;
    EXPECT_EQ(estimation::parameter_names(back), estimation::parameter_names(model));
    EXPECT_EQ(estimation::parameter_values(back), estimation::parameter_values(model));
    ASSERT_EQ(back.terms.size(), model.terms.size());
    for (std::size_t t = 0; t < model.terms.size(); ++t)
      EXPECT_EQ(back.terms[t].law.name, model.terms[t].law.name) << effect.id;
  });
}

/// Said by checks, not by extensions.
const std::set<std::string> kChecked = {"outliers", "load_cell_quantisation", "mesh_resolution",
                                        "solver_tolerance", "wrong_basin"};

/// A sheet that all of its measures are strained on, and a cloth of constant stiffness.
struct EvenSheet {
  model::Model model = *model::preset("cloth_stvk");
  Excitation excitation;

  EvenSheet() {
    excitation.sheet.emplace();
    excitation.sheet->hi_m = {0.2, 0.1};
    for (const model::Term& term : model.terms)
      excitation.sheet->ranges[measure_key(term.strain)] = {0.0, 0.05};
    excitation.sheet->captures = {"pull"};
  }
  std::vector<Variant> variants(const char* effect) const {
    return variants_of(*find_effect(effect), model, excitation);
  }
};

TEST(Heterogeneity, IsOfOneDirectionOrOfAllAndThenOfMorePlaces) {
  EvenSheet sheet;
  const std::vector<Variant> few = sheet.variants("heterogeneity");
  ASSERT_EQ(few.size(), 4U);
  EXPECT_EQ(few[0].append.size(), 9U);
  const Variant& all = few[3];
  ASSERT_EQ(all.append.size(), 27U);
  sheet.model = extend(sheet.model, all, {}, "heterogeneity");
  double lo = 1e300, hi = 0.0;
  for (model::Term& term : sheet.model.terms) {
    if (term.effect != "heterogeneity" || !term.id.starts_with("patch_weft")) continue;
    const double k = 100.0 + 20.0 * term.support.sample;
    set_parameter(term.law, "k", k);
    lo = std::min(lo, k);
    hi = std::max(hi, k);
  }
  const std::vector<Variant> many = sheet.variants("heterogeneity");
  ASSERT_EQ(many.size(), 1U);
  EXPECT_EQ(many[0].append.size(), 75U);
  EXPECT_EQ(many[0].replace.size(), 27U);
  for (const auto& [id, law] : many[0].replace) {
    EXPECT_EQ(law.parameters.front().value, 0.0) << id;
    EXPECT_TRUE(law.parameters.front().fixed) << id;
  }
  // they start from what the few say, which grows along u and then along v
  const auto start = [&](int place) { return many[0].append[place].law.parameters.front().value; };
  EXPECT_GT(start(0), lo - 1e-9);
  EXPECT_LT(start(24), hi + 1e-9);
  EXPECT_NEAR(start(12), 0.5 * (lo + hi), 1e-6 * hi);
  EXPECT_GT(start(24), start(0));
  sheet.model = extend(sheet.model, many[0], {}, "heterogeneity");
  EXPECT_TRUE(sheet.variants("heterogeneity").empty());
}

TEST(CameraScale, OfASheetIsAboutItsMiddleOrAPlaceOfItsOwn) {
  const std::vector<Variant> variants = EvenSheet().variants("camera_scale");
  ASSERT_EQ(variants.size(), 2U);
  ASSERT_EQ(variants[1].corrections.size(), 2U);
  EXPECT_TRUE(variants[1].parts_are_one);
  int free = 0;
  for (const model::Parameter& p : variants[1].corrections[1].parameters)
    if (!p.fixed) {
      EXPECT_TRUE(p.name.starts_with("shift_")) << p.name;
      EXPECT_EQ(p.value, 0.0);
      ++free;
    }
  EXPECT_EQ(free, 3);
}

TEST(PlainForm, IsTakenWhereNothingOfTheSharperOneIsThere) {
  Reference at;
  at.model = *model::preset("cloth_stvk");
  at.model.terms.push_back(new_term(at.model, "friction_weft", "green_u", 0.0, "dahl"));
  at.model.terms.back().effect = "strain_dependent_friction";
  const auto names = estimation::parameter_names(at.model);
  const auto count = static_cast<Eigen::Index>(names.size());
  at.fit.parameters = Eigen::VectorXd::Constant(count, 1.0);
  at.fit.std_error = Eigen::VectorXd::Constant(count, 0.7);
  at.fit.states.assign(names.size(), estimation::ParameterState::free);
  const Effect& effect = *find_effect("strain_dependent_friction");
  const auto plain = in_plain_form(at, effect);
  ASSERT_TRUE(plain);
  EXPECT_TRUE(holds(*plain, "internal_friction"));
  EXPECT_FALSE(holds(*plain, effect.id));
  for (const model::Parameter& p : plain->terms.back().law.parameters)
    if (p.name == "b" || p.name == "c") {
      EXPECT_EQ(p.value, 0.0);
      EXPECT_TRUE(p.fixed);
    }
  at.fit.std_error.setConstant(0.3);  // the growth is surely there
  EXPECT_FALSE(in_plain_form(at, effect));
  EXPECT_FALSE(in_plain_form(at, *find_effect("internal_friction")));
}

TEST(Catalogue, EveryRowOfWordsIsScreenedOrChecked) {
  std::set<std::string> ids;
  for (const Effect& effect : catalogue()) {
    EXPECT_TRUE(ids.insert(effect.id).second) << effect.id;
    EXPECT_EQ(find_effect(effect.id), &effect);
    EXPECT_FALSE(kChecked.contains(effect.id)) << effect.id;
    const effects::Row* row = effects::find(effect.id);
    ASSERT_NE(row, nullptr) << effect.id;
    EXPECT_EQ(effect.words, row->words);
    EXPECT_NE(effect.kind, effects::Kind::numerical) << effect.id;
  }
  EXPECT_GE(ids.size(), 13U);
  EXPECT_EQ(find_effect("gremlins"), nullptr);
  ids.insert(kChecked.begin(), kChecked.end());
  for (const Effect& effect : sheet_catalogue()) {
    ids.insert(effect.id);
    ASSERT_NE(find_effect(effect.id), nullptr) << effect.id;
    EXPECT_EQ(find_effect(effect.id)->words, effect.words);
  }
  for (const effects::Row& row : effects::catalogue())
    EXPECT_TRUE(ids.contains(row.id)) << row.id << " has words and nothing finds it";
}

TEST(Examine, SaysWhatTheCapturesExcite) {
  const Excitation& rich = grounds().front().excitation;
  EXPECT_TRUE(rich.has_clock && rich.has_rate && rich.has_unloading && rich.has_repeated_loading);
  EXPECT_TRUE(rich.splits_rate());
  EXPECT_GT(rich.weft, 0.02);
  EXPECT_GT(rich.warp, 0.02);
  const Excitation timeless =
      examine(testing::prepared_twin({.suite = "no_time", .seed = 3}, 15).data->curves);
  EXPECT_FALSE(timeless.has_clock);
  EXPECT_FALSE(timeless.splits_rate());
  EXPECT_FALSE(examine({}).has_clock);
}

}  // namespace
}  // namespace tenter::diagnosis
