// SPDX-License-Identifier: GPL-3.0-or-later
// Which strains of a term a sequence reached (thesis 3.4.2): the range over which its curve has
// control points.
//
//   auto histograms = strain_histograms(mesh_model, states);      // one a term
//   auto [lo, hi] = histograms[0].range(0.005);                   // without 0.5 % at each end
//
// Every element counts in every frame with its area (times the weight of the term's support), so
// neither a finer mesh nor a single crumpled element decides. Strains of measures of several count
// together: laws have the same curve for each. Pure; cost of a sort.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "server/mechanics/assembly/mesh_model.h"
#include "server/mechanics/conditions/boundary.h"

namespace tenter::estimation {

class StrainHistogram {
 public:
  void add(double strain, double weight) { samples_.emplace_back(strain, weight); }
  /// Before the questions below.
  void sort();
  /// Sorted again.
  void merge(const StrainHistogram& other);

  bool is_empty() const { return samples_.empty(); }
  /// The strain below which a share of the weight lies. Zero where empty.
  double quantile(double share) const;
  /// Quantiles `outliers` and 1 - `outliers`.
  std::pair<double, double> range(double outliers) const;
  /// Share of the weight in each of `count` even bins over [lo, hi]; what lies outside is in none.
  std::vector<double> bins(double lo, double hi, int count) const;

 private:
  std::vector<std::pair<double, double>> samples_;
  double weight_ = 0.0;
};

/// One for each term, sorted; states in which a strain is not finite are left out. `weights`: of
/// the states, beside the areas; empty: 1 each.
std::vector<StrainHistogram> strain_histograms(const mechanics::MeshModel& model,
                                               const std::vector<mechanics::State>& states,
                                               const std::vector<double>& weights = {});

/// The same over sequences on meshes of their own.
void append(std::vector<StrainHistogram>& to, const std::vector<StrainHistogram>& from);

/// Terms of a group (by their ids) get the strains of all of it: they share a curve.
void merge_tied(const std::vector<model::Term>& terms,
                const std::vector<std::vector<std::string>>& groups,
                std::vector<StrainHistogram>& of_terms);

}  // namespace tenter::estimation
