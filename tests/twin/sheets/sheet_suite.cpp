// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/twin/sheets/sheet_suite.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "tests/twin/fabrics/sheet/sheet_twin.h"

namespace tenter::twin {
namespace {

constexpr double kTaut = 0.12;  // share of the way that keeps a sheet from hanging through

/// What clips do to the sheet, as shares of its limits.
struct Place {
  double u = 0.0, v = 0.0, shear = 0.0;
};

/// On the way to a turn: where, how long, seen in how many frames.
struct Leg {
  Place to;
  double seconds = 1.0;
  int frames = 3;
};

/// What is done, one leg after another.
class Walk {
 public:
  Walk(const Fabric& fabric, SheetPlan plan, int cells, const Place& begin, Random& choices)
      : plan_(std::move(plan)), limits_(fabric.limits), choices_(choices) {
    plan_.path = plan_.is_frame ? in_picture_frame(fabric, cells)
                                : between_bars(fabric, plan_.along_u, cells);
    plan_.path.name = plan_.name;
    free_m_ = fabric.side_m * (1.0 - 2.0 / cells);
    place(begin, 0.0, 0, true);
  }

  void go(const Leg& leg, int block) {
    constexpr double kUneven = 0.3;
    const Place from = at_;
    double share = 0.0;
    const auto to = [&](double next, bool is_seen) {
      const auto between = [&](double a, double b) { return a + next * (b - a); };
      place(
          {between(from.u, leg.to.u), between(from.v, leg.to.v), between(from.shear, leg.to.shear)},
          (next - share) * leg.seconds, block, is_seen);
      share = next;
    };
    for (int k = 0; k < leg.frames; ++k)
      to((k + 0.5 + choices_.uniform(-kUneven, kUneven)) / leg.frames, true);
    to(1.0, false);
  }

  SheetPlan done() { return std::move(plan_); }

 private:
  void place(const Place& at, double seconds, int block, bool is_seen) {
    at_ = at;
    if (is_seen) plan_.seen.push_back(static_cast<int>(plan_.path.frames.size()));
    ProtocolFrame& frame = plan_.path.frames.emplace_back();
    frame.poses = plan_.is_frame ? frame_poses(plan_.path, at.u * limits_.frame_u,
                                               at.v * limits_.frame_v, at.shear * limits_.shear)
                                 : bar_poses(plan_.along_u,
                                             free_m_ * (plan_.along_u ? at.u * limits_.stretch_u
                                                                      : at.v * limits_.stretch_v));
    frame.block = block;
    frame.duration_s = seconds;
  }

  SheetPlan plan_;
  Limits limits_;
  Random& choices_;
  double free_m_ = 0.0;
  Place at_;
};

/// A loop, then a larger one: where rates are to differ ten times slower, with a hold at its top.
SheetPlan pull(const Fabric& fabric, bool along_u, bool two_rates, int cells, Random& choices) {
  SheetPlan plan;
  plan.name = along_u ? "pull_u" : "pull_v";
  plan.along_u = along_u;
  plan.cells = along_u ? std::vector<std::string>{"left", "right"}
                       : std::vector<std::string>{"bottom", "top"};
  const auto at = [&](double share) { return along_u ? Place{share, 0.0} : Place{0.0, share}; };
  Walk walk(fabric, std::move(plan), cells, at(kTaut), choices);
  const double slower = two_rates ? 10.0 : 1.0;
  const double small = choices.uniform(0.5, 0.65), low = choices.uniform(0.15, 0.25);
  walk.go({at(small), 4.0 * small, 3}, 0);
  walk.go({at(low), 4.0 * (small - low), 2}, 1);
  walk.go({at(1.0), 4.0 * slower * (1.0 - low), 4}, 2);
  if (two_rates) walk.go({at(1.0), 25.0, 3}, 3);
  walk.go({at(low), 4.0 * slower * (1.0 - low), 4}, two_rates ? 4 : 3);
  return walk.done();
}

/// Stretched both ways and sheared to one side, further, to the other side and back; what is held
/// out goes another way.
SheetPlan frame(const Fabric& fabric, bool held_out, int cells, Random& choices) {
  SheetPlan plan;
  plan.name = held_out ? "frame_again" : "frame";
  plan.is_frame = true;
  plan.held_out = held_out;
  for (const char* end : {"left", "right", "bottom", "top"})
    plan.cells.insert(plan.cells.end(), {end, std::string(end) + "_side"});
  const double first = choices.uniform(0.5, 0.6), less = choices.uniform(0.7, 0.8);
  Walk walk(fabric, std::move(plan), cells, {first, first, 0.0}, choices);
  if (held_out) {
    walk.go({{1.0, less, -0.6}, 3.0, 3}, 0);
    walk.go({{less, 1.0, 0.4}, 9.0, 2}, 1);
    walk.go({{first, first, 0.0}, 3.0, 2}, 2);
    return walk.done();
  }
  walk.go({{1.0, first, 0.5}, 3.0, 3}, 0);
  walk.go({{less, 1.0, 1.0}, 6.0, 3}, 1);
  walk.go({{less, less, -1.0}, 6.0, 4}, 2);
  walk.go({{first, first, 0.0}, 3.0, 2}, 3);
  return walk.done();
}

}  // namespace

const std::vector<std::string>& sheet_suite_names() {
  static const std::vector<std::string> names = {"sheet_field", "sheet_markers",
                                                 "sheet_single_rate", "sheet_no_time"};
  return names;
}

bool is_sheet_suite(const std::string& name) {
  const auto& names = sheet_suite_names();
  return std::find(names.begin(), names.end(), name) != names.end();
}

SheetTraits traits_of(const std::string& sheet_suite) {
  const bool is_rich = sheet_suite == "sheet_field" || sheet_suite == "sheet_markers";
  return {sheet_suite != "sheet_no_time", is_rich, is_rich, sheet_suite != "sheet_markers"};
}

Expected<SheetSuite> plan_sheets(const std::string& name, const Fabric& fabric, Random choices) {
  if (!is_sheet_suite(name)) return bad_input("there is no suite of sheets '" + name + "'");
  SheetSuite suite;
  suite.name = name;
  suite.traits = traits_of(name);
  suite.span_m = 0.16 * fabric.side_m;  // cubic: as good as many triangles
  const bool two_rates = suite.traits.has_rates;
  const int across = name == "sheet_markers" ? 4 : 10;
  suite.spacing_m = fabric.side_m / across;
  suite.places_m = irregular_places(fabric.side_m, across * across,
                                    static_cast<std::uint64_t>(choices.below(1 << 30)));
  const int cells = suite.grid_cells;
  for (const bool along_u : {true, false})
    suite.plans.push_back(pull(fabric, along_u, two_rates, cells, choices));
  if (!suite.traits.has_shear) return suite;
  for (const bool held_out : {false, true})
    suite.plans.push_back(frame(fabric, held_out, cells, choices));
  return suite;
}

}  // namespace tenter::twin
