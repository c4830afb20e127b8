// SPDX-License-Identifier: Apache-2.0
// The frames of a simulated scene: a mesh over time with reactions, energies and strains.
//
// What a job leaves as frames.h5; README.md describes the layout. Everything is SI. Lists that go
// over frames have the frame as their slowest index.
#pragma once

#include <string>
#include <vector>

namespace tenter::frames {

/// Elements of one kind; strains are given on them.
struct Elements {
  std::string kind;  ///< triangle, tetrahedron, hexahedron, spring_ring1, spring_ring2, hinge
  int corners = 0;
  std::vector<int> nodes;  ///< `corners` a element
  int count() const { return corners > 0 ? static_cast<int>(nodes.size()) / corners : 0; }
};

/// The strains of one term on all elements of a kind; 0 where the term does not act.
struct StrainSeries {
  std::string term;
  std::string measure;        ///< row of the strain catalogue
  std::string kind;           ///< of the elements
  std::string unit;           ///< "1", or "1/m" on hinges
  std::vector<double> share;  ///< of each element: area (m^2) or volume (m^3) the term stands for
  std::vector<std::vector<double>> values;  ///< [strain][frame][element]
  int strains() const { return static_cast<int>(values.size()); }
};

struct FrameSet {
  std::string title;
  std::string scene_json;
  std::string model_json;

  int nodes = 0;
  int coordinates = 2;             ///< of the material: 2 sheet, 3 body
  std::vector<double> material_m;  ///< [node][coordinate]
  std::vector<Elements> elements;

  std::vector<std::string> phases;  ///< names; phase -1 is the start
  std::vector<std::string> clips;
  std::vector<std::string> cords;  ///< "clip.cord"
  std::vector<std::string> terms;

  // per frame
  std::vector<int> phase;
  std::vector<double> phase_share;
  std::vector<int> steps, iterations, factorisations;
  std::vector<int> stability;  ///< 0 minimum, 1 neutral, 2 not checked
  std::vector<double> net_force_N;
  std::vector<double> contact_violation_m;
  std::vector<double> limit_violation;  ///< of energy limits, in parts of psi_max
  std::vector<double> gravity_factor;
  std::vector<double> pressure_Pa;
  std::vector<double> potential_J;
  std::vector<double> time_s, kinetic_J, step_error_m;  ///< of motions; else empty

  std::vector<double> position_m;       ///< [frame][node][3]
  std::vector<double> velocity_m_s;     ///< [frame][node][3] of motions; else empty
  std::vector<double> clip_position_m;  ///< [frame][clip][3]
  std::vector<double> clip_rotation;    ///< [frame][clip][row][column]
  std::vector<double> force_N;          ///< [frame][clip][3]
  std::vector<double> torque_N_m;       ///< [frame][clip][3], about clip_position_m
  std::vector<double> cord_force_N;     ///< [frame][cord][3]
  std::vector<double> term_energy_J;    ///< [frame][term]
  std::vector<StrainSeries> strains;

  int frame_count() const { return static_cast<int>(phase.size()); }
};

}  // namespace tenter::frames
