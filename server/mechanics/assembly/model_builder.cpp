// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/assembly/model_builder.h"

#include <algorithm>
#include <cmath>

namespace tenter::mechanics {

MeshModel::Builder::Builder(const model::Model& model, int node_count) : description_(model) {
  result_.node_count_ = node_count;
}

Expected<MeshModel::Builder::Site> MeshModel::Builder::site(const model::Term& term,
                                                            bool is_solid) const {
  const std::string name = name_of(term);
  const model::StrainRow* row = model::find_strain(term.strain.name);
  if (!row) return bad_input(name + "no strain measure is called \"" + term.strain.name + "\"");
  if ((row->domain == model::Domain::solid) != is_solid)
    return bad_input(name + "\"" + term.strain.name + "\" is a strain of " +
                     (is_solid ? "cloth, not of solids" : "solids, not of cloth"));
  auto support = Support::make(description_, term.support);
  if (!support) return bad_input(name + support.error().message);
  if (!support->is_everywhere() && support->dimensions() != (is_solid ? 3 : 2))
    return bad_input(name + "the samples of its support must have " +
                     (is_solid ? "three coordinates in a solid" : "two coordinates on cloth"));
  return Site{row, std::move(*support)};
}

Expected<void> MeshModel::Builder::add(const model::Term& term, std::vector<Part> parts) {
  std::erase_if(parts, [](const Part& part) { return part.measure.empty(); });
  if (parts.empty())
    return bad_input(name_of(term) + "this cloth has no element for \"" + term.strain.name + "\"");
  const auto law = make_law(term.law, parts.front().strain->count());
  if (!law) return bad_input(name_of(term) + law.error().message);
  for (Part& part : parts) {
    const auto elements = static_cast<int>(part.measure.size());
    part.group->terms.push_back({std::move(part.strain), *law, result_.term_count_,
                                 result_.parameter_count_, result_.history_count_,
                                 std::move(part.measure)});
    result_.turns_round_ = result_.turns_round_ || (*law)->turns_round();
    result_.history_count_ += (*law)->state_count() * elements;
  }
  ++result_.term_count_;
  result_.parameter_count_ += (*law)->parameter_count();
  return {};
}

Expected<void> MeshModel::Builder::add_limit(const model::EnergyLimit& limit) {
  const std::string name = "limit \"" + limit.id + "\": ";
  if (!std::isfinite(limit.energy_max) || !(limit.energy_max > 0.0))
    return bad_input(name + "its energy_max must be a finite number above 0");
  std::vector<int> wanted;
  for (const std::string& id : limit.terms) {
    const auto& terms = description_.terms;
    const auto found = std::find_if(terms.begin(), terms.end(),
                                    [&](const model::Term& term) { return term.id == id; });
    if (found == terms.end()) return bad_input(name + "the model has no term \"" + id + "\"");
    wanted.push_back(static_cast<int>(found - terms.begin()));
  }
  if (limit.terms.empty()) wanted = numbers(result_.term_count_);
  // what a step from a history costs is no stored energy
  for (const auto& group : order_)
    for (const GroupTerm& part : group->terms) {
      if (part.law->state_count() == 0) continue;
      if (std::erase(wanted, part.term) > 0 && !limit.terms.empty())
        return bad_input(name + "its term \"" +
                         description_.terms[static_cast<std::size_t>(part.term)].id +
                         "\" remembers its path, so that its energy has no limit");
    }
  std::sort(wanted.begin(), wanted.end());
  wanted.erase(std::unique(wanted.begin(), wanted.end()), wanted.end());
  for (const auto& group : order_) {
    GroupLimit part;
    for (std::size_t k = 0; k < group->terms.size(); ++k)
      if (std::binary_search(wanted.begin(), wanted.end(), group->terms[k].term))
        part.terms.push_back(static_cast<int>(k));
    if (part.terms.empty()) continue;
    if (part.terms.size() != wanted.size())
      return bad_input(name +
                       "its terms act on different elements, so that their energies have "
                       "no sum");
    part.energy_max = limit.energy_max;
    part.first = result_.limited_count_;
    result_.limited_.push_back(
        {limit.id, limit.energy_max, group->kind, part.first, group->element, group->measure()});
    result_.limited_count_ += static_cast<int>(group->element.size());
    group->limits.push_back(std::move(part));
  }
  return {};
}

Expected<MeshModel> MeshModel::Builder::finish() {
  for (const model::EnergyLimit& limit : description_.limits)
    if (auto added = add_limit(limit); !added) return tl::unexpected(added.error());
  std::vector<std::pair<int, int>> pairs;
  for (const auto& group : order_) {
    const auto more = group->pairs();
    pairs.insert(pairs.end(), more.begin(), more.end());
  }
  result_.matrix_ = NodeMatrix(result_.node_count_, std::move(pairs));
  for (const auto& group : order_) {
    if (group->terms.empty()) continue;
    group->find_slots(result_.matrix_);
    result_.groups_.push_back(group);
  }
  return std::move(result_);
}

std::string name_of(const model::Term& term) {
  return "term \"" + term.id + "\": ";
}

std::vector<int> numbers(int count, int per) {
  std::vector<int> list(static_cast<std::size_t>(count));
  for (int e = 0; e < count; ++e) list[static_cast<std::size_t>(e)] = e / per;
  return list;
}

std::vector<double> weighted(std::vector<double> measure, const Support& support,
                             const Eigen::MatrixXd& places_m) {
  if (support.is_everywhere()) return measure;
  for (std::size_t e = 0; e < measure.size(); ++e)
    measure[e] *= support.weight(places_m.col(static_cast<Eigen::Index>(e)).data());
  return measure;
}

}  // namespace tenter::mechanics
