// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/friction_test/run_friction_test.h"

#include <nlohmann/json.hpp>

#include "server/jobs/friction_test/points/run_point_test.h"
#include "server/jobs/friction_test/strips/run_strip_test.h"

namespace tenter::jobs {

Expected<void> run_friction_test(const JobInput& input, const nlohmann::json& spec,
                                 std::vector<std::pair<std::string, capture::Capture>> captures,
                                 const std::function<void(const JobProgress&)>& report,
                                 const std::stop_token& stop) {
  const nlohmann::json& protocol = spec["options"]["protocol"];
  if (protocol == "hanging-weights")
    return run_hanging_weights(input, spec, std::move(captures), report, stop);
  if (protocol == "loops") return run_loops(input, spec, captures, report, stop);
  if (protocol == "spiral" || protocol == "cantilever")
    return run_strip_test(input, spec, captures, report, stop);
  return bad_input("options.protocol: must be hanging-weights, loops, spiral or cantilever, not " +
                   protocol.dump());
}

}  // namespace tenter::jobs
