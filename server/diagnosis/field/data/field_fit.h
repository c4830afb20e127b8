// SPDX-License-Identifier: GPL-3.0-or-later
// One joint fit to sheets, and what later steps compare with: residuals, Jacobian, where the frames
// came to rest.
//
//   FieldData data{sequences, blocks, ...};
//   auto baseline = fit_field(model, data, {}, options);           // first fit, from measured
//   starts auto larger = fit_field(extended, data, baseline->states, options);    // from where
//   those rest
//
// Every row counts alike, in its own sigmas: that is the likelihood. FitResult::effective_rows is
// that of structure.h, and standard errors are those of so many. Pure; the same bytes for any
// number of threads. Cost: a fit.
#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "common/base/error.h"
#include "common/model/model.h"
#include "server/diagnosis/trials/trial.h"
#include "server/estimation/sequences/sequence.h"

namespace tenter::diagnosis {

struct FieldData {
  std::vector<estimation::Sequence> sequences;  ///< with the sigmas that weigh
  std::vector<std::string> ids;                 ///< SHA-256
  std::vector<std::string> protocols;           ///< sequences of one are left out of fits together
  std::vector<bool> has_clock;                  ///< else durations are one second a frame
  /// Of each kind of channel (kind_places() of structure.h) of how many independent readings its
  /// sigma is known; 0, or none: it is what the capture states.
  std::vector<double> sigma_known_of;
  /// Of each sequence, of positions and of all else: sigmas are a guess, which what readings show
  /// replaces; none: all are stated.
  std::vector<std::array<bool, 2>> has_guessed_noise;
  int block_count() const;
};

using FieldStates = std::vector<std::vector<mechanics::State>>;

struct FieldFit {
  Reference at;  ///< `usable` of its fit says whether there is one
  FieldStates states;
  std::vector<estimation::Row> rows;
};

struct FieldFitOptions {
  int threads = 1;
  int max_iterations = 40;
  double tolerance = 1e-5;  ///< relative fall of the cost
  double tolerance_N = 1e-8;
  std::function<bool(int, double)> on_iteration = nullptr;
};

/// `starts`: rests of nearly these parameters; empty, or where they lead nowhere: the sequences'
/// own. bad_input as
/// SequenceEvaluator::make(), and where frames have no rest at the start.
Expected<FieldFit> fit_field(const model::Model& start, const FieldData& data,
                             const FieldStates& starts, const FieldFitOptions& options);

/// Without sensor corrections of captures or of channels that the data lack: they do nothing there.
model::Model acting_on(model::Model model, const FieldData& data);

/// The model as it acts on the data: nothing is fitted.
Expected<FieldFit> predict_field(const model::Model& model, const FieldData& data,
                                 const FieldStates& starts, const FieldFitOptions& options);

/// Refits without each fold from where `at` is, and the residuals of what was left out.
estimation::HeldOut cross_validate_field(const FieldFit& at, const FieldData& data,
                                         const estimation::Folds& folds,
                                         const FieldFitOptions& options);

/// Members of each fold: "protocols" (three at least), "captures", "blocks", "frames".
estimation::Folds field_folds(const FieldData& data, const std::vector<estimation::Row>& rows,
                              const std::string& kind);

}  // namespace tenter::diagnosis
