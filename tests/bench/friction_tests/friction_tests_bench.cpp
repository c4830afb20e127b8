// SPDX-License-Identifier: GPL-3.0-or-later
// tenter-bench-friction-tests [--first N] [--seeds N] [--threads N] [--profiles] [--only WORD]
// [--figures DIR]: tables 5.1 and 5.2 of the thesis from twins, by the papers' protocol and a
// length noise of 0.1 mm, and in how many seeds 95 % intervals hold the truth (right ones: in 179
// to 198 of 200).
//
//   --profiles   intervals from the profile of the likelihood, else from the covariance
//   --only       stretch, bending or creeping, or one sample: cotton, felt, ...
//   --figures    figures 5.8 and 5.9 of the first seed as SVG into the folder, and no table
#include <cstdio>
#include <cstdlib>

#include <string>

#include "tests/bench/friction_tests/bending_case.h"
#include "tests/bench/friction_tests/bending_figures.h"
#include "tests/bench/friction_tests/hanging_case.h"

using namespace tenter;

namespace {

struct Options {
  bench::CoverageOptions coverage;
  std::string only;
  std::string figures;
};

bool read_options(int count, char** arguments, Options& options) {
  for (int i = 1; i < count; ++i) {
    const std::string name = arguments[i];
    if (name == "--profiles") {
      options.coverage.profiles = true;
      continue;
    }
    if (i + 1 == count) return false;
    const char* value = arguments[++i];
    if (name == "--seeds")
      options.coverage.seeds = std::atoi(value);
    else if (name == "--first")
      options.coverage.first = std::atoi(value);
    else if (name == "--threads")
      options.coverage.threads = std::atoi(value);
    else if (name == "--only")
      options.only = value;
    else if (name == "--figures")
      options.figures = value;
    else
      return false;
  }
  return options.coverage.seeds > 0 && options.coverage.threads > 0;
}

int write_figures(const std::string& folder) {
  for (const twin::FrictionSample& sample : twin::bending_samples()) {
    const bench::BendingRig rig(sample, twin::Unrolling::one_way);
    const estimation::BendingTests tests = rig.photographed(1);
    const auto found = fit_bending(tests, "bend_v", {.profiles = false});
    if (found && bench::write_bending_figures(folder, sample.name, tests, *found)) continue;
    std::fprintf(stderr, "%s: no figures\n", sample.name.c_str());
    return 1;
  }
  return 0;
}

}  // namespace

int main(int count, char** arguments) {
  Options options;
  if (!read_options(count, arguments, options)) {
    std::fprintf(
        stderr,
        "usage: tenter-bench-friction-tests [--first N] [--seeds N] [--threads N] [--profiles] "
        "[--only WORD] [--figures DIR]\n");
    return 2;
  }
  if (!options.figures.empty()) return write_figures(options.figures);
  const auto wanted = [&](const char* part, const twin::FrictionSample& sample) {
    return options.only.empty() || options.only == part ||
           (options.only == sample.name && std::string(part) != "creeping");
  };
  std::printf(
      "Hanging weights: 0 to 6 N in steps of 1 N, three repeats (table 5.1).\n"
      "Spirals of twelve radii and cantilevers, three repeats (table 5.2).\n");
  for (const twin::FrictionSample& sample : twin::stretch_samples())
    if (wanted("stretch", sample)) bench::hanging_coverage(sample, options.coverage).print();
  for (const twin::FrictionSample& sample : twin::bending_samples())
    if (wanted("bending", sample))
      bench::bending_coverage({sample, twin::Unrolling::one_way}, options.coverage).print();
  for (const twin::FrictionSample& sample : twin::bending_samples()) {
    if (!wanted("creeping", sample)) continue;
    std::printf("\nThe same with strips that were let go: their ways go to and fro\n");
    bench::bending_coverage({sample, twin::Unrolling::creeping}, options.coverage).print();
  }
  return 0;
}
