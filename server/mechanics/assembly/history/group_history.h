// SPDX-License-Identifier: GPL-3.0-or-later
// The history of a group of elements: where a step ends, and how both forces and end answer to a
// change of the start. With sigma the stress of the law, h its state before and H after the step,
//
//   d2E/dx dh dh = m sum_i deps_i/dx (dsigma_i/dh dh)
//   dH = dH/deps (deps/dx dx) + dH/dh dh + dH/dp dp
//
// For the two makers of MeshModel: they instantiate ElementGroup.
#pragma once

#include "server/mechanics/assembly/element_group.h"

namespace tenter::mechanics {

/// A law's answers on a chunk, kept one behind the other; too large for LawOutput of each element.
struct ChunkMemory {
  double stress_by_state[kMaxStrains][kMaxLawState][kChunk];
  double state_by_strain[kMaxLawState][kMaxStrains][kChunk];
  double state_by_state[kMaxLawState][kMaxLawState][kChunk];
  double state_by_parameter[kMaxLawState][kMaxLawParameters][kChunk];

  void fill(const Law& law, const double* parameters, const LawBatch& batch) {
    const int strains = law.strain_count(), states = law.state_count();
    double strain[kMaxStrains], state[kMaxLawState];
    LawOutput out;
    for (int e = 0; e < batch.count; ++e) {
      for (int i = 0; i < strains; ++i) strain[i] = batch.strain[i][e];
      for (int s = 0; s < states; ++s) state[s] = batch.state[s][e];
      law.clear(out);
      law.evaluate({strain, parameters, state, batch.duration_s, false}, out);
      for (int s = 0; s < states; ++s) {
        for (int i = 0; i < strains; ++i) {
          stress_by_state[i][s][e] = out.stress_by_state[i][s];
          state_by_strain[s][i][e] = out.state_by_strain[s][i];
        }
        for (int r = 0; r < states; ++r) state_by_state[s][r][e] = out.state_by_state[s][r];
        for (int p = 0; p < law.parameter_count(); ++p)
          state_by_parameter[s][p][e] = out.state_by_parameter[s][p];
      }
    }
  }
};

/// work(term, chunk, batch, first, count) for every term that remembers and every chunk, strains
/// and start of the step filled in. A group without such a term costs nothing.
template <class Elements, int Z>
template <class Work>
AssemblyStatus ElementGroup<Elements, Z>::each_remembering(const double* x, const History& history,
                                                           Work work) const {
  const auto remembers = [](const GroupTerm& term) { return term.law->state_count() > 0; };
  if (std::none_of(terms.begin(), terms.end(), remembers)) return AssemblyStatus::ok;
  return each_chunk(x, [&](Chunk& chunk, int first, int count) {
    for (const GroupTerm& term : terms) {
      if (!remembers(term)) continue;
      LawBatch batch = chunk.batch(count, false, false);
      term.start_from(&history, first, batch);
      term.strain->strains(chunk.z, first, count, chunk.strain);
      work(term, chunk, batch, first, count);
    }
  });
}

template <class Elements, int Z>
AssemblyStatus ElementGroup<Elements, Z>::end_of_step(const double* x, const double* parameters,
                                                      const History& history, double* end) const {
  return each_remembering(
      x, history, [&](const GroupTerm& term, Chunk&, LawBatch& batch, int first, int count) {
        const int states = term.law->state_count();
        // the end may be where the start is
        double at_end[kMaxLawState * kChunk];
        for (int s = 0; s < states; ++s) batch.end_state[s] = at_end + s * kChunk;
        term.law->evaluate_batch(parameters + term.first_parameter, batch);
        for (int s = 0; s < states; ++s)
          std::copy_n(at_end + s * kChunk, count,
                      end + term.first_state + s * elements_.count() + first);
      });
}

template <class Elements, int Z>
AssemblyStatus ElementGroup<Elements, Z>::add_by_history(const double* x, const double* parameters,
                                                         const History& history,
                                                         const Eigen::MatrixXd& change,
                                                         Eigen::MatrixXd& result) const {
  ChunkMemory memory;
  return each_remembering(
      x, history, [&](const GroupTerm& term, Chunk& chunk, LawBatch& batch, int first, int count) {
        const int states = term.law->state_count();
        memory.fill(*term.law, parameters + term.first_parameter, batch);
        for (Eigen::Index c = 0; c < change.cols(); ++c) {
          const double* dh = change.col(c).data() + term.first_state + first;
          for (int i = 0; i < term.law->strain_count(); ++i) {
            double* stress = batch.stress[i];
            std::fill_n(stress, count, 0.0);
            for (int s = 0; s < states; ++s)
              for (int e = 0; e < count; ++e)
                stress[e] += memory.stress_by_state[i][s][e] * dh[s * elements_.count() + e];
          }
          double psi_z[Z * kChunk] = {};
          term.strain->chain(chunk.z, first, batch, term.measure.data() + first, psi_z, nullptr);
          add_gradient(elements_, x, first, count, psi_z, result.col(c).data());
        }
      });
}

template <class Elements, int Z>
AssemblyStatus ElementGroup<Elements, Z>::carry_change(const double* x, const double* parameters,
                                                       const History& history,
                                                       const Eigen::MatrixXd& x_change,
                                                       const std::vector<Eigen::Index>& columns,
                                                       Eigen::MatrixXd& change) const {
  ChunkMemory memory;
  double one[kChunk];
  std::fill_n(one, kChunk, 1.0);
  return each_remembering(
      x, history, [&](const GroupTerm& term, Chunk& chunk, LawBatch& batch, int first, int count) {
        const int states = term.law->state_count();
        const int strains = term.law->strain_count();
        memory.fill(*term.law, parameters + term.first_parameter, batch);
        // deps_i/dz: what a stress of one would do
        double strain_by_z[kMaxStrains][Z * kChunk] = {};
        for (int i = 0; i < strains; ++i) {
          for (int j = 0; j < strains; ++j) std::fill_n(batch.stress[j], count, i == j ? 1.0 : 0.0);
          term.strain->chain(chunk.z, first, batch, one, strain_by_z[i], nullptr);
        }
        for (std::size_t c = 0; c < columns.size(); ++c) {
          const auto column = static_cast<Eigen::Index>(c);
          double dz[Z * kChunk];
          see_change(elements_, x, x_change.col(column).data(), first, count, dz);
          double* dh = change.col(column).data() + term.first_state + first;
          const auto own = static_cast<int>(columns[c]) - term.first_parameter;
          const bool is_own = own >= 0 && own < term.law->parameter_count();
          for (int e = 0; e < count; ++e) {
            double dstrain[kMaxStrains] = {}, before[kMaxLawState];
            for (int i = 0; i < strains; ++i)
              for (int k = 0; k < Z; ++k)
                dstrain[i] += strain_by_z[i][k * kChunk + e] * dz[k * kChunk + e];
            for (int s = 0; s < states; ++s) before[s] = dh[s * elements_.count() + e];
            for (int s = 0; s < states; ++s) {
              double sum = is_own ? memory.state_by_parameter[s][own][e] : 0.0;
              for (int i = 0; i < strains; ++i) sum += memory.state_by_strain[s][i][e] * dstrain[i];
              for (int r = 0; r < states; ++r) sum += memory.state_by_state[s][r][e] * before[r];
              dh[s * elements_.count() + e] = sum;
            }
          }
        }
      });
}

/// Positions do not move, so that a term's state changes with its own parameters alone.
template <class Elements, int Z>
AssemblyStatus ElementGroup<Elements, Z>::take_held_step(const double* x, const double* parameters,
                                                         const std::vector<Eigen::Index>& columns,
                                                         History& history, Eigen::MatrixXd& change,
                                                         Eigen::MatrixXd& force) const {
  const Eigen::Index elements = elements_.count();
  std::vector<double> stress(columns.size() * kMaxStrains * kChunk);
  return each_remembering(
      x, history, [&](const GroupTerm& term, Chunk& chunk, LawBatch& batch, int first, int count) {
        const Law& law = *term.law;
        const int strains = law.strain_count(), states = law.state_count();
        const auto own = [&](std::size_t c) {
          const auto p = static_cast<int>(columns[c]) - term.first_parameter;
          return p < law.parameter_count() ? p : -1;
        };
        const double* own_parameters = parameters + term.first_parameter;
        double strain[kMaxStrains], state[kMaxLawState], before[kMaxLawState];
        LawOutput out;
        for (int e = 0; e < count; ++e) {
          for (int i = 0; i < strains; ++i) strain[i] = batch.strain[i][e];
          for (int s = 0; s < states; ++s) state[s] = batch.state[s][e];
          law.clear(out);
          law.evaluate({strain, own_parameters, state, batch.duration_s, false}, out);
          const Eigen::Index at = term.first_state + first + e;
          for (std::size_t c = 0; c < columns.size(); ++c) {
            const int p = own(c);
            if (p < 0) continue;
            double* dh = change.col(static_cast<Eigen::Index>(c)).data() + at;
            for (int s = 0; s < states; ++s) before[s] = dh[s * elements];
            for (int i = 0; i < strains; ++i) {
              double sum = out.stress_by_parameter[i][p];
              for (int s = 0; s < states; ++s) sum += out.stress_by_state[i][s] * before[s];
              stress[(c * kMaxStrains + static_cast<std::size_t>(i)) * kChunk +
                     static_cast<std::size_t>(e)] = sum;
            }
            for (int s = 0; s < states; ++s) {
              double sum = out.state_by_parameter[s][p];
              for (int r = 0; r < states; ++r) sum += out.state_by_state[s][r] * before[r];
              dh[s * elements] = sum;
            }
          }
          for (int s = 0; s < states; ++s) history.state[at + s * elements] = out.state[s];
        }
        for (std::size_t c = 0; c < columns.size(); ++c) {
          if (own(c) < 0) continue;
          for (int i = 0; i < strains; ++i)
            batch.stress[i] =
                stress.data() + (c * kMaxStrains + static_cast<std::size_t>(i)) * kChunk;
          double psi_z[Z * kChunk] = {};
          term.strain->chain(chunk.z, first, batch, term.measure.data() + first, psi_z, nullptr);
          add_gradient(elements_, x, first, count, psi_z,
                       force.col(static_cast<Eigen::Index>(c)).data());
        }
      });
}

}  // namespace tenter::mechanics
