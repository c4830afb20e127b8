// SPDX-License-Identifier: GPL-3.0-or-later
// Which candidates of a screen are worth a refit?
#pragma once

#include <vector>

#include "server/diagnosis/screen.h"

namespace tenter::diagnosis {

/// The best few, in the order of the information criterion that their refits are expected to reach:
/// of each effect the three best variants with one part and the best with two, three, ..., each at
/// its best grid point, so that the refits can weigh parts against gain. At most `effects` effects,
/// all of them above the threshold. `fit`: of the model that was screened.
std::vector<Candidate> shortlist(const Screen& screen, const estimation::FitResult& fit,
                                 std::size_t effects);

}  // namespace tenter::diagnosis
