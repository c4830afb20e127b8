// SPDX-License-Identifier: GPL-3.0-or-later
// Which candidates of a screen are worth a refit?
//
// The best few: of each effect the three best variants with one part and the best with two, three,
// ..., each at its best grid point, so that the refits can weigh parts against gain. In the order
// of the information criterion that the refits are expected to reach; ratios only decide who is in.
#pragma once

#include <vector>

#include "server/diagnosis/screening/candidate.h"
#include "server/estimation/fit.h"

namespace tenter::diagnosis {

std::vector<Candidate> shortlist(const Screen& screen, const estimation::FitResult& fit,
                                 std::size_t effects);

}  // namespace tenter::diagnosis
