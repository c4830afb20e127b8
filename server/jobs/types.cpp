// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/types.h"

#include <array>
#include <charconv>

namespace tenter::jobs {
namespace {

constexpr std::array<std::string_view, 5> kStates = {"queued", "running", "succeeded", "failed",
                                                     "cancelled"};
constexpr std::array<std::string_view, 9> kErrorKinds = {"",          "internal",   "bad_input",
                                                         "not_found", "refused",    "unavailable",
                                                         "no_space",  "job_failed", "cancelled"};

}  // namespace

std::string job_id_text(JobId id) {
  return std::to_string(id);
}

Expected<JobId> parse_job_id(std::string_view text) {
  JobId id = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), id);
  if (error != std::errc() || end != text.data() + text.size() || id <= 0 || text.front() == '0') {
    return bad_input("'" + std::string(text.substr(0, 64)) + "' is not a job id");
  }
  return id;
}

std::string_view name_of(JobState state) {
  return kStates[static_cast<std::size_t>(state)];
}

std::optional<JobState> job_state_from(std::string_view name) {
  for (std::size_t i = 0; i < kStates.size(); ++i) {
    if (kStates[i] == name) return static_cast<JobState>(i);
  }
  return std::nullopt;
}

std::string_view name_of(ErrorKind kind) {
  return kErrorKinds[static_cast<std::size_t>(kind)];
}

std::optional<ErrorKind> error_kind_from(std::string_view name) {
  for (std::size_t i = 1; i < kErrorKinds.size(); ++i) {
    if (kErrorKinds[i] == name) return static_cast<ErrorKind>(i);
  }
  return std::nullopt;
}

}  // namespace tenter::jobs
