// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/spec.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "common/base/sha256.h"
#include "server/jobs/fit_requests.h"

namespace tenter::jobs {
namespace {

using nlohmann::json;

constexpr int kMaxDepth = 64;

// The parser of the library recurses per level and keeps the last of two equal keys; both are
// refused here.
Expected<json> read_document(std::string_view text) {
  std::vector<std::set<std::string>> keys;
  std::string trouble;
  const auto watch = [&](int depth, json::parse_event_t event, json& value) {
    if (depth > kMaxDepth && trouble.empty()) trouble = "is nested too deeply";
    if (event == json::parse_event_t::object_start) keys.emplace_back();
    if (event == json::parse_event_t::object_end && !keys.empty()) keys.pop_back();
    if (event == json::parse_event_t::key && !keys.empty()) {
      const auto name = value.get<std::string>();
      if (!keys.back().insert(name).second && trouble.empty()) {
        trouble = "has the key \"" + name.substr(0, 64) + "\" twice in one object";
      }
    }
    return true;
  };
  json document = json::parse(text, watch, false);
  if (document.is_discarded()) return bad_input("the job specification is not JSON");
  if (!trouble.empty()) return bad_input("the job specification " + trouble);
  if (!document.is_object()) return bad_input("the job specification is not a JSON object");
  return document;
}

Expected<std::string> string_at(const json& document, const char* key) {
  const auto found = document.find(key);
  if (found == document.end())
    return bad_input("job specification: \"" + std::string(key) + "\" is missing");
  if (!found->is_string())
    return bad_input("job specification: \"" + std::string(key) + "\" must be a string");
  return found->get<std::string>();
}

Expected<std::vector<std::string>> captures_of(const json& document, const std::string& kind) {
  const auto found = document.find("captures");
  if (found == document.end() || !found->is_array()) {
    return bad_input("job specification: \"captures\" must be a list of capture ids");
  }
  if (found->empty())
    return bad_input("job specification: a " + kind + " needs at least one capture");
  if (found->size() > kMaxSpecCaptures) {
    return bad_input("job specification: \"captures\" has more than " +
                     std::to_string(kMaxSpecCaptures) + " entries");
  }
  std::vector<std::string> captures;
  for (std::size_t i = 0; i < found->size(); ++i) {
    const json& entry = (*found)[i];
    const std::string place = "job specification: captures[" + std::to_string(i) + "]";
    if (!entry.is_string() || !is_sha256(entry.get_ref<const std::string&>())) {
      return bad_input(place + " must be a SHA-256 in 64 lower-case hex digits");
    }
    auto sha256 = entry.get<std::string>();
    if (std::find(captures.begin(), captures.end(), sha256) != captures.end()) {
      return bad_input(place + " is listed twice");
    }
    captures.push_back(std::move(sha256));
  }
  return captures;
}

/// A scene is simulated, and on its own: what is listed is its mesh file, if it names one.
Expected<std::vector<std::string>> captures_of_scene(const json& document,
                                                     const std::string& kind) {
  const json& scene = document["scene"];
  if (!scene.is_object()) return bad_input("job specification: \"scene\" must be a scene document");
  if (kind != "simulate")
    return bad_input("job specification: \"scene\" is for simulate, not for " + kind);
  const auto mesh = scene.find("mesh");
  const bool has_file = mesh != scene.end() && mesh->is_object() && mesh->contains("sha256");
  const auto captures = document.find("captures");
  if (!has_file) {
    if (captures != document.end() && (!captures->is_array() || !captures->empty()))
      return bad_input("job specification: a scene without a mesh file has no \"captures\"");
    return std::vector<std::string>{};
  }
  auto listed = captures_of(document, kind);
  if (listed && (listed->size() != 1 || listed->front() != (*mesh)["sha256"]))
    return bad_input("job specification: \"captures\" must list the scene's mesh.sha256 alone");
  return listed;
}

}  // namespace

Expected<JobSpec> parse_spec(std::string_view json_text,
                             const std::function<Expected<void>(std::string_view)>& check_model,
                             const std::function<Expected<void>(std::string_view)>& check_scene) {
  if (json_text.size() > kMaxSpecBytes) {
    return bad_input("the job specification has " + std::to_string(json_text.size()) +
                     " bytes, more than the allowed " + std::to_string(kMaxSpecBytes));
  }
  auto document = read_document(json_text);
  if (!document) return tl::unexpected(document.error());
  for (const auto& [key, value] : document->items()) {
    static constexpr const char* kKnown[] = {"schema", "version", "kind", "captures",
                                             "model",  "options", "scene"};
    if (std::find(std::begin(kKnown), std::end(kKnown), key) == std::end(kKnown)) {
      return bad_input("job specification: unknown key \"" + key.substr(0, 64) + "\"");
    }
  }
  auto schema = string_at(*document, "schema");
  if (!schema) return tl::unexpected(schema.error());
  if (*schema != "tenter.job")
    return bad_input("job specification: \"schema\" must be \"tenter.job\"");
  const auto version = document->find("version");
  if (version == document->end() || !version->is_number_integer() || *version != 1) {
    return bad_input("job specification: \"version\" must be 1");
  }
  auto kind = string_at(*document, "kind");
  if (!kind) return tl::unexpected(kind.error());
  if (*kind != "fit" && *kind != "simulate" && *kind != "diagnose") {
    return bad_input("job specification: \"kind\" must be fit, simulate or diagnose, not \"" +
                     kind->substr(0, 64) + "\"");
  }
  const auto scene = document->find("scene");
  auto captures = scene == document->end() ? captures_of(*document, *kind)
                                           : captures_of_scene(*document, *kind);
  if (!captures) return tl::unexpected(captures.error());
  const auto model = document->find("model");
  if (model == document->end() || !model->is_object()) {
    return bad_input("job specification: \"model\" must be a model document");
  }
  const auto options = document->find("options");
  if (options != document->end() && !options->is_object()) {
    return bad_input("job specification: \"options\" must be an object");
  }
  if (*kind == "fit" && options != document->end())
    if (auto ok = check_fit_requests(*model, *options); !ok) return tl::unexpected(ok.error());

  JobSpec spec;
  try {  // dump throws on text that is not UTF-8
    if (check_model) {
      if (auto sound = check_model(model->dump()); !sound) {
        return fail(sound.error().kind, "job specification: model: " + sound.error().message);
      }
    }
    if (scene != document->end() && check_scene) {
      if (auto sound = check_scene(scene->dump()); !sound) {
        return fail(sound.error().kind, "job specification: " + sound.error().message);
      }
    }
    (*document)["captures"] = *captures;
    if (options == document->end()) (*document)["options"] = json::object();
    spec.canonical = document->dump();
  } catch (const json::exception&) {
    return bad_input("the job specification has text that is not UTF-8");
  }
  spec.kind = *kind;
  spec.captures = std::move(*captures);
  spec.sha256 = sha256_hex(spec.canonical);
  return spec;
}

}  // namespace tenter::jobs
