// SPDX-License-Identifier: GPL-3.0-or-later
// tenter-bench-friction-tests [seeds] [profiles 0|1]: tables 5.1 and 5.2 of the thesis from twins,
// by the papers' protocol and a length noise of 0.1 mm, and in how many seeds 95 % intervals hold
// the truth (right ones: in 179 to 198 of 200).
#include <cstdio>
#include <cstdlib>

#include "tests/bench/friction_tests/hanging_case.h"

using namespace tenter;

int main(int count, char** arguments) {
  const int seeds = count > 1 ? std::atoi(arguments[1]) : 200;
  const bool profiles = count <= 2 || std::atoi(arguments[2]) != 0;
  std::printf("Table 5.1, hanging weights: 0 to 6 N in steps of 1 N, three repeats\n");
  for (const twin::FrictionSample& sample : twin::stretch_samples())
    bench::hanging_coverage(sample, seeds, profiles).print();
  return 0;
}
