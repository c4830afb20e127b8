// SPDX-License-Identifier: GPL-3.0-or-later
// Taking effects out of an extended model and putting others in their place.
#pragma once

#include <optional>
#include <string>

#include "server/diagnosis/trials/trial.h"

namespace tenter::diagnosis {

/// The model without an effect's terms, laws and corrections; what the effect replaced comes back
/// from the baseline.
model::Model without(const model::Model& model, const std::string& effect,
                     const model::Model& baseline);

/// The model with the parts that a rival's trial added.
model::Model with_rival(model::Model model, const Trial& rival);

/// The model with the effect's terms in the form that they have without its hallmarks, and under
/// that effect's name; nothing where the effect has no such form, holds no terms, or one of the
/// hallmarks is surely there: is off zero by more than its errors.
std::optional<model::Model> in_plain_form(const Reference& at, const Effect& effect);

/// Whether the model holds anything of an effect.
bool holds(const model::Model& model, const std::string& effect);

}  // namespace tenter::diagnosis
