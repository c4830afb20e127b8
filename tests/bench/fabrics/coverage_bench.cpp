// SPDX-License-Identifier: GPL-3.0-or-later
// tenter-bench-coverage [seeds] [threads]: of every parameter of the four twin fabrics, in how many
// seeds the 95 % interval of a fit to the five sequences
// (twelve frames, 7 x 7 nodes) holds the truth. Ends with 1 where one is
// outside of the band that right intervals keep (179 to 198 of 200).
#include <cstdio>
#include <cstdlib>

#include "tests/twin/fabrics/sequences/coverage.h"

using namespace tenter;

int main(int count, char** arguments) {
  const int seeds = count > 1 ? std::atoi(arguments[1]) : 200;
  const int threads = count > 2 ? std::atoi(arguments[2]) : 2;
  const auto [fewest, most] = twin::binomial_band(seeds, 0.95);
  std::printf("%d seeds, right intervals hold the truth in %d to %d\n", seeds, fewest, most);
  bool is_right = true;
  for (const char* id : {"4", "12", "14", "18"}) {
    const twin::Fabric cloth = twin::reached_everywhere(twin::fabric(id));
    const twin::Coverage result = twin::coverage_of(cloth, {.seeds = seeds, .threads = threads});
    std::printf("\n#%s %s: %d usable fits, %d begun again, chi2 per degree %.4f\n", id,
                cloth.name.c_str(), result.usable, result.restarted, result.chi2_per_degree);
    std::printf("%-18s %12s %12s %8s %8s %6s\n", "parameter", "truth", "std error", "mean off",
                "spread", "held");
    is_right = is_right && result.usable == seeds;
    for (const twin::ParameterCoverage& row : result.parameters) {
      const bool is_inside = row.held >= fewest && row.held <= most;
      is_right = is_right && is_inside;
      std::printf("%-18s %12.4g %11.3f%% %8.3f %8.3f %6d%s\n", row.name.c_str(), row.truth,
                  100.0 * row.relative_error, row.mean_off, row.spread, row.held,
                  is_inside ? "" : "  outside");
    }
    std::fflush(stdout);
  }
  return is_right ? 0 : 1;
}
