// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/sparse/kernels/panel_kernels.h"

namespace tenter::mechanics {

std::vector<const PanelKernels*> runnable_panel_kernels() {
  std::vector<const PanelKernels*> runnable;
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq"))
    runnable.push_back(&kAvx512Kernels);
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"))
    runnable.push_back(&kAvx2Kernels);
  runnable.push_back(&kPortableKernels);
  return runnable;
}

}  // namespace tenter::mechanics
