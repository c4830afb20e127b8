// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/uncertainty/profile.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "common/model/catalogue.h"
#include "server/estimation/uncertainty/caveats.h"

namespace tenter::estimation {
namespace {

/// Measured values of a curve with these parameters: a slope, an amplitude of either sign (seen by
/// its square), a rate that saturates, and one that nothing sees.
class Curve final : public ResidualFunction {
 public:
  Curve(std::vector<double> at, std::vector<double> measured)
      : at_(std::move(at)), measured_(std::move(measured)) {
    for (std::size_t i = 0; i < at_.size(); ++i)
      rows_.push_back({0, 0, static_cast<int>(i), static_cast<int>(i)});
  }
  int parameter_count() const override { return 4; }
  const std::vector<Row>& rows() const override { return rows_; }
  mechanics::PathStatus evaluate(const Eigen::VectorXd& p, Eigen::VectorXd& residuals,
                                 RowMatrix* jacobian) override {
    residuals.resize(row_count());
    if (jacobian != nullptr) jacobian->setZero(row_count(), 4);
    for (int i = 0; i < row_count(); ++i) {
      const double x = at_[static_cast<std::size_t>(i)];
      const double decay = std::exp(-p[2] * (x + 0.5));
      residuals[i] =
          p[0] * x + p[1] * p[1] * x * x + 3.0 * decay - measured_[static_cast<std::size_t>(i)];
      if (jacobian != nullptr)
        jacobian->row(i) << x, 2.0 * p[1] * x * x, -3.0 * (x + 0.5) * decay, 0.0;
    }
    return mechanics::PathStatus::ok;
  }

 private:
  std::vector<double> at_, measured_;
  std::vector<Row> rows_;
};

struct Case {
  model::Model model;
  std::vector<double> at, measured;
  MakeFunction make() const {
    return [*this] { return std::make_unique<Curve>(at, measured); };
  }
  FitResult fitted() {
    const FitResult found = fit(*make()(), model, {});
    store(found, model);
    return found;
  }
};

Case made(const std::vector<double>& truth) {
  Case c;
  c.model.name = "curve";
  for (const char* name : {"slope", "square", "rate", "unseen"}) {
    model::Term term;
    term.id = name;
    term.strain.name = "green_u";
    term.law.name = "linear";
    term.law.parameters = model::default_parameters(*model::find_law("linear"));
    term.law.parameters[0].lower.reset();
    c.model.terms.push_back(term);
  }
  const auto parameters = parameters_of(c.model);
  for (std::size_t i = 0; i < 4; ++i) parameters[i]->value = truth[i];
  parameters[2]->lower = 0.0;
  std::mt19937 random(4);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 40; ++i) {
    const double x = 0.1 * i;
    c.at.push_back(x);
    c.measured.push_back(truth[0] * x + truth[1] * truth[1] * x * x +
                         3.0 * std::exp(-truth[2] * (x + 0.5)) + normal(random));
  }
  return c;
}

TEST(Profile, OfAParabolaIsTheCovariance) {
  Case c = made({2.0, 1.0, 30.0, 1.0});
  for (const int i : {1, 2, 3}) parameters_of(c.model)[static_cast<std::size_t>(i)]->fixed = true;
  const FitResult found = c.fitted();
  const auto list = profiles(c.make(), c.model, found, {});
  ASSERT_EQ(list.size(), 1u);
  EXPECT_EQ(list[0].determined, Determined::bounded);
  ASSERT_TRUE(list[0].lo && list[0].hi);
  ASSERT_GT(found.std_error[0], 0.01);
  EXPECT_NEAR(*list[0].hi - found.parameters[0], 1.96 * found.std_error[0],
              0.02 * found.std_error[0]);
  EXPECT_NEAR(found.parameters[0] - *list[0].lo, 1.96 * found.std_error[0],
              0.02 * found.std_error[0]);
  EXPECT_LT(list[0].fits, 30);
}

TEST(Profile, HasAWordForEach) {
  Case c = made({2.0, 1.0, 30.0, 1.0});
  const FitResult found = c.fitted();
  ASSERT_TRUE(found.usable);
  const auto list = profiles(c.make(), c.model, found, {});
  ASSERT_EQ(list.size(), 4u);
  EXPECT_EQ(list[0].determined, Determined::bounded);
  EXPECT_LT(*list[0].lo, 2.0);
  EXPECT_GT(*list[0].hi, 2.0);
  EXPECT_EQ(list[1].determined, Determined::multimodal);  // minus it fits as well
  EXPECT_FALSE(list[1].found_better);
  EXPECT_EQ(list[2].determined, Determined::one_sided);  // fast enough is all that is known
  ASSERT_TRUE(list[2].lo);
  EXPECT_FALSE(list[2].hi);
  EXPECT_LT(*list[2].lo, 30.0);
  EXPECT_EQ(list[3].determined, Determined::flat);
  for (const Profile& profile : list)
    for (std::size_t k = 1; k < profile.points.size(); ++k)
      EXPECT_GE(profile.points[k].value, profile.points[k - 1].value);
}

TEST(Profile, SameBytesForAnyNumberOfThreads) {
  Case c = made({2.0, 1.0, 30.0, 1.0});
  const FitResult found = c.fitted();
  ProfileOptions options;
  const auto one = profiles(c.make(), c.model, found, {}, options);
  options.threads = 3;
  const auto three = profiles(c.make(), c.model, found, {}, options);
  ASSERT_EQ(one.size(), three.size());
  std::size_t points = 0;
  for (std::size_t i = 0; i < one.size(); ++i) {
    ASSERT_EQ(one[i].points.size(), three[i].points.size());
    EXPECT_EQ(one[i].lo, three[i].lo);
    EXPECT_EQ(one[i].hi, three[i].hi);
    for (std::size_t k = 0; k < one[i].points.size(); ++k, ++points) {
      EXPECT_EQ(one[i].points[k].value, three[i].points[k].value);
      EXPECT_EQ(one[i].points[k].rise, three[i].points[k].rise);
    }
  }
  EXPECT_GT(points, 30u);
}

// A model whose form is wrong has wider intervals than its rows' sigma would give.
TEST(Profile, IsWiderWhereTheFormIsWrong) {
  Case right = made({2.0, 1.0, 30.0, 1.0});
  for (const int i : {1, 2, 3})
    parameters_of(right.model)[static_cast<std::size_t>(i)]->fixed = true;
  Case wrong = right;
  for (std::size_t i = 0; i < wrong.measured.size(); ++i)
    wrong.measured[i] += 6.0 * std::sin(3.0 * wrong.at[i]);
  const FitResult found_right = right.fitted();
  const FitResult found_wrong = wrong.fitted();
  const auto a = profiles(right.make(), right.model, found_right, {});
  const auto b = profiles(wrong.make(), wrong.model, found_wrong, {});
  ASSERT_TRUE(a[0].lo && a[0].hi && b[0].lo && b[0].hi);
  EXPECT_GT(*b[0].hi - *b[0].lo, 3.0 * (*a[0].hi - *a[0].lo));
}

TEST(Caveats, NothingIsSilent) {
  Case c = made({2.0, 1.0, 0.0, 1.0});  // a rate at its bound
  parameters_of(c.model)[0]->fixed = true;
  c.model.terms[1].law.name = "hermite_stiffness";
  c.model.terms[1].law.range_hi = 0.5;
  c.model.strain_ranges = {{"square", 0.0, 0.2}};
  FitResult found = c.fitted();
  found.correlation = RowMatrix::Zero(4, 4);
  found.correlation(1, 3) = found.correlation(3, 1) = -0.97;
  FitOptions options;
  options.weights = Eigen::VectorXd::Ones(found.residuals.size());
  options.weights[5] = 0.0;
  Profile open;
  open.parameter = 1;
  open.determined = Determined::one_sided;
  open.lo = 0.4;
  const auto list = caveats(c.model, found, options, {open}, {{"pull", {3, 9}, "no equilibrium"}});
  const auto has = [&](CaveatKind kind, const std::string& subject, const std::string& part) {
    return std::any_of(list.begin(), list.end(), [&](const Caveat& caveat) {
      return caveat.kind == kind && caveat.subject == subject &&
             caveat.sentence.find(part) != std::string::npos;
    });
  };
  EXPECT_TRUE(has(CaveatKind::frozen, "slope.k", "held at 2"));
  EXPECT_TRUE(has(CaveatKind::zero_gradient, "unseen.k", "nothing in the data"));
  EXPECT_TRUE(has(CaveatKind::one_sided, "square.k", "at least 0.4"));
  EXPECT_TRUE(has(CaveatKind::correlated, "square.k", "unseen.k"));
  EXPECT_TRUE(has(CaveatKind::beyond_data, "square", "0 to 0.2"));
  EXPECT_TRUE(has(CaveatKind::dropped_frames, "pull", "3, 9"));
  EXPECT_TRUE(has(CaveatKind::rows_left_out, "curve", "1 of 40"));
  for (std::size_t i = 1; i < list.size(); ++i) EXPECT_LE(list[i - 1].kind, list[i].kind);
  EXPECT_EQ(words_of(CaveatKind::wrong_form), "wrong_form");
  EXPECT_EQ(words_of(CaveatKind::gains_work), "gains_work");
}

}  // namespace
}  // namespace tenter::estimation
