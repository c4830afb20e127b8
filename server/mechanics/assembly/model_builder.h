// SPDX-License-Identifier: GPL-3.0-or-later
// What the makers of MeshModel for cloth and for solids have in common: the terms' names, supports
// and laws, the groups of elements that terms share, and the matrix over all of them.
//
//   MeshModel::Builder builder(model, node_count);
//   auto site = builder.site(term, is_solid);           // the row of its strain, its support
//   auto& group = builder.group<TriangleGroup>("membrane", [&] { return triangle_elements(mesh);
//   }); builder.add(term, {{&group, strain, measure}});      // its law, its parameters' places
//   return builder.finish();
//
// Used at construction only, by one thread.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "common/model/catalogue.h"
#include "server/mechanics/assembly/element_group.h"
#include "server/mechanics/support.h"

namespace tenter::mechanics {

class MeshModel::Builder {
 public:
  Builder(const model::Model& model, int node_count);

  /// Where a term acts.
  struct Site {
    const model::StrainRow* row = nullptr;
    Support support;
  };
  /// bad_input names the term: an unknown strain, one of the other kind of body, or a support that
  /// does not fit.
  Expected<Site> site(const model::Term& term, bool is_solid) const;

  /// The group of this name, made when the first term asks for it.
  template <class Make>
  auto& group(const std::string& name, Make make) {
    using Kind = typename decltype(make())::element_type;
    std::shared_ptr<Group>& found = groups_[name];
    if (!found) {
      found = make();
      order_.push_back(found);
    }
    return static_cast<Kind&>(*found);
  }

  /// One group that a term acts on.
  struct Part {
    Group* group = nullptr;
    std::shared_ptr<const ChunkStrain> strain;
    std::vector<double> measure;  ///< with the support's weight, see weighted()
  };
  /// Parts without an element are left out. bad_input names the term: no part has an element, or a
  /// law that does not take its strains.
  Expected<void> add(const model::Term& term, std::vector<Part> parts);

  /// bad_input names the limit: a term that is not there, terms on different elements, no maximum.
  Expected<MeshModel> finish();

 private:
  Expected<void> add_limit(const model::EnergyLimit& limit);

  const model::Model& description_;
  MeshModel result_;
  std::map<std::string, std::shared_ptr<Group>> groups_;
  std::vector<std::shared_ptr<Group>> order_;
};

/// How error sentences name a term.
std::string name_of(const model::Term& term);

/// 0, 1, ... of `count` elements, `per` in a row with the same number.
std::vector<int> numbers(int count, int per = 1);

/// Measures times the weight of the support at each element's place (a column, in the rest shape).
std::vector<double> weighted(std::vector<double> measure, const Support& support,
                             const Eigen::MatrixXd& places_m);

/// The mean of the corners of each element; `rest_m` has a column a node.
template <class Elements>
Eigen::MatrixXd middles(const Elements& elements, const Eigen::MatrixXd& rest_m) {
  Eigen::MatrixXd places = Eigen::MatrixXd::Zero(rest_m.rows(), elements.count());
  for (int e = 0; e < elements.count(); ++e) {
    const auto& nodes = elements.nodes[static_cast<std::size_t>(e)];
    for (const int n : nodes) places.col(e) += rest_m.col(n) / static_cast<double>(nodes.size());
  }
  return places;
}

}  // namespace tenter::mechanics
