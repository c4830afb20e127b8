// SPDX-License-Identifier: Apache-2.0
// What `fit`, `simulate` and `diagnose` have in common: send the captures that the server does not
// have, submit the job, follow it, show what it found.
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "client/cli/context.h"
#include "client/cli/submit.h"
#include "common/base/error.h"

namespace tenter::cli {

struct JobRun {
  std::string kind;                   ///< "fit", "simulate", "diagnose"
  std::vector<std::string> captures;  ///< files, or hashes of captures on the server
  std::string model;                  ///< preset or file; of what is continued where empty
  std::string continues;              ///< diagnosis to go on from: a job's number or "last"
  nlohmann::json options = nlohmann::json::object();  ///< of the job's specification
  /// Adds what only the captures' ids can say, where there is any; called once they are known.
  std::function<Expected<void>(const std::vector<std::string>& ids, nlohmann::json& options)>
      complete_options = nullptr;
  SubmitOptions submit;
  bool detach = false;
  std::string output;      ///< keep result.json here
  std::string report;      ///< write the HTML page here
  std::string save_model;  ///< write the resulting model document here
};

Expected<void> run_job(Context& context, const JobRun& run);

/// What --json prints of a result: everything but the points of the figures.
nlohmann::ordered_json result_digest(const nlohmann::ordered_json& result,
                                     const std::string& job_id);

}  // namespace tenter::cli
