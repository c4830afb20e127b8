// SPDX-License-Identifier: Apache-2.0
#include "client/cli/continued.h"

#include "client/cli/follow.h"
#include "client/cli/names.h"
#include "client/cli/output.h"

namespace tenter::cli {

namespace {

/// What a result said, short: NOT_EXCITED says only what was not asked.
nlohmann::json said_in(const Json& result) {
  nlohmann::json said = nlohmann::json::array();
  for (const Json& verdict : result.value("verdicts", Json::array())) {
    const std::string kind = verdict.value("verdict", "");
    if (kind == "NOT_EXCITED" || kind.empty()) continue;
    nlohmann::json one = {{"verdict", kind}, {"alternatives", nlohmann::json::array()}};
    if (verdict.contains("effect") && verdict["effect"].is_string())
      one["effect"] = verdict["effect"].get<std::string>();
    for (const Json& other : verdict.value("alternatives", Json::array()))
      if (other.is_string()) one["alternatives"].push_back(other.get<std::string>());
    said.push_back(std::move(one));
  }
  return said;
}

}  // namespace

Expected<Continued> continue_from(client::Client& client, const std::string& name) {
  const Expected<std::string> id = resolve_job(client, name);
  if (!id) return tl::unexpected(id.error());
  const Expected<std::string> text = client.show_job(*id);
  if (!text) return tl::unexpected(text.error());
  const Expected<Json> job = parse_reply(*text);
  if (!job) return tl::unexpected(job.error());
  const std::string kind = job->value("kind", "");
  const std::string state = job->value("state", "");
  if (kind != "diagnose")
    return bad_input("--continue " + *id + ": is a " + kind +
                     "; only a diagnosis can be continued");
  if (state != "succeeded")
    return bad_input("--continue " + *id + ": is " + state +
                     "; only a diagnosis that succeeded can be continued");
  const nlohmann::json spec = nlohmann::json::parse(job->value("spec", Json::object()).dump());
  const Expected<std::string> result_text = fetch_result_text(client, *id);
  if (!result_text) return tl::unexpected(result_text.error());
  const Expected<Json> result = parse_reply(*result_text);
  if (!result) return tl::unexpected(result.error());
  Continued continued;
  for (const auto& capture : spec.value("captures", nlohmann::json::array()))
    if (capture.is_string()) continued.captures.push_back(capture.get<std::string>());
  continued.model_json = spec.value("model", nlohmann::json::object()).dump();
  continued.options = spec.value("options", nlohmann::json::object());
  continued.options["continues"] = {{"job", *id}, {"said", said_in(*result)}};
  return continued;
}

}  // namespace tenter::cli
