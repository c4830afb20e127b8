// SPDX-License-Identifier: Apache-2.0
// A model document: the list of terms (strain measure x law x support) of which a simulation is
// made, plus the corrections of sensors that a diagnosis may add. Data only; what a name computes
// is server/mechanics.
//
// JSON form (schema "tenter.model", version 1) and the catalogue of names are described in
// README.md.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace tenter::model {

/// One number of a law. Values, bounds and intervals are in `unit` (SI).
struct Parameter {
  std::string name;
  double value = 0.0;
  std::string unit;
  std::optional<double> lower;
  std::optional<double> upper;
  bool fixed = false;                 ///< not changed by fits
  std::optional<double> std_error;    ///< filled by fits
  std::optional<double> interval_lo;  ///< 95 % interval, filled by fits
  std::optional<double> interval_hi;
};

/// Maps the deformation to one to three scalar strains.
struct StrainMeasure {
  std::string name;        ///< row of the strain catalogue, e.g. "green_u"
  double angle_rad = 0.0;  ///< fibre measures: from weft towards warp; of solids from x towards y
  double elevation_rad = 0.0;  ///< fibre measures of solids: from the x-y plane towards z
};

/// Maps strain (and history) to stress.
struct Law {
  std::string name;       ///< row of the law catalogue, e.g. "linear", "dahl"
  double range_lo = 0.0;  ///< spline laws: strain of the first and of the last control point
  double range_hi = 0.0;
  /// Stiffness splines: strains inside the range where one piece ends and the next begins, rising;
  /// of hermite_stiffness its inner control points. Empty: even ones (catalogue.h, spline_knots).
  std::vector<double> knots = {};
  std::vector<Parameter>
      parameters;  ///< in the catalogue's order; splines have one per control point
};

/// Where in the material a term acts: a weight between 0 and 1 on its energy density.
struct Support {
  std::string name = "everywhere";  ///< or "rbf": around one sample of a field (thesis 4.2.4)
  std::string field;                ///< rbf: id of the model's field
  int sample = 0;                   ///< rbf: which of the field's samples, counted from 1
};

/// Samples of the material over which terms are interpolated by normalised Gaussians (thesis 4.4).
struct Field {
  std::string id;
  int dimensions = 2;               ///< of the rest shape: 2 for cloth (u, v), 3 for solids
  std::vector<double> positions_m;  ///< `dimensions` numbers for each sample
  double width_m = 0.0;             ///< standard deviation of the Gaussians
  int sample_count() const { return static_cast<int>(positions_m.size()) / dimensions; }
};

struct Term {
  std::string id;      ///< unique within the model; parameters are addressed as "id.parameter"
  std::string effect;  ///< id of the effect that asked for this term, "" in a baseline
  StrainMeasure strain;
  Law law;
  Support support;
};

/// A bound on an energy density (thesis 4.2.5): Psi_max - Psi_i >= 0 everywhere in the material,
/// Psi_i the sum of some terms that act on the same elements, each with its support's weight.
struct EnergyLimit {
  std::string id;
  std::vector<std::string> terms;  ///< their ids; none: all terms of the model
  double energy_max = 0.0;         ///< above zero
  std::string unit;                ///< "J/m^2" on cloth, "J/m^3" in solids
};

/// What a channel does to the true value, e.g. "offset", "gain", "drift", "delay".
struct SensorCorrection {
  std::string id;
  std::string effect;
  std::string capture;    ///< capture hash, of sheets the sequence's name, or "" for all
  std::string component;  ///< "x", "y", "xy", of sheets a channel of force, or "" for all
  std::string type;       ///< row of the correction catalogue
  std::vector<Parameter> parameters;
};

/// Largest and smallest strain of a measure that the data of a fit reached.
struct StrainRange {
  std::string term;
  double lo = 0.0;
  double hi = 0.0;
};

struct Lineage {
  std::string parent;                 ///< name of the model this one extends
  std::vector<std::string> added;     ///< effects, in the order of their acceptance
  std::vector<std::string> captures;  ///< SHA-256 of the captures it was fitted to
};

struct Model {
  std::string name;
  std::string description;
  std::vector<Term> terms;
  std::vector<Field> fields;  ///< what supports refer to
  std::vector<EnergyLimit> limits;
  std::vector<SensorCorrection> corrections;
  std::vector<StrainRange> strain_ranges;
  std::optional<Lineage> lineage;
};

}  // namespace tenter::model
