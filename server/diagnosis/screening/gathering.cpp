// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/screening/gathering.h"

#include <algorithm>

#include "server/estimation/least_squares/bounded_least_squares.h"
#include "server/estimation/prediction.h"

namespace tenter::diagnosis {
namespace {

constexpr int kCorrectionBase = 1 << 20;

bool is_set(const Setting& setting, const std::string& address) {
  return std::any_of(setting.begin(), setting.end(),
                     [&](const auto& s) { return s.first == address; });
}

void apply(const Setting& setting, const std::string& id,
           std::vector<model::Parameter>& parameters) {
  for (const auto& [address, value] : setting)
    for (model::Parameter& p : parameters)
      if (address == id + "." + p.name) p.value = value;
}

/// The smallest change of a parameter from where its effect is off.
double least_of(const model::Parameter& p, double off) {
  return p.lower ? *p.lower - off : -estimation::kNoBound;
}

/// What tells one added term's column from another's.
std::string key_of(const model::Term& term) {
  std::string key =
      term.strain.name + "@" + std::to_string(term.strain.angle_rad) + "/" + term.law.name;
  if (term.support.name != "everywhere")
    key += "@" + term.support.field + std::to_string(term.support.sample);
  for (const model::Parameter& p : term.law.parameters) key += "," + std::to_string(p.value);
  return key;
}

}  // namespace

Gathering::Gathering(const model::Model& base) : model_(base) {
  const auto names = estimation::parameter_names(base);
  for (std::size_t i = 0; i < names.size(); ++i) base_index_[names[i]] = static_cast<int>(i);
  for (const model::Term& t : base.terms)
    term_parameters_ += static_cast<int>(t.law.parameters.size());
}

void Gathering::add(const Effect& effect, const Variant& variant, const Setting& setting) {
  Columns entry;
  entry.effect = &effect;
  entry.variant = &variant;
  entry.setting = setting;
  for (const model::Term& term : variant.append) add_term(term, setting, entry);
  for (const auto& [id, law] : variant.replace) {
    for (const model::Term& existing : model_.terms) {
      if (existing.id != id) continue;
      model::Term term = existing;
      term.law = law;
      const std::size_t first = entry.columns.size();
      // linear in its parameters: at zero it has the same columns as in the place of the law that
      // it replaces
      for (model::Parameter& p : term.law.parameters) p.value = 0.0;
      add_term(term, setting, entry);
      for (std::size_t k = first; k < entry.off.size(); ++k) {
        const model::Parameter& p = law.parameters[k - first];
        entry.off[k] = p.value;
        entry.least[k] = least_of(p, p.value);
      }
      break;
    }
  }
  for (const std::string& address : variant.unfix) {
    entry.columns.push_back(-1 - base_index_.at(address));
    entry.addresses.push_back(address);
    entry.least.push_back(0.0);
    entry.off.push_back(0.0);
  }
  for (model::SensorCorrection correction : variant.corrections) {
    const std::string id = correction.id;
    apply(setting, id, correction.parameters);
    for (std::size_t k = 0; k < correction.parameters.size(); ++k) {
      const model::Parameter& p = correction.parameters[k];
      const std::string address = id + "." + p.name;
      if (p.fixed || is_set(setting, address)) continue;
      entry.columns.push_back(correction_parameters_ + static_cast<int>(k) + kCorrectionBase);
      entry.addresses.push_back(address);
      entry.least.push_back(least_of(p, p.value));
      entry.off.push_back(p.value);
    }
    correction_parameters_ += static_cast<int>(correction.parameters.size());
    added_corrections_.push_back(std::move(correction));
  }
  entries_.push_back(std::move(entry));
}

model::Model Gathering::model() const {
  model::Model all = model_;
  for (const model::Term& t : added_terms_) all.terms.push_back(t);
  for (const model::SensorCorrection& c : added_corrections_) all.corrections.push_back(c);
  return all;
}

std::vector<int> Gathering::asked(int first_code, int count) const {
  std::vector<bool> is_asked(static_cast<std::size_t>(count), false);
  for (const Columns& entry : entries_)
    for (const int code : entry.columns)
      if (code >= first_code && code - first_code < count)
        is_asked[static_cast<std::size_t>(code - first_code)] = true;
  std::vector<int> places;
  for (int k = 0; k < count; ++k)
    if (is_asked[static_cast<std::size_t>(k)]) places.push_back(k);
  return places;
}

std::vector<int> Gathering::asked_of_terms() const {
  return asked(0, added_term_parameters_);
}

std::vector<int> Gathering::asked_of_corrections() const {
  return asked(kCorrectionBase, correction_parameters_);
}

int Gathering::place(int code) const {
  if (code < 0) {
    const int base = -1 - code;
    return base < term_parameters_ ? base : base + added_term_parameters_;
  }
  if (code >= kCorrectionBase)
    return term_parameters_ + added_term_parameters_ + base_correction_count() + code -
           kCorrectionBase;
  return term_parameters_ + code;
}

void Gathering::add_term(model::Term term, const Setting& setting, Columns& entry) {
  const std::string id = term.id;
  apply(setting, id, term.law.parameters);
  auto [found, is_new] = known_.emplace(key_of(term), added_term_parameters_);
  if (is_new) {
    added_term_parameters_ += static_cast<int>(term.law.parameters.size());
    added_terms_.push_back(term);
  }
  for (std::size_t k = 0; k < term.law.parameters.size(); ++k) {
    const model::Parameter& p = term.law.parameters[k];
    const std::string address = id + "." + p.name;
    if (p.fixed || is_set(setting, address)) continue;
    entry.columns.push_back(found->second + static_cast<int>(k));
    entry.addresses.push_back(address);
    entry.least.push_back(least_of(p, p.value));
    entry.off.push_back(p.value);
  }
}

}  // namespace tenter::diagnosis
