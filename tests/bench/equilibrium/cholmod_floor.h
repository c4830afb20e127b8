// SPDX-License-Identifier: GPL-3.0-or-later
// The measuring stick: CHOLMOD's supernodal factorisation called as plainly as its manual says, one
// thread, with an ordering and a relaxation of the supernodes to choose.
#pragma once

#include <memory>

#include "server/mechanics/sparse/factor.h"

namespace tenter::mechanics::bench {

enum class Ordering { amd, metis };
enum class Relaxation { standard, wide };  ///< CHOLMOD's own, or wider leaves

std::unique_ptr<SparseFactor> make_cholmod_floor(Ordering ordering, Relaxation relaxation);

}  // namespace tenter::mechanics::bench
