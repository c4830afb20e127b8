// SPDX-License-Identifier: GPL-3.0-or-later
// What a measured sequence is for in a staged fit (thesis 3.2.2, 3.4.1), and which component of a
// cloth model a term is.
//
// The thesis compares stretch by clip forces alone, shear by those along the clips, and bending,
// where there are none, by positions: Channels::thesis. Values and pure functions.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/model/model.h"
#include "server/estimation/sequences/sequence.h"
#include "server/estimation/staged/start/equation_gap.h"

namespace tenter::estimation {

enum class Role { stretch_u, stretch_v, shear, bend_u, bend_v, evaluation };

struct RoleSequence {
  Role role = Role::evaluation;
  Sequence sequence;
};

enum class Channels {
  thesis,  ///< forces for stretch, those along the clips for shear, positions for bending; all for
           ///< evaluation
  all
};

/// Which rows of a sequence with this role count.
GapRows rows_of(Role role, Channels channels);

/// The sequence with only those channels; of a role whose channels it lacks, as it is. A force is
/// along its clip where it is within 45 degrees of the line of the clip's nodes.
Sequence observed(const RoleSequence& measured, Channels channels);

/// The six deformation components of thesis 3.3.1.
enum class Component { stretch_u, stretch_v, shear, bend_u, bend_v, bend_diagonal };

/// By the term's strain measure; none where it is no single one of the six.
std::optional<Component> component_of(const model::Term& term);

/// Ids of the model's terms of this component.
std::vector<std::string> terms_of(const model::Model& model, Component component);

}  // namespace tenter::estimation
