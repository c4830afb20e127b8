// SPDX-License-Identifier: GPL-3.0-or-later
// A job's specification: what decides its result, and nothing else.
//
//   {"schema": "tenter.job", "version": 1, "kind": "fit" | "simulate" | "diagnose",
//    "captures": ["<sha256>", ...], "model": {tenter.model document}, "options": {...}}
//
// or, for a simulated scene, "kind": "simulate" with "scene": {tenter.scene document} and no
// captures but the scene's mesh file, where it has one.
//
// Two texts that mean the same (order of keys, white space) are one specification: the canonical
// text has sorted keys and no white space, and its SHA-256 names the job's work.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/error.h"

namespace tenter::jobs {

struct JobSpec {
  std::string kind;
  std::vector<std::string> captures;
  std::string canonical;
  std::string sha256;  ///< of canonical
};

inline constexpr std::size_t kMaxSpecBytes = 1u << 20;
inline constexpr std::size_t kMaxSpecCaptures = 256;

/// Checks the form, and that what is asked of a fit goes together (fit_requests.h); messages name
/// the key. `check_model` and `check_scene`, when given, get the
/// text of "model" and "scene". Whether the captures exist is the queue's question.
Expected<JobSpec> parse_spec(
    std::string_view json_text,
    const std::function<Expected<void>(std::string_view)>& check_model = {},
    const std::function<Expected<void>(std::string_view)>& check_scene = {});

}  // namespace tenter::jobs
