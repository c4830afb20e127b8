// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/friction_test/strips/strip_part.h"

#include <algorithm>
#include <cmath>

#include "server/estimation/friction_tests/strain_point.h"

namespace tenter::jobs {

void look_at_samples(StripPart& part) {
  part.samples.clear();
  const auto point = estimation::StrainPoint::make(part.found.friction.model);
  const Eigen::VectorXd& parameters = part.found.friction.fit.parameters;
  const std::vector<double>& predicted = part.found.predicted;
  for (const estimation::ProfileSamples& profile : part.found.profiles)
    for (const estimation::TorqueSample& sample : profile.samples) {
      SampleOfStrip at{&profile, &sample, std::nan(""), std::nan("")};
      if (part.samples.size() < predicted.size()) at.strain = predicted[part.samples.size()];
      if (point) {
        estimation::StrainPoint::Walk walk;
        point->begin(walk);
        if (profile.anchor > 0.0) point->to_strain(profile.anchor, parameters, walk);
        double tangent = 0.0;
        point->look(sample.strain, parameters, false, walk, at.torque, tangent);
      }
      part.samples.push_back(at);
    }
}

double rms_of_samples(const std::vector<StripPart>& parts,
                      const std::function<double(const SampleOfStrip&)>& value) {
  double squares = 0.0;
  std::size_t count = 0;
  for (const StripPart& part : parts)
    for (const SampleOfStrip& sample : part.samples) {
      squares += std::pow(value(sample), 2);
      ++count;
    }
  return std::sqrt(squares / static_cast<double>(std::max<std::size_t>(1, count)));
}

}  // namespace tenter::jobs
