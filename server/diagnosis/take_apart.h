// SPDX-License-Identifier: GPL-3.0-or-later
// Did a flexible effect take two causes at once?
//
// A curve of force along every direction is a stiffness of its own along one and a limit along
// another, too, but for a little at the corner, which is then no more than the form of a curve may
// miss. So what was refused for that alone is added, and what does better now is tried in the place
// of the flexible effect: two causes that leave nothing are better than one that leaves a form.
#pragma once

#include <vector>

#include "server/diagnosis/backward.h"

namespace tenter::diagnosis {

/// Changes `accepted` and `current` where two effects do decisively better in the place of one,
/// leave nothing of what it misses, and pass every gate beside each other. `options`: of the
/// screen.
void take_apart(Diagnosis& d, Reference& current, std::vector<Accepted>& accepted,
                const Excitation& excitation, const ScreenOptions& options, const Control& control);

}  // namespace tenter::diagnosis
