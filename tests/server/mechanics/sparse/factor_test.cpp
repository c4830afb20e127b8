// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/sparse/factor.h"

#include <gtest/gtest.h>

#include <Eigen/Sparse>
#include <cmath>
#include <limits>
#include <string>
#include <thread>
#include <vector>

#include "tests/server/mechanics/sparse/count_allocations.h"
#include "tests/server/mechanics/sparse/matrices.h"

namespace {

using namespace tenter::mechanics;
using namespace tenter::mechanics::test;

struct Rival {
  const char* name;
  std::unique_ptr<SparseFactor> (*make)();
};

std::unique_ptr<SparseFactor> make_avx2() {
  return make_supernodal_factor(InstructionSet::avx2);
}
std::unique_ptr<SparseFactor> make_portable() {
  return make_supernodal_factor(InstructionSet::portable);
}

class Factor : public testing::TestWithParam<Rival> {
 protected:
  std::mt19937 random{20};
  std::unique_ptr<SparseFactor> factor = GetParam().make();
};

INSTANTIATE_TEST_SUITE_P(All, Factor,
                         testing::Values(Rival{"cholmod", make_cholmod_factor},
                                         Rival{"best", make_factor}, Rival{"avx2", make_avx2},
                                         Rival{"portable", make_portable}),
                         [](const auto& rival) { return std::string(rival.param.name); });

struct Named {
  std::string name;
  TestMatrix matrix;
};

/// Two copies of a matrix that do not know each other.
TestMatrix disconnected(const TestMatrix& part) {
  TestMatrix both = part;
  const int size = part.pattern.size, entries = part.pattern.entry_count();
  both.pattern.size = 2 * size;
  for (int i = 1; i <= size; ++i)
    both.pattern.column_start.push_back(entries + part.pattern.column_start[i]);
  for (const int row : part.pattern.row) both.pattern.row.push_back(size + row);
  both.values.insert(both.values.end(), part.values.begin(), part.values.end());
  return both;
}

std::vector<Named> matrices_under_test(std::mt19937& random) {
  std::vector<Named> list;
  list.push_back({"size 1", random_matrix(1, 1, 2, random)});
  list.push_back({"diagonal", random_matrix(40, 0, 2, random)});
  list.push_back({"chain of pairs", random_matrix(300, 200, 2, random)});
  list.push_back({"many small supernodes", random_matrix(500, 700, 3, random)});
  list.push_back({"wide elements", random_matrix(400, 60, 30, random)});
  for (const int size : {2, 7, 8, 9, 23, 64, 130}) {
    std::vector<int> all(size);
    for (int i = 0; i < size; ++i) all[i] = i;
    list.push_back({"dense " + std::to_string(size),
                    element_matrix(element_pattern(size, {all}), {all}, 0.1, random)});
  }
  for (const int nodes : {3, 8, 14, 25})
    list.push_back({"cloth " + std::to_string(nodes), cloth_matrix(nodes, random)});
  list.push_back({"two cloths", disconnected(cloth_matrix(7, random))});
  return list;
}

std::vector<double> eigen_solution(const TestMatrix& matrix, const std::vector<double>& b) {
  const SymmetricPattern& pattern = matrix.pattern;
  const Eigen::Map<const Eigen::SparseMatrix<double>> lower(
      pattern.size, pattern.size, pattern.entry_count(), pattern.column_start.data(),
      pattern.row.data(), matrix.values.data());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> ldlt(lower);
  const Eigen::VectorXd x = ldlt.solve(Eigen::Map<const Eigen::VectorXd>(b.data(), pattern.size));
  return {x.data(), x.data() + x.size()};
}

double norm(const std::vector<double>& x) {
  return Eigen::Map<const Eigen::VectorXd>(x.data(), static_cast<int>(x.size())).norm();
}

double distance(const std::vector<double>& x, const std::vector<double>& y) {
  std::vector<double> difference(x);
  for (std::size_t i = 0; i < x.size(); ++i) difference[i] -= y[i];
  return norm(difference);
}

TEST_P(Factor, AgreesWithEigen) {
  for (const auto& [name, matrix] : matrices_under_test(random)) {
    const std::vector<double> b = random_vector(matrix.pattern.size, random);
    const std::vector<double> wanted = eigen_solution(matrix, b);
    std::vector<double> x(b.size());
    factor->analyze(matrix.pattern);  // the same object for all: a new pattern replaces the old
    ASSERT_EQ(factor->factorize(matrix.values.data()), FactorStatus::ok) << name;
    factor->solve(b.data(), x.data(), 1);
    ASSERT_GT(norm(wanted), 1e-3 * norm(b)) << name;
    EXPECT_LE(distance(x, wanted), 1e-10 * norm(wanted)) << name;
    EXPECT_LE(residual(matrix, x.data(), b.data()), 1e-14) << name;
  }
}

TEST_P(Factor, SeesThatAMatrixIsNotPositiveDefinite) {
  for (auto& [name, matrix] : matrices_under_test(random)) {
    factor->analyze(matrix.pattern);
    const int n = matrix.pattern.size;
    for (const int where : {0, n / 2, n - 1}) {
      TestMatrix spoilt = matrix;
      double& diagonal = spoilt.values[matrix.pattern.column_start[where]];
      diagonal = -0.01 * diagonal;
      EXPECT_EQ(factor->factorize(spoilt.values.data()), FactorStatus::not_positive_definite)
          << name << ' ' << where;
    }
    // positive diagonal, indefinite all the same
    TestMatrix spoilt = matrix;
    const int last = spoilt.pattern.entry_count() - 1;
    for (int col = 0; col < n; ++col) {
      const int first = spoilt.pattern.column_start[col];
      if (spoilt.pattern.column_start[col + 1] == first + 1 || first == last) continue;
      const int row = spoilt.pattern.row[first + 1];
      spoilt.values[first + 1] =
          -1.1 * std::sqrt(spoilt.values[first] * spoilt.values[spoilt.pattern.slot(row, row)]);
      EXPECT_EQ(factor->factorize(spoilt.values.data()), FactorStatus::not_positive_definite)
          << name;
      break;
    }
    EXPECT_EQ(factor->factorize(matrix.values.data()), FactorStatus::ok) << name << " afterwards";
  }
}

TEST_P(Factor, SingularIsNotPositiveDefinite) {
  // springs between neighbours, nothing held: rows sum to zero
  std::vector<std::vector<int>> pairs;
  pairs.reserve(30);
  for (int i = 0; i < 30; ++i) pairs.push_back({i, i + 1});
  TestMatrix chain{element_pattern(31, pairs), {}};
  chain.values.assign(chain.pattern.entry_count(), 0.0);
  for (const std::vector<int>& pair : pairs) {
    for (const int i : pair) chain.values[chain.pattern.slot(i, i)] += 1.0;
    chain.values[chain.pattern.slot(pair[0], pair[1])] -= 1.0;
  }
  factor->analyze(chain.pattern);
  EXPECT_EQ(factor->factorize(chain.values.data()), FactorStatus::not_positive_definite);
  chain.values[0] += 1e-9;  // held, if softly
  EXPECT_EQ(factor->factorize(chain.values.data()), FactorStatus::ok);
}

TEST_P(Factor, ValuesThatAreNoNumbersAreReported) {
  const double bad[] = {std::numeric_limits<double>::quiet_NaN(),
                        std::numeric_limits<double>::infinity()};
  for (const auto& [name, matrix] : matrices_under_test(random)) {
    factor->analyze(matrix.pattern);
    const int entries = matrix.pattern.entry_count();
    for (const int where : {0, entries / 3, entries / 2, entries - 1}) {
      for (const double value : bad) {
        std::vector<double> values = matrix.values;
        values[where] = value;
        EXPECT_EQ(factor->factorize(values.data()), FactorStatus::not_finite)
            << name << " entry " << where << " is " << value;
      }
    }
  }
}

TEST_P(Factor, SameBytesAgainAndFromAnotherThread) {
  for (const Named& named : matrices_under_test(random)) {
    const TestMatrix& matrix = named.matrix;
    const int n = matrix.pattern.size;
    const std::vector<double> b = random_vector(3 * n, random);
    const auto answer = [&](SparseFactor& solver) {
      std::vector<double> x(b.size(), 0.0);
      EXPECT_EQ(solver.factorize(matrix.values.data()), FactorStatus::ok);
      solver.solve(b.data(), x.data(), 3);
      return x;
    };
    factor->analyze(matrix.pattern);
    const std::vector<double> first = answer(*factor);
    std::vector<double> negative = matrix.values;
    negative[0] = -1.0;
    EXPECT_NE(factor->factorize(negative.data()), FactorStatus::ok);
    EXPECT_EQ(answer(*factor), first) << named.name << " after a failure";
    std::vector<double> elsewhere;
    std::thread([&] {
      const std::unique_ptr<SparseFactor> other = GetParam().make();
      other->analyze(matrix.pattern);
      elsewhere = answer(*other);
    }).join();
    EXPECT_EQ(elsewhere, first) << named.name;
  }
}

TEST_P(Factor, ManyRightSidesAreManySingleOnes) {
  const TestMatrix matrix = cloth_matrix(10, random);
  const int n = matrix.pattern.size;
  factor->analyze(matrix.pattern);
  ASSERT_EQ(factor->factorize(matrix.values.data()), FactorStatus::ok);
  for (const int count : {1, 2, 3, 4, 5, 7, 8, 9, 17, 31, 70, 16}) {
    const std::vector<double> b = random_vector(count * n, random);
    std::vector<double> together(b.size()), in_place = b;
    factor->solve(b.data(), together.data(), count);
    factor->solve(in_place.data(), in_place.data(), count);
    EXPECT_EQ(in_place, together);
    for (int k = 0; k < count; ++k) {
      std::vector<double> alone(n);
      factor->solve(b.data() + k * n, alone.data(), 1);
      const std::vector<double> column(together.begin() + k * n, together.begin() + (k + 1) * n);
      EXPECT_LE(distance(alone, column), 1e-11 * norm(alone)) << count << ' ' << k;
      EXPECT_LE(residual(matrix, column.data(), b.data() + k * n), 1e-14);
    }
  }
}

TEST_P(Factor, AllocatesOnlyTheFirstTime) {
  const TestMatrix matrix = cloth_matrix(12, random);
  std::vector<double> failing = matrix.values;
  failing[0] = -1.0;
  const int n = matrix.pattern.size;
  std::vector<double> b = random_vector(9 * n, random), x(b.size());
  const long at_start = allocations();
  factor->analyze(matrix.pattern);
  EXPECT_GT(allocations(), at_start) << "the counter counts";
  // CHOLMOD allocates in its factorisation and for another number of right sides, see factor.h; on
  // some processors the BLAS below it does in every solve, so that only its answers are looked at
  const bool is_ours = std::string(GetParam().name) != "cholmod";
  const auto work = [&](bool first_time) {
    const long before = allocations();
    if (first_time || is_ours) {
      EXPECT_EQ(factor->factorize(failing.data()), FactorStatus::not_positive_definite);
      EXPECT_EQ(factor->factorize(matrix.values.data()), FactorStatus::ok);
    }
    if (is_ours) factor->solve(b.data(), x.data(), 1);
    factor->solve(b.data(), x.data(), 9);
    return allocations() - before;
  };
  work(true);
  const long later = work(false);
  if (is_ours) {
    EXPECT_EQ(later, 0);
  }
}

TEST_P(Factor, NoUnknownsIsNoProblem) {
  factor->analyze(element_pattern(0, {}));
  EXPECT_EQ(factor->factorize(nullptr), FactorStatus::ok);
  factor->solve(nullptr, nullptr, 1);
}

TEST_P(Factor, CostIsThatOfADenseMatrix) {
  std::vector<int> all(50);
  for (int i = 0; i < 50; ++i) all[i] = i;
  factor->analyze(element_pattern(50, {all}));
  EXPECT_NEAR(factor->cost().flops, 50.0 * 51 * 101 / 6, 1e-9 * 50.0 * 51 * 101 / 6);
  EXPECT_GE(factor->cost().factor_entries, 50 * 51 / 2);
  EXPECT_GE(factor->cost().bytes, sizeof(double) * factor->cost().factor_entries);
}

}  // namespace
