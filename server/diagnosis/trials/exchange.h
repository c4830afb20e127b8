// SPDX-License-Identifier: GPL-3.0-or-later
// Did an effect come in only because another was still missing?
//
// Effects are added one at a time: while a second cause still hides, a flexible effect may take a
// part of it and win over the simpler one that is true. So, once all are in, each is taken out
// again, and those that it is mistaken for and the best few of the catalogue are tried in its
// place.
#pragma once

#include <optional>

#include "server/diagnosis/diagnose.h"

namespace tenter::diagnosis {

/// What does better in place of `effect`: less information lost, clearly by one that it is mistaken
/// for and decisively by any other, every gate passed against the model without either. Nothing
/// where none does.
std::optional<Trial> better_in_place_of(const Effect& effect, const Diagnosis& d,
                                        const Reference& reduced, const Reference& current,
                                        const Excitation& excitation, const ScreenOptions& options);

}  // namespace tenter::diagnosis
