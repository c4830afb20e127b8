// SPDX-License-Identifier: GPL-3.0-or-later
// Matrices for the tests and benches of factorisations: a pattern with values.
#pragma once

#include <random>
#include <vector>

#include "server/mechanics/sparse/symmetric_pattern.h"

namespace tenter::mechanics::test {

struct TestMatrix {
  SymmetricPattern pattern;
  std::vector<double> values;
};

/// Sum over the elements of random symmetric positive semidefinite matrices of the elements' size
/// (W W' with W square), plus `shift` on the diagonal: positive definite for shift > 0.
TestMatrix element_matrix(SymmetricPattern pattern, const std::vector<std::vector<int>>& elements,
                          double shift, std::mt19937& random);

/// `elements` random elements of 2 to `width` unknowns among `size`.
TestMatrix random_matrix(int size, int elements, int width, std::mt19937& random);

/// Cloth of nodes x nodes nodes: quads of two triangles with alternating diagonals, hinges over
/// the inner edges, three unknowns a node, two corners fixed (their unknowns are left out).
TestMatrix cloth_matrix(int nodes, std::mt19937& random);

std::vector<double> random_vector(int size, std::mt19937& random);

/// |A x - b| / (|A| |x| + |b|) in the infinity norm.
double residual(const TestMatrix& matrix, const double* x, const double* b);

}  // namespace tenter::mechanics::test
