// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/worker/worker_protocol.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "server/jobs/store/files.h"

namespace tenter::jobs {
namespace {

using nlohmann::json;
using replace = json::error_handler_t;

constexpr std::size_t kMaxText = 2000;

std::string text_of(const json& from, const char* key) {
  const auto found = from.find(key);
  if (found == from.end() || !found->is_string()) return {};
  return found->get<std::string>().substr(0, kMaxText);
}

double number_of(const json& from, const char* key) {
  const auto found = from.find(key);
  if (found == from.end() || !found->is_number()) return 0;
  const double value = found->get<double>();
  return std::isfinite(value) ? value : 0;
}

}  // namespace

std::string write_order(const WorkOrder& order, int parent) {
  json captures = json::array();
  for (const auto& [sha256, path] : order.captures) captures.push_back({sha256, path.string()});
  return json{{"job", order.claim.job},
              {"epoch", order.claim.epoch},
              {"spec", order.spec_json},
              {"captures", captures},
              {"folder", order.folder.string()},
              {"checkpoints", order.checkpoints.string()},
              {"time_limit_s", order.time_limit_s},
              {"memory_limit_bytes", order.memory_limit_bytes},
              {"heartbeat_ms", order.heartbeat.count()},
              {"parent", parent}}
      .dump();
}

Expected<ReceivedOrder> read_order(const std::filesystem::path& file) {
  auto text = read_file(file, 16u << 20);
  if (!text) return tl::unexpected(text.error());
  try {
    const json order = json::parse(*text);
    ReceivedOrder received;
    received.order.claim = {order.at("job").get<JobId>(), order.at("epoch").get<std::int64_t>()};
    received.order.spec_json = order.at("spec").get<std::string>();
    for (const json& capture : order.at("captures")) {
      received.order.captures.emplace_back(capture.at(0).get<std::string>(),
                                           capture.at(1).get<std::string>());
    }
    received.order.folder = order.at("folder").get<std::string>();
    received.order.checkpoints = order.at("checkpoints").get<std::string>();
    received.order.time_limit_s = order.at("time_limit_s").get<double>();
    received.order.memory_limit_bytes = order.at("memory_limit_bytes").get<std::uint64_t>();
    received.order.heartbeat =
        std::chrono::milliseconds(order.at("heartbeat_ms").get<std::int64_t>());
    received.parent = order.at("parent").get<int>();
    return received;
  } catch (const json::exception& trouble) {
    return bad_input(file.string() + ": is not a work order: " + trouble.what());
  }
}

std::string write_line(const WorkerLine& line) {
  json out;
  if (const auto* progress = std::get_if<JobProgress>(&line)) {
    out["progress"] = {{"stage", progress->stage.substr(0, kMaxText)},
                       {"detail", progress->detail.substr(0, kMaxText)},
                       {"iteration", progress->iteration},
                       {"cost", progress->cost},
                       {"fraction", progress->fraction}};
  } else if (const auto* error = std::get_if<Error>(&line)) {
    out["error"] = {{"kind", name_of(error->kind)},
                    {"message", error->message.substr(0, kMaxText)}};
  } else {
    out["heartbeat"] = true;
  }
  return out.dump(-1, ' ', false, replace::replace) + "\n";
}

std::optional<WorkerLine> read_line(std::string_view text) {
  const json line = json::parse(text, nullptr, false);
  if (!line.is_object()) return std::nullopt;
  if (line.contains("heartbeat")) return Heartbeat{};
  if (const auto found = line.find("progress"); found != line.end() && found->is_object()) {
    JobProgress progress;
    progress.stage = text_of(*found, "stage");
    progress.detail = text_of(*found, "detail");
    progress.iteration = static_cast<int>(std::clamp(number_of(*found, "iteration"), -1.0, 2e9));
    progress.cost = number_of(*found, "cost");
    progress.fraction = std::clamp(number_of(*found, "fraction"), 0.0, 1.0);
    return progress;
  }
  if (const auto found = line.find("error"); found != line.end() && found->is_object()) {
    return Error{error_kind_from(text_of(*found, "kind")).value_or(ErrorKind::internal),
                 text_of(*found, "message")};
  }
  return std::nullopt;
}

}  // namespace tenter::jobs
