// SPDX-License-Identifier: GPL-3.0-or-later
// Pulls whose laws are written otherwise than those that the diagnosis knows, as a specimen's are.
#include <gtest/gtest.h>

#include <set>
#include <string>

#include "common/capture/csv/csv_import.h"
#include "common/model/presets.h"
#include "server/diagnosis/diagnose.h"

namespace tenter::diagnosis {
namespace {

struct Pull {
  const char* capture;
  const char* baseline;
  std::set<std::string> hidden;  ///< all that may be named, or stand in a group
};

const Pull kPulls[] = {
    {"friction_beside_offset", "soft_constraints", {"internal_friction", "load_cell_offset"}},
    {"relaxing_tissue", "soft_constraints_spline", {"viscosity"}},
    {"nothing", "soft_constraints", {}},
    {"noise_that_grows", "soft_constraints_spline", {}},
    {"set", "soft_constraints", {"plastic_set"}},
    {"set_beside_curvature", "stvk_diagonal", {"plastic_set"}},
    {"softening", "soft_constraints", {"first_cycle_softening"}},
    {"product_of_strains", "soft_constraints", {"poisson_coupling"}},
    {"stick_slip", "soft_constraints", {}},
    {"drift", "stvk_diagonal_spline", {"load_cell_drift"}},
    {"cord", "soft_constraints_spline", {"cord_friction"}},
    {"cord_beside_misreadings", "soft_constraints_spline", {"cord_friction", "outliers"}},
    {"stairs", "soft_constraints_spline", {}},
    {"uneven_noise", "soft_constraints_spline", {}},
    // nothing can be left out: a group
    {"loading_only", "soft_constraints", {"load_cell_drift", "load_cell_offset"}},
};

class OtherLaws : public ::testing::TestWithParam<Pull> {};

TEST_P(OtherLaws, AreNamedRightlyOrNotAtAll) {
  const Pull& pull = GetParam();
  const std::string path = std::string(TENTER_TEST_DATA "/other_laws/") + pull.capture;
  auto capture = capture::import_csv(path + ".csv", path + ".json");
  ASSERT_TRUE(capture) << capture.error().message;
  Request request;
  request.captures.emplace_back(pull.capture, std::move(*capture));
  request.model = model::preset(pull.baseline).value();
  Control control;
  control.threads = 2;
  const auto d = diagnose(request, control);
  ASSERT_TRUE(d) << d.error().message;
  std::set<std::string> found;
  for (const Verdict& verdict : d->verdicts) {
    EXPECT_NE(verdict.kind, VerdictKind::numerical) << verdict.words;
    const bool is_name = verdict.kind == VerdictKind::named || verdict.kind == VerdictKind::sensor;
    if (!is_name && verdict.kind != VerdictKind::ambiguous) continue;
    std::set<std::string> group(verdict.alternatives.begin(), verdict.alternatives.end());
    if (is_name) group.clear();
    group.insert(verdict.effect);
    EXPECT_LE(group.size(), 3U) << verdict.words;
    const std::size_t before = found.size();
    for (const std::string& id : group)
      if (pull.hidden.contains(id)) found.insert(id);
    EXPECT_GT(found.size(), before) << verdict.words;
  }
  EXPECT_EQ(found, pull.hidden);
}

INSTANTIATE_TEST_SUITE_P(All, OtherLaws, ::testing::ValuesIn(kPulls),
                         [](const auto& pull) { return std::string(pull.param.capture); });

}  // namespace
}  // namespace tenter::diagnosis
