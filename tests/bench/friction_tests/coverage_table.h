// SPDX-License-Identifier: GPL-3.0-or-later
// Counts, over seeds, how often intervals hold the truth, and prints the table of one sample.
#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "server/estimation/friction_tests/friction_estimate.h"
#include "tests/twin/friction/friction_sample.h"

namespace tenter::bench {

struct CoverageOptions {
  int first = 1;  ///< seed
  int seeds = 200;
  int threads = 1;
  bool profiles = false;  ///< intervals from profiles of the likelihood, else from the covariance
};

class CoverageTable {
 public:
  explicit CoverageTable(const twin::FrictionSample& sample);
  void add(const estimation::FrictionEstimate& found);
  void add_failure() { ++failed_; }
  void add_seconds(double seconds) { seconds_ += seconds; }
  /// Of the first seed, as a row of tables 5.1, 5.2, and of all.
  void print() const;

 private:
  struct Column {
    double truth = 0.0;
    int held = 0, told = 0;
    double sum = 0.0, squares = 0.0, papers = 0.0, width = 0.0;
    std::string first;
  };
  std::string name_;
  std::vector<Column> columns_;
  std::vector<std::string> names_;
  int seeds_ = 0;
  int failed_ = 0;
  double chi2_per_row_ = 0.0;
  double seconds_ = 0.0;
};

/// The table over seeds first, first + 1, ... of what `find` finds; the same for any number of
/// threads. A reason for the first that fails is printed.
CoverageTable covered(const twin::FrictionSample& sample, const CoverageOptions& options,
                      const std::function<Expected<estimation::FrictionEstimate>(int seed)>& find);

}  // namespace tenter::bench
