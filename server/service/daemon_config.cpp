// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/service/daemon_config.h"

#include <cmath>
#include <cstdint>
#include <fstream>
#include <functional>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

namespace tenter::service {

using nlohmann::json;

namespace {

// What to do with a key's value: "" or what it should be.
using Setter = std::function<std::string(const json&)>;
using Table = std::map<std::string, Setter>;

std::string apply(const json& object, const Table& table, const std::string& prefix) {
  if (!object.is_object()) return (prefix.empty() ? "the file" : prefix) + " is not an object";
  for (const auto& [key, value] : object.items()) {
    const std::string path = prefix.empty() ? key : prefix + '.' + key;
    const auto found = table.find(key);
    if (found == table.end()) return path + " is not a known key";
    const std::string wrong = found->second(value);
    if (!wrong.empty()) return wrong.starts_with(path) ? wrong : path + ' ' + wrong;
  }
  return {};
}

template <class Integer>
Setter integer(Integer& target, std::int64_t least, std::int64_t most) {
  return [&target, least, most](const json& value) -> std::string {
    const bool fits = value.is_number_integer() &&
                      value.get<double>() >= static_cast<double>(least) &&
                      value.get<double>() <= static_cast<double>(most);
    if (!fits)
      return "is not a whole number from " + std::to_string(least) + " to " + std::to_string(most);
    target = static_cast<Integer>(value.get<std::int64_t>());
    return {};
  };
}

Setter duration(double& target) {
  return [&target](const json& value) -> std::string {
    if (!value.is_number() || !(value.get<double>() > 0))
      return "is not a positive number of seconds";
    target = value.get<double>();
    return {};
  };
}

Setter text(std::string& target) {
  return [&target](const json& value) -> std::string {
    if (!value.is_string()) return "is not a text";
    target = value.get<std::string>();
    return {};
  };
}

Setter texts(std::vector<std::string>& target) {
  return [&target](const json& value) -> std::string {
    if (!value.is_array()) return "is not a list of texts";
    target.clear();
    for (const json& one : value) {
      if (!one.is_string()) return "is not a list of texts";
      target.push_back(one.get<std::string>());
    }
    return {};
  };
}

Setter object(Table table, std::string name) {
  return [table = std::move(table), name = std::move(name)](const json& value) {
    return apply(value, table, name);
  };
}

}  // namespace

Expected<void> read_daemon_config(const std::filesystem::path& file, DaemonConfig& config) {
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream content;
  if (!stream || !(content << stream.rdbuf()))
    return fail(ErrorKind::not_found, file.string() + ": cannot be read");
  json document;
  try {
    document = json::parse(content.str(), nullptr, true, true);
  } catch (const json::exception& problem) {
    return bad_input(file.string() + ": is not JSON: " + problem.what());
  }
  constexpr auto kBytes = std::int64_t{1} << 50;
  auto& jobs = config.jobs;
  auto& quota = jobs.default_quota;
  int domain = config.domain.value_or(-1);
  const Table table = {
      {"domain", integer(domain, 0, 232)},
      {"name", text(config.name)},
      {"interfaces", texts(config.interfaces)},
      {"log_level", text(config.log_level)},
      {"workers", integer(jobs.parallel, 1, 1024)},
      {"limits",
       object({{"default_time_s", duration(jobs.default_time_limit_s)},
               {"max_time_s", duration(jobs.max_time_limit_s)},
               {"default_memory_bytes", integer(jobs.default_memory_limit_bytes, 1 << 20, kBytes)},
               {"max_memory_bytes", integer(jobs.max_memory_limit_bytes, 1 << 20, kBytes)},
               {"capture_bytes", integer(jobs.max_capture_bytes, 1, kBytes)},
               {"attempts", integer(jobs.max_attempts, 1, 100)}},
              "limits")},
      {"quota", object({{"queued", integer(quota.max_queued, 1, 1000000)},
                        {"running", integer(quota.max_running, 1, 10000)},
                        {"stored_bytes", integer(quota.max_stored_bytes, 1, kBytes)}},
                       "quota")},
  };
  const std::string wrong = apply(document, table, "");
  if (!wrong.empty()) return bad_input(file.string() + ": " + wrong);
  if (domain >= 0) config.domain = domain;
  return {};
}

}  // namespace tenter::service
