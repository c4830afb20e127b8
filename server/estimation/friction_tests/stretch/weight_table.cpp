// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/friction_tests/stretch/weight_table.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace tenter::estimation {

double WeightTable::load(std::size_t i) const {
  return (readings[i].weight_N + dead_weight_N) / width_m;
}

double WeightTable::strain(std::size_t i) const {
  const double stretch = readings[i].length_m / rest_length_m;
  return 0.5 * (stretch * stretch - 1.0);
}

Expected<WeightTable> check(WeightTable table) {
  const auto positive = [](double value) { return std::isfinite(value) && value > 0.0; };
  if (!positive(table.rest_length_m)) return bad_input("the rest length is not above zero");
  if (!positive(table.width_m)) return bad_input("the width is not above zero");
  if (!std::isfinite(table.dead_weight_N) || table.dead_weight_N < 0.0)
    return bad_input("the dead weight is negative");
  if (!std::isfinite(table.length_noise_m) || table.length_noise_m < 0.0)
    return bad_input("the noise of the lengths is negative");
  for (std::size_t i = 0; i < table.readings.size(); ++i) {
    const WeightReading& reading = table.readings[i];
    const std::string name = "reading " + std::to_string(i + 1) + ": ";
    if (!positive(reading.length_m)) return bad_input(name + "the length is not above zero");
    if (!std::isfinite(reading.weight_N) || reading.weight_N < 0.0)
      return bad_input(name + "the weight is negative");
  }
  constexpr std::size_t kFewest = 8;  // five parameters, and something left to judge them by
  if (table.readings.size() < kFewest)
    return bad_input("a hanging cloth needs at least " + std::to_string(kFewest) + " readings, " +
                     std::to_string(table.readings.size()) + " are given");
  const auto places = places_of(table);
  if (std::all_of(places.begin(), places.end(),
                  [](const auto& place) { return place.sign == 0.0; }))
    return bad_input("all weights are the same: nothing is loaded");
  return table;
}

std::vector<ReadingPlace> places_of(const WeightTable& table) {
  std::vector<ReadingPlace> places(table.readings.size());
  int branch = -1;
  for (std::size_t i = 0; i < places.size(); ++i) {
    ReadingPlace& place = places[i];
    if (i == 0 || table.readings[i].run != table.readings[i - 1].run) {
      place.branch = ++branch;
      continue;
    }
    const ReadingPlace& before = places[i - 1];
    const double change = table.readings[i].weight_N - table.readings[i - 1].weight_N;
    const double sign = change > 0.0 ? 1.0 : (change < 0.0 ? -1.0 : before.sign);
    place.sign = sign;
    const bool goes_on = before.anchor >= 0 && sign == before.sign;
    place.anchor = goes_on ? before.anchor : static_cast<int>(i) - 1;
    // the first branch of a run is that of its first reading
    if (!goes_on && before.anchor >= 0) ++branch;
    place.branch = branch;
    if (sign == 0.0) place.anchor = -1;
  }
  return places;
}

std::vector<AnchoredReading> anchored_readings(const WeightTable& table) {
  std::vector<AnchoredReading> readings;
  const std::vector<ReadingPlace> places = places_of(table);
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (places[i].anchor < 0) continue;
    AnchoredReading reading;
    reading.load = table.load(i);
    reading.strain = table.strain(i);
    reading.weight = table.readings[i].length_m / table.rest_length_m;
    reading.anchor = table.strain(static_cast<std::size_t>(places[i].anchor));
    reading.sign = places[i].sign;
    reading.block = places[i].branch;
    readings.push_back(reading);
  }
  return readings;
}

}  // namespace tenter::estimation
