// SPDX-License-Identifier: GPL-3.0-or-later
// An effect: one cause of misfit that the catalogue knows, with the ways to extend a model by it.
//
// A new effect is one file in effects/, one row in catalogue.cpp and one test; its words (id, kind,
// protocol, neighbours) are its row in common/effects, which described() takes over. It says
//   - its variants: terms to append, laws to replace, parameters to free, sensor corrections to
//   add. At its start values
//     a variant changes nothing ("off"); parameters that enter nonlinearly come on a grid;
//   - when the captures cannot show it at all.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/effects/effects.h"
#include "common/model/model.h"
#include "server/estimation/curves.h"

namespace tenter::diagnosis {

/// What sheets excite beside their mean strains.
struct SheetExcitation {
  /// Smallest and largest strain of a measure over elements and frames, outliers aside, zero
  /// included; by measure_key().
  std::map<std::string, std::pair<double, double>> ranges;
  /// Of measures of two strains: the largest that both reach in one element of one frame.
  std::map<std::string, double> together;
  struct Force {
    std::string name;  ///< as sensor corrections address it: their `component`
    std::string capture;
    double largest_N = 0.0;
    int frames = 0;
  };
  std::vector<Force> forces;
  std::vector<std::string> captures;  ///< names of the sequences
  Eigen::Vector2d lo_m = Eigen::Vector2d::Zero(), hi_m = Eigen::Vector2d::Zero();  ///< (u, v)
  bool hangs = false;       ///< gravity moves something
  bool has_hidden = false;  ///< frames do not see all points
};

/// What the captures excite; made once per diagnosis, read by the effects.
struct Excitation {
  std::vector<estimation::Curves> curves;
  /// Largest strain along weft, warp, shear and the +-45 degree fibres (Green measure), from zero.
  double weft = 0.0;
  double warp = 0.0;
  double shear = 0.0;
  double diagonal = 0.0;
  bool has_unloading = false;         ///< some run goes back by more than a fifth of its range
  bool has_repeated_loading = false;  ///< some strain is loaded more than once on one specimen
  bool has_hold = false;              ///< a hold with time
  bool has_clock = false;
  bool has_rate = false;   ///< clock or declared rate
  double rate_span = 1.0;  ///< largest over smallest strain rate between branches of one component
  double longest_s = 1.0;  ///< duration of the longest run
  double shortest_step_s = 1.0;
  bool large_strain = false;           ///< beyond 20 %: Green and engineering measures differ
  std::vector<int> stress_components;  ///< observed, without repetition
  /// Of a sheet, whose `curves` are the means of its strains over the frames: what its material
  /// reached, element by element.
  std::optional<SheetExcitation> sheet;

  /// Rates a factor of three apart or a hold: what tells friction from viscosity.
  bool splits_rate() const { return has_rate && (has_hold || rate_span >= 3.0); }
};

Excitation examine(const std::vector<estimation::Curves>& curves);

/// Name and angle of a measure: a key of SheetExcitation's maps.
std::string measure_key(const model::StrainMeasure& measure);
/// Strains of a measure that the captures reach, zero included; {0, 0} where they do not say.
std::pair<double, double> range_of(const Excitation& excitation,
                                   const model::StrainMeasure& measure);

/// Sets "term.parameter" or "correction.parameter" to a value.
using Setting = std::vector<std::pair<std::string, double>>;

struct Variant {
  std::string words;  ///< "weft and warp"
  std::vector<model::Term> append;
  bool parts_are_one = false;  ///< of terms or of corrections: each alone may be as good as off
  std::vector<std::pair<std::string, model::Law>>
      replace;                     ///< term id -> law that equals it when off
  std::vector<std::string> unfix;  ///< parameters freed
  std::vector<model::SensorCorrection> corrections;
  std::vector<model::Field> fields;  ///< samples of the material that supports of `append` refer to
  std::vector<Setting> grid;  ///< start values of what enters nonlinearly; empty: nothing does
  int searched =
      1;  ///< how many places were searched for the likeliest; p values are multiplied by it
  std::vector<Setting>
      finer;  ///< looked at only for the variant of its effect that the grid likes best
};

using NextProtocol = effects::Protocol;

struct Effect {
  std::string id;
  std::string words;  ///< as its row in common/effects says them, like all that is words here
  effects::Kind kind = effects::Kind::material;
  bool in_every_run = true;  ///< false: an accident; other runs and captures do not show it
  bool needs_rate = false;   ///< without time or rate at most AMBIGUOUS
  bool is_exact = false;     ///< a number is all that is not known of it: its form misses nothing
  /// Another effect, of which this is a sharper form: where both do alike the other is the word.
  std::string special_form_of = {};
  /// Endings of parameters of which one must be off its bounds: without it the extension is
  /// something else's.
  std::vector<std::string> hallmarks = {};
  /// What the extension is where none of the hallmarks is there: an effect's id, or none.
  std::string plain_form = {};
  std::vector<std::string> mistaken_for;
  NextProtocol split_by;  ///< the protocol that excites it and tells it from its neighbours
  /// Ways to extend this model; empty: nothing to add.
  std::function<std::vector<Variant>(const model::Model&, const Excitation&)> variants;
  /// Why the captures cannot show it; nothing: they can.
  std::function<std::optional<std::string>(const model::Model&, const Excitation&)> not_excited;
  /// The same two for sheets, of effects whose parts differ there; none: a material's as above,
  /// and of a sensor's that sheets cannot show it.
  std::function<std::vector<Variant>(const model::Model&, const Excitation&)> sheet_variants = {};
  std::function<std::optional<std::string>(const model::Model&, const Excitation&)>
      sheet_not_excited = {};
};

/// Of curves or of sheets, as the excitation is.
std::vector<Variant> variants_of(const Effect& effect, const model::Model& model,
                                 const Excitation& excitation);
std::optional<std::string> why_not_excited(const Effect& effect, const model::Model& model,
                                           const Excitation& excitation);

/// An effect with the words of its row in common/effects, which must be there.
Effect described(const std::string& id);

/// All effects of curves, in the order of the design table.
const std::vector<Effect>& catalogue();
/// The same, then those that only sheets show.
const std::vector<Effect>& sheet_catalogue();
const Effect* find_effect(const std::string& id);

/// The model with the variant's parts added, switched off, at a point of its grid.
model::Model extend(const model::Model& model, const Variant& variant, const Setting& setting,
                    const std::string& effect_id);

// --- helpers for the effects' files ---

/// A term with an id that the model does not have yet: "friction_weft", "friction_weft_2", ...
model::Term new_term(const model::Model& model, const std::string& id, const std::string& measure,
                     double angle_rad, const std::string& law, int control_points = 0);
void set_parameter(model::Law& law, const std::string& name, double value, bool fixed = false);
model::SensorCorrection new_correction(const model::Model& model, const std::string& type,
                                       const std::string& component);
/// The same of sheets; `capture`: a sequence's name, "" all.
model::SensorCorrection new_sheet_correction(const model::Model& model, const std::string& type,
                                             const std::string& component,
                                             const std::string& capture);
/// A direction in which an effect can act.
struct Place {
  std::string name;  ///< "weft", "warp", "shear", "diagonal"; of sheets also "bend_weft", ...
  std::string measure;
  double angle_rad = 0.0;
  double lo = 0.0;  ///< strains of this measure that the captures reach, zero included
  double hi = 0.0;
  double reach() const { return hi > -lo ? hi : -lo; }
};
/// Directions that the captures strain, in the model's own family of measures; with `both_families`
/// those of the other family too where strains are large enough to tell them apart.
std::vector<Place> places(const model::Model& model, const Excitation& excitation,
                          bool both_families);
/// Whether a term ties the two stretches together (bilinear, area, trace, fibre pairs).
bool has_coupling(const model::Model& model);
/// All places alone, then weft and warp together, and these with the diagonal.
std::vector<std::vector<Place>> place_groups(const std::vector<Place>& places);
/// "weft and warp"; with "(engineering strain)" where it is not the Green measure.
std::string place_words(const std::vector<Place>& group);
/// The measures on which the model's own terms are built: "soft" where it has any engineering
/// measure along weft or warp, else "green".
std::string measure_family(const model::Model& model);

}  // namespace tenter::diagnosis
