// SPDX-License-Identifier: GPL-3.0-or-later
// Groups of each kind of element: sums over chunks of strains, laws and supports.
#pragma once

#include <algorithm>
#include <cmath>
#include <utility>

#include "server/mechanics/assembly/group.h"
#include "server/mechanics/assembly/positive_part.h"
#include "server/mechanics/elements/from_mesh.h"
#include "server/mechanics/principal_stretch.h"

namespace tenter::mechanics {

/// What the elements of a hinge group see; the others see entries of C. False: a solid element is
/// flat or turned inside out. `see_change`: how that changes with displacements of the nodes.
inline bool see(const HingeElements& elements, const double* x, int first, int count, double* z) {
  hinge_angles(elements, x, first, count, z);
  return true;
}
template <int N, int D>
bool see(const GradientElements<N, D>& elements, const double* x, int first, int count, double* z) {
  cauchy_green(elements, x, first, count, z);
  if constexpr (D == 3) {
    double j[kChunk];
    volume_ratios(elements, x, first, count, j);
    // positions that are not numbers pass: what follows from them says so
    return std::none_of(j, j + count, [](double ratio) { return ratio <= kCollapsedStretch; });
  }
  return true;
}

inline void see_change(const HingeElements& elements, const double* x, const double* dx, int first,
                       int count, double* dz) {
  hinge_angles_change(elements, x, dx, first, count, dz);
}
template <int N, int D>
void see_change(const GradientElements<N, D>& elements, const double* x, const double* dx,
                int first, int count, double* dz) {
  cauchy_green_change(elements, x, dx, first, count, dz);
}

/// `Z`: how many numbers the elements see.
template <class Elements, int Z>
class ElementGroup final : public MeshModel::Group {
 public:
  ElementGroup(Elements elements, ElementKind its_kind, std::vector<int> numbers)
      : Group(its_kind, std::move(numbers)), elements_(std::move(elements)) {}

  const Elements& elements() const { return elements_; }
  const std::vector<double>& measure() const override { return elements_.measure; }
  std::vector<std::pair<int, int>> pairs() const override { return coupled_nodes(elements_); }
  void find_slots(const NodeMatrix& matrix) override {
    elements_.slots = block_slots(matrix, elements_.nodes);
  }

  AssemblyStatus add(const double* x, const double* parameters, const ModelOutput& output,
                     const EnergyLimitState* state, const History* history) const override {
    const bool wants_forces = output.gradient || output.stiffness;
    const bool is_ahead = history && history->is_ahead;
    Chunk chunk;
    for (int first = 0; first < elements_.count(); first += kChunk) {
      const int count = std::min(kChunk, elements_.count() - first);
      double psi_z[Z * kChunk] = {};
      double psi_zz[c_entries(Z) * kChunk] = {};
      double excess_z[Z * kChunk];
      if (is_ahead) std::fill_n(excess_z, Z * kChunk, 0.0);
      if (!see(elements_, x, first, count, chunk.z)) return AssemblyStatus::inverted;
      for (const GroupTerm& term : terms) {
        LawBatch batch = chunk.batch(count, output.energy != nullptr, output.stiffness != nullptr);
        term.start_from(history, first, batch);
        term.strain->strains(chunk.z, first, count, chunk.strain);
        const double* measure = term.measure.data() + first;
        if (is_ahead && term.law->turns_round()) {
          double beyond[kMaxStrains * kChunk];
          term.evaluate_ahead(parameters, *history, first, batch, beyond);
          LawBatch excess = batch;
          for (int i = 0; i < kMaxStrains; ++i) excess.stress[i] = beyond + i * kChunk;
          if (output.stiffness)
            term.strain->chain(chunk.z, first, excess, measure, excess_z, nullptr);
        } else {
          term.law->evaluate_batch(parameters + term.first_parameter, batch);
        }
        if (output.energy)
          for (int e = 0; e < count; ++e) *output.energy += measure[e] * chunk.energy[e];
        if (wants_forces)
          term.strain->chain(chunk.z, first, batch, measure, psi_z,
                             output.stiffness ? psi_zz : nullptr);
      }
      if (state)
        for (const GroupLimit& limit : limits)
          add_limit(limit, *state, parameters, chunk, first, count, output.energy,
                    wants_forces ? psi_z : nullptr, output.stiffness ? psi_zz : nullptr);
      if (output.gradient) add_gradient(elements_, x, first, count, psi_z, output.gradient->data());
      // stresses beyond those ahead are of strains that the guess is off by: they hold nothing up
      if (is_ahead)
        for (int k = 0; k < Z * kChunk; ++k) psi_z[k] -= excess_z[k];
      if (output.stiffness && output.positive_share > 0.0)
        take_positive_part(elements_, count, output.positive_share, psi_z, psi_zz);
      if (output.stiffness)
        add_stiffness(elements_, x, first, count, psi_z, psi_zz, *output.stiffness);
    }
    return AssemblyStatus::ok;
  }

  AssemblyStatus add_by_parameter(const double* x, const double* parameters,
                                  const EnergyLimitState* state, const History* history,
                                  Eigen::MatrixXd& result) const override {
    return each_chunk(x, [&](Chunk& chunk, int first, int count) {
      for (std::size_t t = 0; t < terms.size(); ++t) {
        const GroupTerm& term = terms[t];
        double measure[kChunk];
        std::copy_n(term.measure.data() + first, count, measure);
        if (state) stiffen(static_cast<int>(t), *state, parameters, chunk, first, count, measure);
        term.strain->strains(chunk.z, first, count, chunk.strain);
        for (int p = 0; p < term.law->parameter_count(); ++p) {
          LawBatch batch = chunk.batch(count, false, false);
          term.start_from(history, first, batch);
          term.law->stress_by_parameter_batch(parameters + term.first_parameter, p, batch);
          double psi_z[Z * kChunk] = {};
          term.strain->chain(chunk.z, first, batch, measure, psi_z, nullptr);
          add_gradient(elements_, x, first, count, psi_z,
                       result.col(term.first_parameter + p).data());
        }
      }
    });
  }

  // history/group_history.h
  AssemblyStatus end_of_step(const double* x, const double* parameters, const History& history,
                             double* end) const override;
  AssemblyStatus add_by_history(const double* x, const double* parameters, const History& history,
                                const Eigen::MatrixXd& change,
                                Eigen::MatrixXd& result) const override;
  AssemblyStatus carry_change(const double* x, const double* parameters, const History& history,
                              const Eigen::MatrixXd& x_change,
                              const std::vector<Eigen::Index>& columns,
                              Eigen::MatrixXd& change) const override;
  AssemblyStatus take_held_step(const double* x, const double* parameters,
                                const std::vector<Eigen::Index>& columns, History& history,
                                Eigen::MatrixXd& change, Eigen::MatrixXd& force) const override;

  AssemblyStatus fill_limits(const double* x, const double* parameters,
                             ActiveLimits& active) const override {
    if (limits.empty()) return AssemblyStatus::ok;
    return each_chunk(x, [&](Chunk& chunk, int first, int count) {
      for (const GroupLimit& limit : limits) {
        const int first_entry = limit.first + first;
        auto entry = std::lower_bound(active.entry.begin(), active.entry.end(), first_entry);
        if (entry == active.entry.end() || *entry >= first_entry + count) continue;
        Density density;
        add_density(limit, parameters, chunk, first, count, density, density.by_z, nullptr);
        const auto column = static_cast<Eigen::Index>(entry - active.entry.begin());
        Eigen::Index k = column;
        for (; entry != active.entry.end() && *entry < first_entry + count; ++entry, ++k) {
          const int e = *entry - first_entry;
          double alone[Z * kChunk] = {};
          for (int i = 0; i < Z; ++i) alone[i * kChunk + e] = density.by_z[i * kChunk + e];
          add_gradient(elements_, x, first, count, alone, active.by_x.col(k).data());
        }
        for (const int t : limit.terms)
          density_by_parameter(terms[static_cast<std::size_t>(t)], parameters, chunk, first, count,
                               first_entry, column, active);
      }
    });
  }

  AssemblyStatus add_term_energies(const double* x, const double* parameters,
                                   const History* history, double* energies) const override {
    return each_chunk(x, [&](Chunk& chunk, int first, int count) {
      for (const GroupTerm& term : terms) {
        LawBatch batch = chunk.batch(count, true, false);
        term.start_from(history, first, batch);
        term.strain->strains(chunk.z, first, count, chunk.strain);
        term.law->evaluate_batch(parameters + term.first_parameter, batch);
        const double* measure = term.measure.data() + first;
        for (int e = 0; e < count; ++e) energies[term.term] += measure[e] * chunk.energy[e];
      }
    });
  }

  AssemblyStatus strains_of(const GroupTerm& term, const double* x,
                            std::vector<double>& strain) const override {
    const int strains = term.strain->count();
    strain.resize(static_cast<std::size_t>(strains * elements_.count()));
    bool finite = true;
    const AssemblyStatus status = each_chunk(x, [&](Chunk& chunk, int first, int count) {
      term.strain->strains(chunk.z, first, count, chunk.strain);
      double* out = strain.data() + strains * first;
      for (int e = 0; e < count; ++e)
        for (int i = 0; i < strains; ++i) {
          *out = chunk.strain[i * kChunk + e];
          finite = finite && std::isfinite(*out++);
        }
    });
    return status == AssemblyStatus::ok && !finite ? AssemblyStatus::not_finite : status;
  }

  AssemblyStatus limit_excess(const double* x, const double* parameters,
                              double* excess) const override {
    if (limits.empty()) return AssemblyStatus::ok;
    return each_chunk(x, [&](Chunk& chunk, int first, int count) {
      for (const GroupLimit& limit : limits) {
        Density density;
        add_density(limit, parameters, chunk, first, count, density, nullptr, nullptr);
        for (int e = 0; e < count; ++e)
          excess[limit.first + first + e] = density.value[e] - limit.energy_max;
      }
    });
  }

 private:
  /// One chunk on the stack.
  struct Chunk {
    double z[Z * kChunk];
    double strain[kMaxStrains * kChunk];
    double energy[kChunk];
    double stress[kMaxStrains * kChunk];
    double tangent[kMaxStrains * kMaxStrains * kChunk];

    LawBatch batch(int count, bool wants_energy, bool wants_tangent) {
      LawBatch result;
      result.count = count;
      result.energy = wants_energy ? energy : nullptr;
      for (int i = 0; i < kMaxStrains; ++i) {
        result.strain[i] = strain + i * kChunk;
        result.stress[i] = stress + i * kChunk;
        for (int j = i; wants_tangent && j < kMaxStrains; ++j)
          result.tangent[i][j] = tangent + (i * kMaxStrains + j) * kChunk;
      }
      return result;
    }
  };

  /// The energy density that is limited and its derivatives by z, of one chunk.
  struct Density {
    double value[kChunk] = {};
    double by_z[Z * kChunk] = {};
    double by_zz[c_entries(Z) * kChunk] = {};
  };

  /// Sums up the terms of a limit; derivatives where `by_z` and `by_zz` are not null.
  void add_density(const GroupLimit& limit, const double* parameters, Chunk& chunk, int first,
                   int count, Density& density, double* by_z, double* by_zz) const {
    for (const int t : limit.terms) {
      const GroupTerm& term = terms[static_cast<std::size_t>(t)];
      double weight[kChunk];
      for (int e = 0; e < count; ++e) {
        const auto k = static_cast<std::size_t>(first + e);
        weight[e] = elements_.measure[k] > 0.0 ? term.measure[k] / elements_.measure[k] : 0.0;
      }
      LawBatch batch = chunk.batch(count, true, by_zz != nullptr);
      term.strain->strains(chunk.z, first, count, chunk.strain);
      term.law->evaluate_batch(parameters + term.first_parameter, batch);
      for (int e = 0; e < count; ++e) density.value[e] += weight[e] * chunk.energy[e];
      if (by_z) term.strain->chain(chunk.z, first, batch, weight, by_z, by_zz);
    }
  }

  /// Adds to the measure what active limits stiffen a term by: a times as much.
  void stiffen(int term, const EnergyLimitState& state, const double* parameters, Chunk& chunk,
               int first, int count, double* measure) const {
    for (const GroupLimit& limit : limits) {
      if (std::find(limit.terms.begin(), limit.terms.end(), term) == limit.terms.end()) continue;
      Density density;
      add_density(limit, parameters, chunk, first, count, density, nullptr, nullptr);
      const double* own = terms[static_cast<std::size_t>(term)].measure.data() + first;
      for (int e = 0; e < count; ++e) {
        const double excess = density.value[e] - limit.energy_max;
        measure[e] += own[e] * std::max(0.0, state.multiplier[limit.first + first + e] +
                                                 state.penalty * excess);
      }
    }
  }

  /// Adds dpsi/dp of one term to the rows of the active entries of a chunk, by differences over
  /// four energies, without error up to the fourth power.
  void density_by_parameter(const GroupTerm& term, const double* parameters, Chunk& chunk,
                            int first, int count, int first_entry, Eigen::Index row,
                            ActiveLimits& active) const {
    constexpr double kStep = 1e-3;
    constexpr double kSteps[] = {-2.0, -1.0, 1.0, 2.0};
    constexpr double kWeights[] = {1.0 / 12.0, -8.0 / 12.0, 8.0 / 12.0, -1.0 / 12.0};
    const int parameter_count = term.law->parameter_count();
    double own[kMaxLawParameters];
    std::copy_n(parameters + term.first_parameter, parameter_count, own);
    term.strain->strains(chunk.z, first, count, chunk.strain);
    for (int p = 0; p < parameter_count; ++p) {
      const double value = own[p];
      const double step = value != 0.0 ? kStep * std::abs(value) : kStep;
      double slope[kChunk] = {};
      for (int s = 0; s < 4; ++s) {
        own[p] = value + kSteps[s] * step;
        const LawBatch batch = chunk.batch(count, true, false);
        term.law->evaluate_batch(own, batch);
        for (int e = 0; e < count; ++e) slope[e] += kWeights[s] * chunk.energy[e] / step;
      }
      own[p] = value;
      for (auto k = static_cast<std::size_t>(row);
           k < active.entry.size() && active.entry[k] < first_entry + count; ++k) {
        const int e = active.entry[k] - first_entry;
        const auto element_of = static_cast<std::size_t>(first + e);
        const double m = elements_.measure[element_of];
        const double weight = m > 0.0 ? term.measure[element_of] / m : 0.0;
        active.by_parameter(static_cast<Eigen::Index>(k), term.first_parameter + p) +=
            weight * slope[e];
      }
    }
  }

  /// The part of a limit in the sums of a chunk: see energy_limit.h.
  void add_limit(const GroupLimit& limit, const EnergyLimitState& state, const double* parameters,
                 Chunk& chunk, int first, int count, double* energy, double* psi_z,
                 double* psi_zz) const {
    Density density;
    add_density(limit, parameters, chunk, first, count, density, psi_z ? density.by_z : nullptr,
                psi_zz ? density.by_zz : nullptr);
    const double mu = state.penalty;
    for (int e = 0; e < count; ++e) {
      const double m = elements_.measure[static_cast<std::size_t>(first + e)];
      const double multiplier = state.multiplier[limit.first + first + e];
      const double excess = density.value[e] - limit.energy_max;
      const double a = multiplier + mu * excess;
      if (a <= 0.0) {
        if (energy) *energy -= 0.5 * m * multiplier * multiplier / mu;
        continue;
      }
      if (energy) *energy += 0.5 * m * excess * (a + multiplier);  // (a^2 - l^2)/(2 mu)
      const double* by_z = density.by_z + e;
      for (int k = 0; psi_z && k < Z; ++k) psi_z[k * kChunk + e] += m * a * by_z[k * kChunk];
      if (!psi_zz) continue;
      int row = e;
      for (int k = 0; k < Z; ++k)
        for (int l = k; l < Z; ++l, row += kChunk)
          psi_zz[row] += m * (a * density.by_zz[row] + mu * by_z[k * kChunk] * by_z[l * kChunk]);
    }
  }

  /// work(chunk, first, count) with z of every chunk in turn.
  template <class Work>
  AssemblyStatus each_chunk(const double* x, Work work) const {
    Chunk chunk;
    for (int first = 0; first < elements_.count(); first += kChunk) {
      const int count = std::min(kChunk, elements_.count() - first);
      if (!see(elements_, x, first, count, chunk.z)) return AssemblyStatus::inverted;
      work(chunk, first, count);
    }
    return AssemblyStatus::ok;
  }

  // history/group_history.h
  template <class Work>
  AssemblyStatus each_remembering(const double* x, const History& history, Work work) const;

  Elements elements_;
};

}  // namespace tenter::mechanics
