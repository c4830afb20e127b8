// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/friction_tests/loops/loop_table.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace tenter::estimation {
namespace {

double stretch_of(const LoopReading& reading) {
  return std::sqrt(1.0 + 2.0 * reading.strain);
}

struct LoopBranch {
  int first = 0;
  int last = 0;  ///< one beyond
  double sign = 0.0;
  bool begins = false;  ///< at a specimen without a history
};

std::vector<LoopBranch> branches_of(const LoopTable& table) {
  std::vector<LoopBranch> branches;
  const int count = static_cast<int>(table.readings.size());
  for (int i = 0; i < count; ++i) {
    const bool begins =
        i == 0 || std::binary_search(table.beginnings.begin(), table.beginnings.end(), i);
    const auto k = static_cast<std::size_t>(i);
    if (begins || table.readings[k].branch != table.readings[k - 1].branch)
      branches.push_back({i, i, 0.0, begins});
    branches.back().last = i + 1;
  }
  for (LoopBranch& branch : branches) {
    const double way = table.readings[static_cast<std::size_t>(branch.last - 1)].strain -
                       table.readings[static_cast<std::size_t>(branch.first)].strain;
    branch.sign = way > 0.0 ? 1.0 : (way < 0.0 ? -1.0 : 0.0);
  }
  return branches;
}

}  // namespace

Expected<LoopTable> check(LoopTable table) {
  if (!std::isfinite(table.load_noise) || table.load_noise < 0.0)
    return bad_input("the noise of the loads is negative");
  for (std::size_t i = 0; i < table.readings.size(); ++i) {
    const LoopReading& reading = table.readings[i];
    const std::string name = "reading " + std::to_string(i + 1) + ": ";
    if (!std::isfinite(reading.strain) || !(reading.strain > -0.5))
      return bad_input(name + "the strain is that of no stretch");
    if (!std::isfinite(reading.load)) return bad_input(name + "the load is not a number");
  }
  constexpr std::size_t kFewest = 12;
  if (table.readings.size() < kFewest)
    return bad_input("loops need at least " + std::to_string(kFewest) + " readings, " +
                     std::to_string(table.readings.size()) + " are given");
  bool rises = false;
  bool falls = false;
  for (const LoopBranch& branch : branches_of(table)) {
    rises = rises || branch.sign > 0.0;
    falls = falls || branch.sign < 0.0;
  }
  if (!rises || !falls)
    return bad_input("the strain never turns: friction shows where both ways are measured");
  return table;
}

std::vector<AnchoredReading> anchored_readings(const LoopTable& table) {
  std::vector<AnchoredReading> readings;
  int number = 0;
  for (const LoopBranch& branch : branches_of(table)) {
    ++number;
    if (branch.begins || branch.sign == 0.0) continue;
    // where the branch before ended
    const double anchor = table.readings[static_cast<std::size_t>(branch.first - 1)].strain;
    for (int i = branch.first; i < branch.last; ++i) {
      const LoopReading& at = table.readings[static_cast<std::size_t>(i)];
      if (branch.sign * (at.strain - anchor) < 0.0) continue;
      AnchoredReading reading;
      reading.load = at.load;
      reading.strain = at.strain;
      reading.weight = stretch_of(at);
      reading.anchor = anchor;
      reading.sign = branch.sign;
      reading.block = number;
      readings.push_back(reading);
    }
  }
  return readings;
}

double lost_share(const LoopTable& table) {
  double lost = 0.0;
  double loaded = 0.0;
  for (std::size_t i = 1; i < table.readings.size(); ++i) {
    if (std::binary_search(table.beginnings.begin(), table.beginnings.end(), static_cast<int>(i)))
      continue;
    const LoopReading& from = table.readings[i - 1];
    const LoopReading& to = table.readings[i];
    const double work = 0.5 * (from.load + to.load) * (stretch_of(to) - stretch_of(from));
    lost += work;
    loaded += std::max(work, 0.0);
  }
  return loaded > 0.0 ? lost / loaded : 0.0;
}

}  // namespace tenter::estimation
