// SPDX-License-Identifier: GPL-3.0-or-later
// The strains of one term of a MeshModel on elements of one kind, for output files and tables.
//
// Data. Entries are the elements that the term acts on, in a fixed order; an element's mean of a
// field is that of its entries, weighed by `measure`.
#pragma once

#include <vector>

namespace tenter::mechanics {

enum class ElementKind {
  triangle,         ///< numbered as SurfaceMesh::triangles
  spring_ring1,     ///< as Springs::ring1
  spring_ring2,     ///< as Springs::ring2
  hinge,            ///< as Cloth::hinges
  tetrahedron,      ///< as SolidMesh::tetrahedra
  hexahedron_point  ///< as SolidMesh::hexahedra; eight entries each, one a quadrature point
};

struct TermStrains {
  int term = 0;  ///< in the order of the model's terms
  ElementKind kind = ElementKind::triangle;
  std::vector<int> element;  ///< number of each entry's element
  std::vector<double>
      measure;                 ///< m^2 or m^3 at rest, times the weight of the term's support there
  int strains = 1;             ///< of an entry: as many as the measure gives
  std::vector<double> strain;  ///< [entry * strains + i], in the measure's unit
};

}  // namespace tenter::mechanics
