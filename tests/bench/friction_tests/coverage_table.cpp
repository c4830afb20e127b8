// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/bench/friction_tests/coverage_table.h"

#include <cmath>
#include <cstdio>
#include <ctime>
#include <optional>

#include "server/estimation/parallel.h"

namespace tenter::bench {
namespace {

std::string shown(const estimation::FrictionNumber& number) {
  char text[96];
  if (number.is_told)
    std::snprintf(text, sizeof text, "%.4g [%.4g, %.4g]", number.value, number.lo.value_or(0.0),
                  number.hi.value_or(0.0));
  else
    std::snprintf(text, sizeof text, "%s", number.words.c_str());
  return text;
}

}  // namespace

CoverageTable::CoverageTable(const twin::FrictionSample& sample) : name_(sample.name) {
  for (const double truth : {sample.k1, sample.k2, sample.a, sample.b, sample.tau})
    columns_.push_back({truth, 0, 0, 0.0, 0.0, 0.0, 0.0, ""});
}

void CoverageTable::add(const estimation::FrictionEstimate& found) {
  ++seeds_;
  chi2_per_row_ += found.fit.chi2 / static_cast<double>(found.fit.residuals.size());
  const auto p = found.start.stages.back();
  const std::array<double, 5> papers = {p.k1, p.k2, p.a, p.b, p.tau};
  for (std::size_t k = 0; k < columns_.size(); ++k) {
    Column& column = columns_[k];
    const estimation::FrictionNumber& number = found.numbers[k];
    if (seeds_ == 1) {
      names_.push_back(number.name + " (" + number.unit + ")");
      column.first = shown(number);
    }
    const bool above = !number.lo || *number.lo <= column.truth;
    const bool below = !number.hi || column.truth <= *number.hi;
    column.held += above && below ? 1 : 0;
    column.told += number.is_told ? 1 : 0;
    column.sum += number.value;
    column.squares += number.value * number.value;
    column.papers += papers[k];
    if (number.lo && number.hi) column.width += 0.5 * (*number.hi - *number.lo) / 1.96;
  }
}

void CoverageTable::print() const {
  if (seeds_ == 0) return void(std::printf("\n%s: %d failed\n", name_.c_str(), failed_));
  std::printf("\n%s: %d seeds, %d failed, chi2 per row %.3f, %.2f s a seed\n", name_.c_str(),
              seeds_, failed_, chi2_per_row_ / seeds_, seconds_ / (seeds_ + failed_));
  std::printf("%-11s %10s %10s %9s %9s %9s %6s %5s  %s\n", "", "truth", "papers'", "mean off",
              "spread", "std error", "told", "held", "first seed");
  for (std::size_t k = 0; k < columns_.size(); ++k) {
    const Column& c = columns_[k];
    const double mean = c.sum / seeds_;
    const double spread = std::sqrt(std::max(0.0, c.squares / seeds_ - mean * mean));
    std::printf("%-11s %10.4g %10.4g %8.2f%% %8.2f%% %8.2f%% %6d %5d  %s\n", names_[k].c_str(),
                c.truth, c.papers / seeds_, 100.0 * (mean / c.truth - 1.0),
                100.0 * spread / c.truth, 100.0 * c.width / seeds_ / c.truth, c.told, c.held,
                c.first.c_str());
  }
  std::fflush(stdout);
}

CoverageTable covered(const twin::FrictionSample& sample, const CoverageOptions& options,
                      const std::function<Expected<estimation::FrictionEstimate>(int seed)>& find) {
  const auto now = [] {
    timespec at{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &at);
    return static_cast<double>(at.tv_sec) + 1e-9 * static_cast<double>(at.tv_nsec);
  };
  struct Seed {
    std::optional<Expected<estimation::FrictionEstimate>> found;
    double seconds = 0.0;
  };
  std::vector<Seed> seeds(static_cast<std::size_t>(options.seeds));
  estimation::in_parallel(options.threads, options.seeds, [&](int, int i) {
    Seed& seed = seeds[static_cast<std::size_t>(i)];
    const double begin = now();
    seed.found = find(options.first + i);
    seed.seconds = now() - begin;
    if (!*seed.found) return;
    // of 200 seeds, what a table reads is kept and no more
    estimation::FrictionEstimate& kept = **seed.found;
    kept.fit.jacobian.resize(0, 0);
    kept.profiles.clear();
  });
  CoverageTable table(sample);
  bool has_failed = false;
  for (const Seed& seed : seeds) {
    table.add_seconds(seed.seconds);
    if (*seed.found) {
      table.add(**seed.found);
      continue;
    }
    if (!has_failed) std::printf("\n%s\n", seed.found->error().message.c_str());
    has_failed = true;
    table.add_failure();
  }
  return table;
}

}  // namespace tenter::bench
