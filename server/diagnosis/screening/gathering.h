// SPDX-License-Identifier: GPL-3.0-or-later
// The parts of all candidates in one model, switched off, each distinct term once: one evaluation
// of it has the columns of them all.
//
//   Gathering gathering(fitted);
//   gathering.add(effect, variant, setting);            // many
//   evaluate gathering.model() ...
//   for (const Columns& c : gathering.entries()) jacobian.col(gathering.place(c.columns[0])) ...
//
// The gathered model's parameters: those of the fitted model's terms, of the added terms, of the
// fitted model's corrections, of the added ones. Effects and variants must outlive it.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "server/diagnosis/effect.h"

namespace tenter::diagnosis {

/// Where the columns of one candidate stand in the Jacobian of the model that holds them all.
struct Columns {
  const Effect* effect = nullptr;
  const Variant* variant = nullptr;
  Setting setting;
  std::vector<int> columns;            ///< for Gathering::place
  std::vector<std::string> addresses;  ///< "term.parameter" of each column in the extended model
  std::vector<double> least;  ///< smallest change of each from where it is off, or minus infinity
  std::vector<double> off;    ///< value of each parameter when the effect is off
};

class Gathering {
 public:
  explicit Gathering(const model::Model& base);

  void add(const Effect& effect, const Variant& variant, const Setting& setting);

  const std::vector<Columns>& entries() const { return entries_; }
  const model::Model& base() const { return model_; }
  const std::vector<model::Term>& added_terms() const { return added_terms_; }
  const std::vector<model::SensorCorrection>& added_corrections() const {
    return added_corrections_;
  }

  model::Model model() const;

  /// Column of the gathered model's Jacobian for an entry of Columns::columns.
  int place(int code) const;
  /// Parameters of the gathered model that stand before those of the added terms; of these; of the
  /// fitted model's corrections; of the added ones.
  int base_term_count() const { return term_parameters_; }
  int added_term_count() const { return added_term_parameters_; }
  int base_correction_count() const {
    return static_cast<int>(base_index_.size()) - term_parameters_;
  }
  int added_correction_count() const { return correction_parameters_; }
  /// Those of the added terms' parameters that some entry asks for, counted over these terms,
  /// rising: what is fixed or set by a grid needs no column. The same of the added corrections.
  std::vector<int> asked_of_terms() const;
  std::vector<int> asked_of_corrections() const;
  int count() const {
    return base_term_count() + added_term_count() + base_correction_count() +
           added_correction_count();
  }

 private:
  void add_term(model::Term term, const Setting& setting, Columns& entry);
  std::vector<int> asked(int first_code, int count) const;

  model::Model model_;
  std::map<std::string, int> base_index_;
  std::map<std::string, int> known_;
  std::vector<model::Term> added_terms_;
  std::vector<model::SensorCorrection> added_corrections_;
  std::vector<Columns> entries_;
  int term_parameters_ = 0;
  int added_term_parameters_ = 0;
  int correction_parameters_ = 0;
};

}  // namespace tenter::diagnosis
