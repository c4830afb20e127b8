// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/effect.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <set>

#include "common/model/catalogue.h"
#include "server/estimation/fit.h"

namespace tenter::diagnosis {
namespace {

using estimation::Curves;

/// Rate (1/s) and kind of the blocks of each component.
void examine_rates(const Curves& curves, std::map<int, std::pair<double, double>>& slowest_fastest,
                   Excitation& e) {
  for (const estimation::Block& block : curves.blocks) {
    if (block.last - block.first < 2) continue;
    const auto first = static_cast<std::size_t>(block.first);
    const auto last = static_cast<std::size_t>(block.last - 1);
    const double duration = curves.clock_s[last] - curves.clock_s[first];
    if (!(duration > 0.0)) continue;
    if (block.branch == capture::Branch::hold) {
      e.has_hold = true;
      continue;
    }
    const Eigen::Vector3d move = (curves.path.q[last] - curves.path.q[first]).cwiseAbs();
    int component = 0;
    const double most = move.maxCoeff(&component);
    if (curves.path.is_free[static_cast<std::size_t>(component)] || most < 1e-6) continue;
    const double rate = most / duration;
    auto [place, is_new] = slowest_fastest.emplace(component, std::pair{rate, rate});
    place->second.first = std::min(place->second.first, rate);
    place->second.second = std::max(place->second.second, rate);
  }
}

/// Whether the imposed strain of the curves goes back, and whether a strain is loaded again on the
/// same specimen.
void examine_path(const Curves& curves, Excitation& e) {
  for (int i = 0; i < 3; ++i) {
    if (curves.path.is_free[static_cast<std::size_t>(i)]) continue;
    double lo = curves.path.q.front()[i];
    double hi = lo;
    for (const auto& q : curves.path.q) {
      lo = std::min(lo, q[i]);
      hi = std::max(hi, q[i]);
    }
    const double range = hi - lo;
    if (range < 1e-6) continue;
    double peak = curves.path.q.front()[i];
    bool fell = false;
    for (std::size_t f = 0; f < curves.path.q.size(); ++f) {
      const bool new_run = f > 0 && curves.path.start[f] != mechanics::FrameStart::next;
      if (new_run) {
        fell = curves.path.start[f] == mechanics::FrameStart::rested;
        peak = curves.path.q[f][i];
      }
      const double q = curves.path.q[f][i];
      peak = std::max(peak, q);
      if (!new_run && q < peak - 0.2 * range && f > 0 && q < curves.path.q[f - 1][i]) {
        e.has_unloading = true;
        fell = true;
      }
      if (fell && f > 0 && !new_run && q > curves.path.q[f - 1][i] + 1e-9)
        e.has_repeated_loading = true;
    }
  }
}

double reach(const char* measure, double angle_rad, const std::vector<Curves>& curves) {
  model::StrainMeasure m;
  m.name = measure;
  m.angle_rad = angle_rad;
  const auto [lo, hi] = estimation::strain_range(m, curves);
  return std::max(std::abs(lo), std::abs(hi));
}

template <class T>
bool has_id(const std::vector<T>& list, const std::string& id) {
  return std::any_of(list.begin(), list.end(), [&](const T& t) { return t.id == id; });
}

template <class T>
std::string free_id(const std::vector<T>& list, const std::string& wanted) {
  std::string id = wanted;
  for (int k = 2; has_id(list, id); ++k) id = wanted + "_" + std::to_string(k);
  return id;
}

model::Parameter* find_parameter(model::Model& model, const std::string& address) {
  const auto dot = address.rfind('.');
  const std::string owner = address.substr(0, dot);
  const std::string name = address.substr(dot + 1);
  const auto search = [&](std::vector<model::Parameter>& list) -> model::Parameter* {
    for (model::Parameter& p : list)
      if (p.name == name) return &p;
    return nullptr;
  };
  for (model::Term& t : model.terms)
    if (t.id == owner) return search(t.law.parameters);
  for (model::SensorCorrection& c : model.corrections)
    if (c.id == owner) return search(c.parameters);
  return nullptr;
}

}  // namespace

Excitation examine(const std::vector<Curves>& curves) {
  Excitation e;
  e.curves = curves;
  constexpr double kDiagonal = 0.78539816339744831;
  e.weft = reach("green_u", 0.0, curves);
  e.warp = reach("green_v", 0.0, curves);
  e.shear = reach("green_uv", 0.0, curves);
  e.diagonal =
      std::max(reach("green_fibre", kDiagonal, curves), reach("green_fibre", -kDiagonal, curves));
  e.large_strain = std::max(e.weft, e.warp) > 0.2;
  std::map<int, std::pair<double, double>> rates;
  std::set<int> components;
  e.has_clock = e.has_rate = !curves.empty();
  e.longest_s = 0.0;
  e.shortest_step_s = 1e300;
  for (const Curves& c : curves) {
    e.has_clock = e.has_clock && c.time_base == estimation::TimeBase::clock;
    e.has_rate = e.has_rate && c.time_base != estimation::TimeBase::none;
    for (const auto& channel : c.channels)
      if (channel.is_stress) components.insert(channel.component);
    for (const auto& run : c.runs)
      e.longest_s = std::max(e.longest_s, c.clock_s[static_cast<std::size_t>(run.last - 1)] -
                                              c.clock_s[static_cast<std::size_t>(run.first)]);
    for (const double d : c.path.duration_s)
      if (d > 0.0) e.shortest_step_s = std::min(e.shortest_step_s, d);
    examine_rates(c, rates, e);
    examine_path(c, e);
  }
  if (!(e.longest_s > 0.0)) e.longest_s = 1.0;
  if (e.shortest_step_s > e.longest_s) e.shortest_step_s = e.longest_s / 100.0;
  for (const auto& [component, pair] : rates)
    e.rate_span = std::max(e.rate_span, pair.second / pair.first);
  e.has_hold = e.has_hold && e.has_clock;
  e.stress_components.assign(components.begin(), components.end());
  return e;
}

std::string measure_key(const model::StrainMeasure& measure) {
  return measure.name + "@" + std::to_string(measure.angle_rad);
}

std::pair<double, double> range_of(const Excitation& excitation,
                                   const model::StrainMeasure& measure) {
  if (!excitation.sheet) return estimation::strain_range(measure, excitation.curves);
  const auto found = excitation.sheet->ranges.find(measure_key(measure));
  return found == excitation.sheet->ranges.end() ? std::pair{0.0, 0.0} : found->second;
}

std::vector<Variant> variants_of(const Effect& effect, const model::Model& model,
                                 const Excitation& excitation) {
  if (excitation.sheet && effect.sheet_variants) return effect.sheet_variants(model, excitation);
  if (excitation.sheet && effect.kind != effects::Kind::material) return {};
  return effect.variants(model, excitation);
}

std::optional<std::string> why_not_excited(const Effect& effect, const model::Model& model,
                                           const Excitation& excitation) {
  if (excitation.sheet && effect.sheet_not_excited)
    return effect.sheet_not_excited(model, excitation);
  if (excitation.sheet && effect.kind != effects::Kind::material && !effect.sheet_variants)
    return "nothing of it shows on sheets";
  return effect.not_excited(model, excitation);
}

Effect described(const std::string& id) {
  const effects::Row* row = effects::find(id);
  if (row == nullptr) std::abort();  // a row of our own catalogue without words
  Effect effect;
  effect.id = row->id;
  effect.words = row->words;
  effect.kind = row->kind;
  effect.mistaken_for = row->mistaken_for;
  effect.split_by = row->protocol;
  return effect;
}

model::Model extend(const model::Model& base, const Variant& variant, const Setting& setting,
                    const std::string& effect_id) {
  model::Model model = base;
  for (const auto& [id, law] : variant.replace)
    for (model::Term& term : model.terms)
      if (term.id == id) {
        term.law = law;
        if (term.effect.empty()) term.effect = effect_id;
      }
  for (const model::Field& field : variant.fields) {
    const bool is_there = std::any_of(model.fields.begin(), model.fields.end(),
                                      [&](const model::Field& f) { return f.id == field.id; });
    if (!is_there) model.fields.push_back(field);
  }
  for (const std::string& address : variant.unfix)
    if (model::Parameter* p = find_parameter(model, address)) p->fixed = false;
  for (model::Term term : variant.append) {
    term.effect = effect_id;
    model.terms.push_back(std::move(term));
  }
  for (model::SensorCorrection correction : variant.corrections) {
    correction.effect = effect_id;
    model.corrections.push_back(std::move(correction));
  }
  for (const auto& [address, value] : setting)
    if (model::Parameter* p = find_parameter(model, address)) p->value = value;
  return model;
}

model::Term new_term(const model::Model& model, const std::string& id, const std::string& measure,
                     double angle_rad, const std::string& law, int control_points) {
  model::Term term;
  term.id = free_id(model.terms, id);
  term.strain.name = measure;
  term.strain.angle_rad = angle_rad;
  term.law.name = law;
  term.law.parameters = model::default_parameters(*model::find_law(law), control_points,
                                                  model::find_strain(measure)->domain);
  return term;
}

void set_parameter(model::Law& law, const std::string& name, double value, bool fixed) {
  for (model::Parameter& p : law.parameters) {
    if (p.name != name) continue;
    p.value = value;
    p.fixed = fixed;
  }
}

model::SensorCorrection new_correction(const model::Model& model, const std::string& type,
                                       const std::string& component) {
  model::SensorCorrection correction;
  correction.id = free_id(model.corrections, type + (component.empty() ? "" : "_" + component));
  correction.type = type;
  correction.component = component;
  correction.parameters = model::default_parameters(*model::find_correction(type));
  return correction;
}

model::SensorCorrection new_sheet_correction(const model::Model& model, const std::string& type,
                                             const std::string& component,
                                             const std::string& capture) {
  model::SensorCorrection correction;
  correction.id = free_id(model.corrections, type + (component.empty() ? "" : "_" + component) +
                                                 (capture.empty() ? "" : "_in_" + capture));
  // addresses end at the last dot
  std::replace(correction.id.begin(), correction.id.end(), '.', '_');
  correction.type = type;
  correction.component = component;
  correction.capture = capture;
  correction.parameters =
      model::default_parameters(*model::find_correction(type, model::Seen::sheets));
  return correction;
}

std::string measure_family(const model::Model& model) {
  for (const model::Term& term : model.terms)
    if (term.effect.empty() &&
        (term.strain.name.starts_with("soft_") || term.strain.name.starts_with("spring_")))
      return "soft";
  return "green";
}

namespace {

/// Fibres across the diagonals feel both stretches, or a shear that is imposed. Where a strip was
/// pulled and nobody looked how it narrows, what they feel is the stiffness across, which such
/// pulls do not tell.
bool knows_diagonals(const Excitation& excitation) {
  constexpr double kSheared = 1e-3;
  if (excitation.sheet) return true;
  return std::ranges::any_of(excitation.curves, [](const estimation::Curves& curves) {
    const auto is_known = [&](int component) {
      return !curves.path.is_free[static_cast<std::size_t>(component)] ||
             std::ranges::any_of(curves.channels, [&](const auto& channel) {
               return !channel.is_stress && channel.component == component;
             });
    };
    const bool is_sheared = std::ranges::any_of(
        curves.path.q, [](const Eigen::Vector3d& q) { return std::abs(q[2]) > kSheared; });
    return (is_known(0) && is_known(1)) || (is_known(2) && is_sheared);
  });
}

}  // namespace

std::vector<Place> places(const model::Model& model, const Excitation& excitation,
                          bool both_families) {
  constexpr double kDiagonal = 0.78539816339744831;
  constexpr double kSmallest = 1e-4;          // strains below do not count as excited
  constexpr double kSmallestCurvature = 1.0;  // 1/m: a radius of a metre is flat
  std::vector<std::string> families = {measure_family(model)};
  if (both_families && excitation.large_strain)
    families.push_back(families[0] == "green" ? "soft" : "green");
  std::vector<Place> all;
  const auto add = [&](const std::string& name, const std::string& measure, double angle) {
    Place place{name, measure, angle, 0.0, 0.0};
    model::StrainMeasure m;
    m.name = measure;
    m.angle_rad = angle;
    std::tie(place.lo, place.hi) = range_of(excitation, m);
    const bool bends = model::find_strain(measure)->domain == model::Domain::hinge;
    if (place.reach() > (bends ? kSmallestCurvature : kSmallest)) all.push_back(place);
  };
  for (const std::string& family : families) {
    add("weft", family + "_u", 0.0);
    add("warp", family + "_v", 0.0);
    if (&family == &families.front()) add("shear", "green_uv", 0.0);
    if (knows_diagonals(excitation))
      add("diagonal", family == "green" ? "green_fibre_pair" : "fibre_pair", kDiagonal);
  }
  if (excitation.sheet) {
    add("bend_weft", "bend_u", 0.0);
    add("bend_warp", "bend_v", 0.0);
    add("bend_diagonal", "bend_d", 0.0);
  }
  return all;
}

bool has_coupling(const model::Model& model) {
  for (const model::Term& term : model.terms) {
    const std::string& name = term.strain.name;
    const bool tied = name.ends_with("pair") || name == "area" || name == "green_trace" ||
                      name.starts_with("spring_d") || name.ends_with("fibre");
    const model::LawRow* law = model::find_law(term.law.name);
    if (tied && law && !law->path_dependent) return true;
  }
  return false;
}

std::vector<std::vector<Place>> place_groups(const std::vector<Place>& all) {
  std::vector<std::vector<Place>> groups;
  groups.reserve(all.size());
  for (const Place& place : all) groups.push_back({place});
  for (std::size_t i = 0; i + 1 < all.size(); ++i) {
    if (all[i].name == "bend_weft" && all[i + 1].name == "bend_warp")
      groups.push_back({all[i], all[i + 1]});
    if (all[i].name != "weft" || all[i + 1].name != "warp") continue;
    groups.push_back({all[i], all[i + 1]});
    for (std::size_t k = i + 2; k < all.size(); ++k) {
      if (all[k].name == "weft") break;
      if (all[k].name == "diagonal") groups.push_back({all[i], all[i + 1], all[k]});
    }
  }
  return groups;
}

namespace {

std::string words_of_place(const std::string& name) {
  if (name == "bend_weft") return "bending along the weft";
  if (name == "bend_warp") return "bending along the warp";
  if (name == "bend_diagonal") return "bending across the diagonals";
  return name;
}

}  // namespace

std::string place_words(const std::vector<Place>& group) {
  std::string words;
  for (std::size_t i = 0; i < group.size(); ++i) {
    if (i > 0) words += i + 1 == group.size() ? " and " : ", ";
    words += words_of_place(group[i].name);
  }
  const std::string& measure = group.front().measure;
  if (measure.starts_with("soft") || measure == "fibre_pair") words += " (engineering strain)";
  return words;
}

}  // namespace tenter::diagnosis
