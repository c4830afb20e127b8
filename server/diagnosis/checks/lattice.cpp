// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/checks/lattice.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

namespace tenter::diagnosis {
namespace {

constexpr std::size_t kFewestReadings = 20;
constexpr std::size_t kFewestLevels = 4;
constexpr double kOnLattice = 1e-3;  // of the step
constexpr int kMostMissing = 6;      // levels between the two closest readings

/// Between neighbouring levels, in order of the levels.
std::vector<double> gaps_of(std::vector<double> values) {
  std::vector<double> gaps;
  std::erase_if(values, [](double v) { return !std::isfinite(v); });
  if (values.empty()) return gaps;
  std::sort(values.begin(), values.end());
  const double largest = std::max(std::abs(values.front()), std::abs(values.back()));
  for (std::size_t i = 1; i < values.size(); ++i)
    if (values[i] - values[i - 1] > 1e-9 * largest) gaps.push_back(values[i] - values[i - 1]);
  return gaps;
}

bool all_multiples(const std::vector<double>& gaps, double step) {
  return std::all_of(gaps.begin(), gaps.end(), [&](double gap) {
    const double turns = gap / step;
    // rounding of large readings must not count as being off
    return std::abs(turns - std::round(turns)) < kOnLattice * std::max(1.0, 1e-3 * turns);
  });
}

/// r[i] - (r[i-1] + r[i+1])/2 has variance 1.5 sigma^2. Its mean size without the largest
/// twentieth: the median of steps would itself be a step, or zero.
double neighbour_scatter(const estimation::Curves& curves,
                         const estimation::ObservedChannel& channel) {
  std::vector<double> differences;
  for (const estimation::Block& block : curves.blocks)
    for (int f = block.first + 1; f + 1 < block.last; ++f) {
      const auto i = static_cast<std::size_t>(f);
      const double d =
          channel.measured[i] - 0.5 * (channel.measured[i - 1] + channel.measured[i + 1]);
      if (std::isfinite(d)) differences.push_back(std::abs(d));
    }
  if (differences.empty()) return 0.0;
  constexpr double kOfNormal = 1.40;  // standard deviation over that mean
  std::sort(differences.begin(), differences.end());
  const std::size_t kept = std::max<std::size_t>(1, differences.size() * 19 / 20);
  double sum = 0.0;
  for (std::size_t i = 0; i < kept; ++i) sum += differences[i];
  return kOfNormal * sum / static_cast<double>(kept) / std::sqrt(1.5);
}

}  // namespace

double lattice_step(std::vector<double> values) {
  std::erase_if(values, [](double v) { return !std::isfinite(v); });
  if (values.size() < kFewestReadings) return 0.0;
  const std::vector<double> gaps = gaps_of(std::move(values));
  if (gaps.size() + 1 < kFewestLevels) return 0.0;
  const double smallest = *std::min_element(gaps.begin(), gaps.end());
  for (int parts = 1; parts <= kMostMissing; ++parts)
    if (all_multiples(gaps, smallest / parts)) return smallest / parts;
  return 0.0;
}

/// Noise of s and steps of q scatter by sqrt(s^2 + q^2/12): beyond 1.75 the step is over twice s.
bool Lattice::is_above_noise() const {
  constexpr double kAbove = 1.75;
  return step > kAbove * scatter;
}

std::vector<Lattice> find_lattices(const std::vector<estimation::Curves>& curves) {
  std::vector<Lattice> found;
  // the step that a channel shows in one capture counts in others, where it moves over few levels
  std::map<std::string, double> known;
  for (const estimation::Curves& c : curves)
    for (const estimation::ObservedChannel& channel : c.channels)
      if (channel.is_stress)
        known[channel.name] = std::max(known[channel.name], lattice_step(channel.measured));
  for (std::size_t i = 0; i < curves.size(); ++i)
    for (std::size_t c = 0; c < curves[i].channels.size(); ++c) {
      const estimation::ObservedChannel& channel = curves[i].channels[c];
      if (!channel.is_stress) continue;
      double step = known[channel.name];
      if (step <= 0.0 || !all_multiples(gaps_of(channel.measured), step))
        step = lattice_step(channel.measured);
      if (step > 0.0)
        found.push_back({static_cast<int>(i), static_cast<int>(c), step,
                         neighbour_scatter(curves[i], channel)});
    }
  return found;
}

void note_resolution(std::vector<estimation::Curves>& curves) {
  for (const Lattice& lattice : find_lattices(curves)) {
    auto& channel = curves[static_cast<std::size_t>(lattice.curve)]
                        .channels[static_cast<std::size_t>(lattice.channel)];
    channel.resolution = std::max(channel.resolution, lattice.step);
  }
}

void drop_within_steps(const std::vector<estimation::Curves>& curves,
                       std::vector<estimation::Outlier>& outliers) {
  constexpr double kSteps = 1.5;
  for (const Lattice& lattice : find_lattices(curves)) {
    if (!lattice.is_above_noise()) continue;
    std::erase_if(outliers, [&](const estimation::Outlier& o) {
      return o.curve == lattice.curve && o.channel == lattice.channel &&
             std::abs(o.deviation) < kSteps * lattice.step;
    });
  }
}

double chi2_of_steps(const Diagnosis& d, double counted) {
  std::map<std::pair<int, int>, double> error;  // of one row, by curve and channel
  for (const Lattice& lattice : find_lattices(d.curves)) {
    if (!lattice.is_above_noise()) continue;
    const double sigma = d.noise
                             .channels[static_cast<std::size_t>(lattice.curve)]
                                      [static_cast<std::size_t>(lattice.channel)]
                             .sigma;
    const double share = lattice.step * lattice.step / (12.0 * sigma * sigma);
    error[{lattice.curve, lattice.channel}] = std::max(0.0, share - counted);
  }
  double chi2 = 0.0;
  if (error.empty()) return chi2;
  for (const estimation::Row& row : d.data->rows())
    if (const auto found = error.find({row.curve, row.channel}); found != error.end())
      chi2 += found->second;
  return chi2;
}

std::optional<Verdict> quantisation_verdict(const Diagnosis& d) {
  std::map<std::string, Lattice> coarsest;  // by channel name
  double error = 0.0;
  double power = 0.0;
  for (const Lattice& lattice : find_lattices(d.curves)) {
    if (!lattice.is_above_noise()) continue;
    const auto& channel = d.curves[static_cast<std::size_t>(lattice.curve)]
                              .channels[static_cast<std::size_t>(lattice.channel)];
    Lattice& worst = coarsest[channel.name];
    if (lattice.step > worst.step) worst = lattice;
    for (const double v : channel.measured) {
      if (!std::isfinite(v)) continue;
      power += v * v;
      error += lattice.step * lattice.step / 12.0;
    }
  }
  if (coarsest.empty()) return std::nullopt;
  Verdict verdict;
  verdict.kind = VerdictKind::sensor;
  verdict.effect = "load_cell_quantisation";
  verdict.size = power > 0.0 ? std::sqrt(error / power) : 0.0;
  verdict.size_lo = verdict.size_hi = verdict.size;
  verdict.words = "Readings come in steps that are above their noise:";
  for (const auto& [name, lattice] : coarsest) {
    char text[160];
    std::snprintf(text, sizeof text, " %s by %.3g N/m with a scatter of %.2g N/m,", name.c_str(),
                  lattice.step, lattice.scatter);
    verdict.words += text;
    verdict.evidence.emplace_back("step_" + name, lattice.step);
    verdict.evidence.emplace_back("scatter_" + name, lattice.scatter);
  }
  verdict.words.back() = '.';
  verdict.words += " The steps are counted as noise; what is finer is lost.";
  return verdict;
}

}  // namespace tenter::diagnosis
