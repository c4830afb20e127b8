// SPDX-License-Identifier: Apache-2.0
#include "client/cli/names.h"

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <iterator>

#include "client/cli/output.h"
#include "common/base/sha256.h"
#include "common/base/text_file.h"
#include "common/model/document.h"
#include "common/model/presets.h"

namespace tenter::cli {

Expected<std::string> resolve_job(client::Client& client, const std::string& name) {
  if (name != "last") {
    const bool digits =
        !name.empty() && name.size() <= 18 &&
        std::all_of(name.begin(), name.end(), [](char c) { return c >= '0' && c <= '9'; });
    if (!digits) return bad_input("'" + name + "' is no job: a job is a number, or 'last'");
    return name;
  }
  client::JobFilter filter;
  filter.user = client.user();
  filter.limit = 1;
  const Expected<std::string> reply = client.list_jobs(filter);
  if (!reply) return tl::unexpected(reply.error());
  const Expected<Json> jobs = parse_reply(*reply);
  if (!jobs) return tl::unexpected(jobs.error());
  const Json list = jobs->value("jobs", Json::array());
  if (list.empty())
    return fail(ErrorKind::not_found, "user " + client.user() + " has no job on this server");
  return cell(list[0], "id");
}

bool looks_like_hash(const std::string& name) {
  return name.size() >= 6 && name.size() <= 64 && std::all_of(name.begin(), name.end(), [](char c) {
           return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f');
         });
}

Expected<std::string> resolve_capture(client::Client& client, const std::string& name) {
  if (is_sha256(name)) return name;
  if (!looks_like_hash(name))
    return bad_input(
        "'" + name +
        "' is neither a file here nor the beginning (6 digits or more) of a capture's SHA-256");
  std::vector<std::string> found;
  std::string cursor;
  do {
    const Expected<std::string> reply = client.list_captures(1000, cursor);
    if (!reply) return tl::unexpected(reply.error());
    const Expected<Json> page = parse_reply(*reply);
    if (!page) return tl::unexpected(page.error());
    for (const Json& capture : page->value("captures", Json::array())) {
      const std::string id = cell(capture, "id");
      if (id.rfind(name, 0) == 0) found.push_back(id);
    }
    const Json next = page->value("next", Json());
    cursor = next.is_string() ? next.get<std::string>() : "";
  } while (!cursor.empty() && found.size() < 2);
  if (found.empty())
    return fail(ErrorKind::not_found,
                "the server has no capture whose SHA-256 begins with " + name);
  if (found.size() > 1)
    return bad_input("more than one capture begins with " + name + "; give more digits");
  return found.front();
}

Error about_file(const std::string& file, Error error) {
  const bool named =
      error.message.find(std::filesystem::path(file).filename().string()) != std::string::npos;
  if (!named && error.kind == ErrorKind::bad_input) error.message = file + ": " + error.message;
  return error;
}

Expected<std::string> read_input(const std::string& path, std::size_t max_bytes) {
  if (path != "-") return read_text_file(path, max_bytes);
  std::string text;
  char buffer[65536];
  while (std::cin.read(buffer, sizeof buffer) || std::cin.gcount() > 0) {
    text.append(buffer, static_cast<std::size_t>(std::cin.gcount()));
    if (text.size() > max_bytes)
      return bad_input("standard input: more than " + std::to_string(max_bytes) + " bytes");
  }
  return text;
}

Expected<model::Model> load_model(const std::string& name_or_file) {
  const std::vector<std::string> presets = model::preset_names();
  if (std::find(presets.begin(), presets.end(), name_or_file) != presets.end())
    return model::preset(name_or_file);
  std::error_code ignored;
  if (name_or_file != "-" && !std::filesystem::exists(name_or_file, ignored)) {
    std::string known;
    for (const std::string& preset : presets) known += (known.empty() ? "" : ", ") + preset;
    return fail(ErrorKind::not_found, "there is no model file '" + name_or_file +
                                          "', and the shipped models are " + known);
  }
  const Expected<std::string> text = read_input(name_or_file, model::kMaxDocumentBytes);
  if (!text) return tl::unexpected(text.error());
  return model::parse_model(*text, name_or_file == "-" ? "standard input" : name_or_file);
}

}  // namespace tenter::cli
