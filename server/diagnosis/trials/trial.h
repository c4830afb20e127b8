// SPDX-License-Identifier: GPL-3.0-or-later
// One candidate refitted, and whether it may be believed (design, step 7).
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "server/diagnosis/screen.h"
#include "server/estimation/hold_out.h"

namespace tenter::diagnosis {

struct Trial {
  const Effect* effect = nullptr;
  DataPointer data;
  Variant variant;
  model::Model model;  ///< fitted
  estimation::FitResult fit;
  std::vector<double> block_chi2;
  int parameters = 0;      ///< free ones
  double ratio = 0.0;      ///< of the screen
  double explained = 0.0;  ///< share of what the model before missed beyond the noise
  double p_value = 1.0;    ///< F test against the model before, on effectively independent rows
  double held_out_before = 0.0;  ///< chi2 on the same folds
  double held_out_after = 0.0;
  Eigen::VectorXd held_out_residuals;   ///< of this model, NaN where no fold left the row out
  double held_out_error = 0.0;          ///< standard error of the difference, over blocks
  std::string folds;                    ///< what was left out
  std::vector<std::string> objections;  ///< gates that it fails, in words; empty: it passes
};

/// A fitted model that trials are compared with.
struct Reference {
  model::Model model;
  estimation::FitResult fit;
  std::vector<double> block_chi2;
};

/// Refits; `usable` of the fit says whether it went well.
Trial refit(const Candidate& candidate, const Reference& base, const DataPointer& data);

std::vector<double> chi2_by_block(const std::vector<estimation::Row>& rows,
                                  const Eigen::VectorXd& residuals, int blocks);

/// p of the hypothesis that the added parameters explain nothing: F with `rows` independent
/// observations.
double f_test(double chi2_before, double chi2_after, int added, int parameters, double rows);

/// Twice the log evidence from which on a rival is told apart.
constexpr double kDecisive = 10.0;

/// Information criterion on `rows` independent observations, with a penalty for the size of the
/// catalogue for each added effect (extended BIC). Smaller is better.
double information(double chi2, int parameters, int added_effects, double rows);

/// The same by which trials of one round are ordered: a sharper form of another effect has to do
/// decisively better.
double criterion_of(const Trial& trial, int added_effects, double rows);

/// Where the refit ended.
Reference reference_of(const Trial& trial);

/// Fills p_value, the held-out scores and the objections.
void judge(Trial& trial, const Reference& before, const DataPointer& data, double expected_chi2);

/// Is each part that the variant added alive and known to better than a half? Adds objections.
void check_parameters(Trial& trial);

/// A free parameter that is off zero by more than its errors.
bool is_surely_there(const estimation::FitResult& fit, std::size_t parameter);

/// What a reading missed, frame after frame, before and after a step that it is said to have.
struct Step {
  std::vector<double> before, after;
  double size = 0.0;   ///< by which it is said to jump
  double sigma = 1.0;  ///< of a reading
};

/// From the last few to the first few of them.
double jump_of(const std::vector<double>& before, const std::vector<double>& after);

/// An accident is an event: within a few frames of its place readings jump by what the fit says it
/// was, and further than they scatter. A smooth misfit of one run does not. The objection, or
/// nothing.
std::string step_objection(const Step& step);

/// Fills the scores of the trial on left-out data from both models' residuals there; the objection
/// to it, or nothing. `above_noise`: chi2 of what the smaller model misses there beyond the noise.
std::string compare_held_out(Trial& trial, const estimation::HeldOut& earlier,
                             const estimation::HeldOut& after,
                             const std::vector<estimation::Row>& rows, int blocks,
                             const std::string& kind, double above_noise);

/// Laws are written otherwise than cloth behaves: a gain in chi2 of effects that are a share `form`
/// as large as those that took `taken` may be what the form of these misses.
bool is_within_form(double gain, double taken, double form);
constexpr double kFormOfCurves = 0.13;
constexpr double kFormOfSheets = 0.3;  ///< frames are few, and cells are coarse
constexpr double kFormOfGrid = 0.35;   ///< its error is told from two grids

/// The objection to a trial that no left-out data could judge.
inline constexpr const char* kNothingLeftOut = "there is nothing that could be left out";
/// No other objection speaks against it.
bool lacks_only_proof(const Trial& trial);

/// Share of what `before` missed beyond `expected_chi2` that `after` explains.
double explained_share(double before, double after, double expected_chi2);

int free_count(const model::Model& model);
/// Of these, those that the data move: none spends what data hold that they do not touch.
int determined_count(const estimation::FitResult& fit);

}  // namespace tenter::diagnosis
