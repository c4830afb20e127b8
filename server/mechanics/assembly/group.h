// SPDX-License-Identifier: GPL-3.0-or-later
// Elements of one kind and the terms that act on them: what MeshModel is made of.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "server/mechanics/assembly/chunk_strain.h"
#include "server/mechanics/assembly/mesh_model.h"

namespace tenter::mechanics {

struct GroupTerm {
  std::shared_ptr<const ChunkStrain> strain;
  std::shared_ptr<const Law> law;
  int term = 0;  ///< its place among the model's
  int first_parameter = 0;
  int first_state = 0;          ///< in a History: [first_state + variable * elements + element]
  std::vector<double> measure;  ///< of the element, times the support's weight there

  /// Where the step of the elements from `first` starts, as a batch or a single evaluation has it.
  void start_from(const History* history, int first, LawBatch& batch) const {
    if (!history) return;
    const auto elements = static_cast<int>(measure.size());
    const bool has_own = law->is_rate() && history->rate_duration_s > 0.0;
    batch.duration_s = has_own ? history->rate_duration_s : history->duration_s;
    const double* state = has_own ? history->rate_state.data() : history->state.data();
    for (int s = 0; s < law->state_count(); ++s)
      batch.state[s] = state + first_state + s * elements + first;
  }

  /// The law's linearisation at the strains of `history.ahead`, at those of the batch; `beyond`:
  /// what the stresses have more than there, [i * kChunk + e].
  void evaluate_ahead(const double* parameters, const History& history, int first, LawBatch& batch,
                      double* beyond) const;
};

/// An energy limit on the elements of a group.
struct GroupLimit {
  std::vector<int> terms;  ///< places of the limited ones in the group
  double energy_max = 0.0;
  int first = 0;  ///< place of the group's first element in multipliers and excesses
};

class MeshModel::Group {
 public:
  virtual ~Group() = default;
  /// Adds to what is wanted of `output`.
  virtual AssemblyStatus add(const double* x, const double* parameters, const ModelOutput& output,
                             const EnergyLimitState* state, const History* history) const = 0;
  /// Adds d2E/dx dp into the columns of its own parameters; of limits only m a d2psi/dx dp.
  virtual AssemblyStatus add_by_parameter(const double* x, const double* parameters,
                                          const EnergyLimitState* state, const History* history,
                                          Eigen::MatrixXd& result) const = 0;
  /// Fills the entries of its own in a History's state.
  virtual AssemblyStatus end_of_step(const double* x, const double* parameters,
                                     const History& history, double* end) const = 0;
  /// Adds d2E/dx dh `change`.
  virtual AssemblyStatus add_by_history(const double* x, const double* parameters,
                                        const History& history, const Eigen::MatrixXd& change,
                                        Eigen::MatrixXd& result) const = 0;
  /// The rows of its own of MeshModel::carry_history_change.
  virtual AssemblyStatus carry_change(const double* x, const double* parameters,
                                      const History& history, const Eigen::MatrixXd& x_change,
                                      const std::vector<Eigen::Index>& columns,
                                      Eigen::MatrixXd& change) const = 0;
  /// Its part of take_held_step (history/held_step.h).
  virtual AssemblyStatus take_held_step(const double* x, const double* parameters,
                                        const std::vector<Eigen::Index>& columns, History& history,
                                        Eigen::MatrixXd& change, Eigen::MatrixXd& force) const = 0;
  /// Adds to the entry of each of its terms.
  virtual AssemblyStatus add_term_energies(const double* x, const double* parameters,
                                           const History* history, double* energies) const = 0;
  /// [element * strains + i]; not_finite where one is not.
  virtual AssemblyStatus strains_of(const GroupTerm& term, const double* x,
                                    std::vector<double>& strain) const = 0;
  /// Fills the entries of its own limits.
  virtual AssemblyStatus limit_excess(const double* x, const double* parameters,
                                      double* excess) const = 0;
  /// Fills the columns and rows of the active entries that are its own.
  virtual AssemblyStatus fill_limits(const double* x, const double* parameters,
                                     ActiveLimits& active) const = 0;
  virtual const std::vector<double>& measure() const = 0;  ///< of its elements, without supports
  virtual std::vector<std::pair<int, int>> pairs() const = 0;
  virtual void find_slots(const NodeMatrix& matrix) = 0;
  /// What a model is made of.
  static const std::vector<std::shared_ptr<const Group>>& of(const MeshModel& model) {
    return model.groups_;
  }

  const ElementKind kind;
  const std::vector<int> element;  ///< numbers of its elements among those of this kind
  std::vector<GroupTerm> terms;
  std::vector<GroupLimit> limits;

 protected:
  Group(ElementKind its_kind, std::vector<int> numbers)
      : kind(its_kind), element(std::move(numbers)) {}
};

}  // namespace tenter::mechanics
