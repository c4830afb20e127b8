// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/support.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace tenter::mechanics {

Expected<Support> Support::make(const model::Model& model, const model::Support& description) {
  Support support;
  if (description.name == "everywhere") return support;
  if (description.name != "rbf")
    return bad_input("no support is called \"" + description.name + "\"");
  const auto field = std::find_if(model.fields.begin(), model.fields.end(),
                                  [&](const model::Field& f) { return f.id == description.field; });
  if (field == model.fields.end())
    return bad_input("the model has no field \"" + description.field + "\"");
  if ((field->dimensions != 2 && field->dimensions != 3) || !(field->width_m > 0.0))
    return bad_input("field \"" + field->id + "\" needs 2 or 3 dimensions and a width above 0");
  if (description.sample < 1 || description.sample > field->sample_count())
    return bad_input("field \"" + field->id + "\" has " + std::to_string(field->sample_count()) +
                     " samples and no sample " + std::to_string(description.sample));
  support.dimensions_ = field->dimensions;
  support.sample_ = static_cast<std::size_t>(description.sample - 1);
  support.per_width_ = 1.0 / field->width_m;
  support.positions_m_ = field->positions_m;
  return support;
}

// Exponents count from the nearest sample, whose Gaussian is then 1: the sum cannot vanish.
double Support::weight(const double* position_m) const {
  if (is_everywhere()) return 1.0;
  const auto dimensions = static_cast<std::size_t>(dimensions_);
  const auto distance = [&](std::size_t k) {
    double sum = 0.0;
    for (std::size_t a = 0; a < dimensions; ++a) {
      const double d = (position_m[a] - positions_m_[k * dimensions + a]) * per_width_;
      sum += d * d;
    }
    return sum;
  };
  const std::size_t samples = positions_m_.size() / dimensions;
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < samples; ++k) nearest = std::min(nearest, distance(k));
  double sum = 0.0;
  for (std::size_t k = 0; k < samples; ++k) sum += std::exp(-0.5 * (distance(k) - nearest));
  return std::exp(-0.5 * (distance(sample_) - nearest)) / sum;
}

}  // namespace tenter::mechanics
