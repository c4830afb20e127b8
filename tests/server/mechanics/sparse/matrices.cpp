// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/server/mechanics/sparse/matrices.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace tenter::mechanics::test {

namespace {

std::vector<std::vector<int>> cloth_elements(int nodes) {
  std::vector<std::vector<int>> elements;
  const auto id = [nodes](int i, int j) { return j * nodes + i; };
  for (int j = 0; j + 1 < nodes; ++j) {
    for (int i = 0; i + 1 < nodes; ++i) {
      const int a = id(i, j), b = id(i + 1, j), c = id(i, j + 1), d = id(i + 1, j + 1);
      if ((i + j) % 2 == 0) {
        elements.push_back({a, b, d});
        elements.push_back({a, d, c});
      } else {
        elements.push_back({a, b, c});
        elements.push_back({b, d, c});
      }
    }
  }
  std::map<std::pair<int, int>, int> opposite;
  const std::size_t triangles = elements.size();
  for (std::size_t t = 0; t < triangles; ++t) {
    for (int k = 0; k < 3; ++k) {
      const int p = elements[t][k], q = elements[t][(k + 1) % 3], o = elements[t][(k + 2) % 3];
      const auto [found, first] = opposite.try_emplace({std::min(p, q), std::max(p, q)}, o);
      if (!first) elements.push_back({p, q, o, found->second});
    }
  }
  return elements;
}

}  // namespace

TestMatrix element_matrix(SymmetricPattern pattern, const std::vector<std::vector<int>>& elements,
                          double shift, std::mt19937& random) {
  std::normal_distribution<double> normal;
  TestMatrix matrix{std::move(pattern), {}};
  matrix.values.assign(matrix.pattern.entry_count(), 0.0);
  for (int i = 0; i < matrix.pattern.size; ++i)
    matrix.values[matrix.pattern.column_start[i]] = shift;
  for (const std::vector<int>& dofs : elements) {
    const std::size_t n = dofs.size();
    std::vector<double> w(n * n);
    for (double& value : w) value = normal(random);
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j <= i; ++j) {
        const int slot = matrix.pattern.slot(dofs[i], dofs[j]);
        if (slot < 0) continue;
        for (std::size_t k = 0; k < n; ++k) matrix.values[slot] += w[i * n + k] * w[j * n + k];
      }
    }
  }
  return matrix;
}

TestMatrix random_matrix(int size, int elements, int width, std::mt19937& random) {
  std::uniform_int_distribution<int> node(0, size - 1), length(2, std::max(2, width));
  std::vector<std::vector<int>> list(elements);
  for (std::vector<int>& dofs : list) {
    const int n = length(random);
    for (int i = 0; i < n; ++i) dofs.push_back(node(random));
    std::sort(dofs.begin(), dofs.end());
    dofs.erase(std::unique(dofs.begin(), dofs.end()), dofs.end());
  }
  return element_matrix(element_pattern(size, list), list, 0.1, random);
}

TestMatrix cloth_matrix(int nodes, std::mt19937& random) {
  std::vector<std::vector<int>> elements = cloth_elements(nodes);
  // free nodes in the order of the grid: without the first and the last corner of the first row
  const auto free_number = [nodes](int node) {
    return node == 0 || node == nodes - 1 ? -1 : node - (node > nodes - 1 ? 2 : 1);
  };
  std::vector<std::vector<int>> dofs;
  for (const std::vector<int>& element : elements) {
    dofs.emplace_back();
    for (const int node : element)
      for (int c = 0; c < 3; ++c)
        dofs.back().push_back(free_number(node) < 0 ? -1 : 3 * free_number(node) + c);
  }
  return element_matrix(element_pattern(3 * (nodes * nodes - 2), dofs), dofs, 1e-2, random);
}

std::vector<double> random_vector(int size, std::mt19937& random) {
  std::normal_distribution<double> normal;
  std::vector<double> vector(size);
  for (double& value : vector) value = normal(random);
  return vector;
}

double residual(const TestMatrix& matrix, const double* x, const double* b) {
  const SymmetricPattern& pattern = matrix.pattern;
  std::vector<double> product(pattern.size), row_sum(pattern.size, 0.0);
  multiply(pattern, matrix.values.data(), x, product.data());
  for (int col = 0; col < pattern.size; ++col) {
    for (int p = pattern.column_start[col]; p < pattern.column_start[col + 1]; ++p) {
      row_sum[pattern.row[p]] += std::abs(matrix.values[p]);
      if (pattern.row[p] != col) row_sum[col] += std::abs(matrix.values[p]);
    }
  }
  double error = 0.0, x_norm = 0.0, b_norm = 0.0, a_norm = 0.0;
  for (int i = 0; i < pattern.size; ++i) {
    error = std::max(error, std::abs(product[i] - b[i]));
    x_norm = std::max(x_norm, std::abs(x[i]));
    b_norm = std::max(b_norm, std::abs(b[i]));
    a_norm = std::max(a_norm, row_sum[i]);
  }
  return error / (a_norm * x_norm + b_norm);
}

}  // namespace tenter::mechanics::test
