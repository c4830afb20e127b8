// SPDX-License-Identifier: GPL-3.0-or-later
// Do the readings of a load cell come in steps, and are the steps above the noise?
//
// Readings on a lattice differ by whole multiples of one step q. Quantisation adds an error of
// standard deviation q / sqrt(12); it is a fault where q is large against the scatter of
// neighbouring readings, which then stick to the same value. No regression: what a step hides
// cannot be fitted.
//
//   for (const Lattice& l : find_lattices(curves)) if (l.is_above_noise()) ...
//
// Pure; O(n log n) in the readings of a channel.
#pragma once

#include <optional>
#include <vector>

#include "server/diagnosis/diagnose.h"

namespace tenter::diagnosis {

/// Step of the lattice that all finite values lie on to a thousandth of it; 0 where they lie on
/// none, or are too few to tell (20 values, 4 of them different).
double lattice_step(std::vector<double> values);

struct Lattice {
  int curve = 0;
  int channel = 0;
  double step = 0.0;     ///< N/m
  double scatter = 0.0;  ///< standard deviation between neighbouring readings, N/m
  bool is_above_noise() const;
};

/// Of all channels of force whose readings come in steps.
std::vector<Lattice> find_lattices(const std::vector<estimation::Curves>& curves);

/// Readings are no finer than their steps: what the channels declare as their resolution is raised
/// to them.
void note_resolution(std::vector<estimation::Curves>& curves);

/// Takes out what rounding to steps above the noise explains: deviations of up to a step and a
/// half.
void drop_within_steps(const std::vector<estimation::Curves>& curves,
                       std::vector<estimation::Outlier>& outliers);

/// What steps above the noise leave of chi2, q^2 / (12 sigma^2) a row, beyond the `counted` a row
/// that are expected already: rounding repeats where the path does, and no repeat tells it.
double chi2_of_steps(const Diagnosis& d, double counted);

/// SENSOR load_cell_quantisation, where any channel's steps are above the noise.
std::optional<Verdict> quantisation_verdict(const Diagnosis& d);

}  // namespace tenter::diagnosis
