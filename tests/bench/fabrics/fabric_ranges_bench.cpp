// SPDX-License-Identifier: GPL-3.0-or-later
// tenter-bench-fabric-ranges FOLDER: what stiffness ten garment fabrics have, from their published
// parameters (`stretching.csv`, `bending.csv`), as this project's terms: the ranges of
// common/model/usual_ranges.h.
#include <algorithm>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/model/export/arcsim.h"
#include "common/model/usual_ranges.h"
#include "tests/bench/number_table.h"

namespace {

using namespace tenter;

constexpr std::size_t kSamples = 6, kDirections = 3;

Expected<void> run(const std::string& folder) {
  const auto stretching = bench::read_numbers(
      folder + "/stretching.csv", {"c11_N_per_m", "c12_N_per_m", "c22_N_per_m", "c33_N_per_m"});
  if (!stretching) return tl::unexpected(stretching.error());
  const auto density = bench::read_numbers(folder + "/stretching.csv", {"area_density_kg_per_m2"});
  if (!density) return tl::unexpected(density.error());
  const auto bending = bench::read_numbers(folder + "/bending.csv",
                                           {"b0_N_m", "b1_N_m", "b2_N_m", "b3_N_m", "b4_N_m"});
  if (!bending) return tl::unexpected(bending.error());
  const std::size_t fabrics = stretching->size() / kSamples;
  if (stretching->size() % kSamples != 0 || bending->size() != fabrics * kDirections)
    return bad_input(folder + ": " + std::to_string(stretching->size()) +
                     " rows of stretching and " + std::to_string(bending->size()) +
                     " of bending are not six and three a fabric");
  std::map<std::string, std::vector<double>> values;
  std::map<std::string, model::UsualRange> usual;
  for (std::size_t f = 0; f < fabrics; ++f) {
    const auto rows = [](const auto& all, std::size_t first, std::size_t count) {
      return std::vector<std::vector<double>>(
          all.begin() + static_cast<std::ptrdiff_t>(first),
          all.begin() + static_cast<std::ptrdiff_t>(first + count));
    };
    const nlohmann::json file = {{"density", (*density)[f * kSamples][0]},
                                 {"stretching", rows(*stretching, f * kSamples, kSamples)},
                                 {"bending", rows(*bending, f * kDirections, kDirections)}};
    const auto fabric = model::read_arcsim(file.dump(), folder, "fabric");
    if (!fabric) return tl::unexpected(fabric.error());
    for (const model::Term& term : fabric->model.terms) {
      if (const auto range = model::usual_range(term)) usual[term.id] = *range;
      for (const model::Parameter& p : term.law.parameters) values[term.id].push_back(p.value);
    }
  }
  std::printf("%zu fabrics, as terms of Green strain (N/m) and bending (N m)\n", fabrics);
  std::printf("%-14s %10s %10s %10s   %s\n", "term", "smallest", "median", "largest",
              "usual range");
  for (auto& [term, all] : values) {
    std::sort(all.begin(), all.end());
    std::printf("%-14s %10.3g %10.3g %10.3g", term.c_str(), all.front(), all[all.size() / 2],
                all.back());
    if (usual.contains(term)) std::printf("   %.3g to %.3g", usual[term].lo, usual[term].hi);
    std::printf("\n");
  }
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: tenter-bench-fabric-ranges FOLDER\n");
    return 2;
  }
  if (const auto done = run(argv[1]); !done) {
    std::fprintf(stderr, "%s\n", done.error().message.c_str());
    return 2;
  }
  return 0;
}
