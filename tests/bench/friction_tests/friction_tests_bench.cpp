// SPDX-License-Identifier: GPL-3.0-or-later
// tenter-bench-friction-tests [seeds] [profiles 0|1] [all|stretch|bending|creeping|figures]
// [folder]:
// tables 5.1 and 5.2 of the thesis from twins, by the papers' protocol and a length noise of 0.1
// mm, and in how many seeds 95 % intervals hold the truth (right ones: in 179 to 198 of 200).
// `figures` writes figures 5.8 and 5.9 of the first seed as SVG into the folder.
#include <cstdio>
#include <cstdlib>

#include <string>

#include "tests/bench/friction_tests/bending_case.h"
#include "tests/bench/friction_tests/bending_figures.h"
#include "tests/bench/friction_tests/hanging_case.h"

using namespace tenter;

int main(int count, char** arguments) {
  const int seeds = count > 1 ? std::atoi(arguments[1]) : 200;
  const bool profiles = count <= 2 || std::atoi(arguments[2]) != 0;
  const std::string which = count > 3 ? arguments[3] : "all";
  const auto wanted = [&](const char* name) { return which == "all" || which == name; };
  if (wanted("stretch")) {
    std::printf("Table 5.1, hanging weights: 0 to 6 N in steps of 1 N, three repeats\n");
    for (const twin::FrictionSample& sample : twin::stretch_samples())
      bench::hanging_coverage(sample, seeds, profiles).print();
  }
  if (wanted("bending")) {
    std::printf("\nTable 5.2, spirals of twelve radii and cantilevers, three repeats\n");
    for (const twin::FrictionSample& sample : twin::bending_samples())
      bench::bending_coverage({sample, twin::Unrolling::one_way}, seeds, profiles).print();
  }
  if (wanted("creeping")) {
    std::printf("\nThe same with strips that were let go: their ways go to and fro\n");
    for (const twin::FrictionSample& sample : twin::bending_samples())
      bench::bending_coverage({sample, twin::Unrolling::creeping}, seeds, profiles).print();
  }
  if (which == "figures" && count > 4)
    for (const twin::FrictionSample& sample : twin::bending_samples()) {
      const bench::BendingRig rig(sample, twin::Unrolling::one_way);
      const estimation::BendingTests tests = rig.photographed(1);
      const auto found = fit_bending(tests, "bend_v", {.profiles = false});
      if (!found || !bench::write_bending_figures(arguments[4], sample.name, tests, *found)) {
        std::fprintf(stderr, "%s: no figures\n", sample.name.c_str());
        return 1;
      }
    }
  return 0;
}
