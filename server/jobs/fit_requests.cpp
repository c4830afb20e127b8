// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/fit_requests.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <string>

namespace tenter::jobs {
namespace {

using nlohmann::json;

/// Whether an option asks for something. A word after the sign narrows it to that value.
bool is_asked(const json& options, const std::string& name) {
  const std::size_t sign = name.find('=');
  const auto found = options.find(name.substr(0, sign));
  if (found == options.end()) return false;
  if (sign != std::string::npos) return *found == name.substr(sign + 1);
  if (found->is_boolean()) return found->get<bool>();
  if (found->is_number()) return *found != 0;
  return found->is_string() && *found != "none";
}

struct Pair {
  const char* one;
  const char* other;
  const char* why;
};
constexpr Pair kApart[] = {
    {"samples", "limits", "samples are not made of a model with energy limits"},
    {"samples", "convex=every_step", "a sample's numbers would leave the convex ones"},
    {"samples", "convex=afterwards", "a sample's numbers would leave the convex ones"},
    {"samples", "profiles", "profiles would vary numbers that samples share one by one"},
    {"samples", "robust", "samples are judged by squares"},
    {"limits", "convex=every_step", "the alternation would leave the convex parameters"},
    {"limits", "convex=afterwards", "the alternation would leave the convex parameters"},
    {"limits", "profiles", "profiles would hold Psi_max and come out too narrow"},
    {"limits", "starts", "the starts would be compared at a Psi_max that is not the fitted one"},
    {"without_grid_error", "grid=equal",
     "a table's edge lies anywhere between equal cells, so that two grids do not tell a third"},
    {"convex=every_step", "robust", "projected steps count squares"},
    {"convex=every_step", "profiles", "the refits would leave the convex parameters"},
    {"convex=afterwards", "profiles", "the refits would leave the convex parameters"}};

std::size_t limits_of(const json& model) {
  const auto found = model.find("limits");
  return found != model.end() && found->is_array() ? found->size() : 0;
}

/// The first term that is simulated on equal cells in any case; "" if none is.
std::string on_springs(const json& model) {
  const auto terms = model.find("terms");
  if (terms == model.end() || !terms->is_array()) return "";
  for (const json& term : *terms) {
    if (!term.is_object() || !term.contains("strain") || !term["strain"].is_object()) continue;
    const auto name = term["strain"].find("name");
    if (name == term["strain"].end() || !name->is_string()) continue;
    const std::string& strain = name->get_ref<const std::string&>();
    if (strain.starts_with("spring_") || strain.starts_with("ring2_"))
      return term.value("id", json()).dump();
  }
  return "";
}

bool holds_out(const json& options) {
  if (const auto list = options.find("held_out"); list != options.end() && !list->empty())
    return true;
  const auto roles = options.find("roles");
  return roles != options.end() && roles->is_object() &&
         std::any_of(roles->begin(), roles->end(),
                     [](const json& role) { return role == "evaluation"; });
}

/// The first term that is not convex by construction; "" if all are.
std::string not_convex(const json& model) {
  const auto terms = model.find("terms");
  if (terms == model.end() || !terms->is_array()) return "";
  for (const json& term : *terms) {
    if (!term.is_object() || !term.contains("law") || !term["law"].is_object()) continue;
    const auto law = term["law"].find("name");
    if (law == term["law"].end() || !law->is_string()) continue;
    if (!is_made_convex(law->get_ref<const std::string&>()))
      return term.value("id", json()).dump() + " has the law " + law->dump();
  }
  return "";
}

}  // namespace

bool is_made_convex(std::string_view law) {
  constexpr std::array<std::string_view, 4> kLaws = {"linear", "hermite_stiffness",
                                                     "bspline_stiffness", "convex_spline"};
  return std::find(kLaws.begin(), kLaws.end(), law) != kLaws.end();
}

Expected<void> check_fit_requests(const json& model, const json& options) {
  if (!options.is_object() || !model.is_object()) return {};
  for (const auto& [one, other, why] : kApart)
    if (is_asked(options, one) && is_asked(options, other))
      return bad_input("options." + std::string(one) + " and options." + other +
                       " do not go together: " + why);
  if (is_asked(options, "samples") && !holds_out(options))
    return bad_input(
        "options.samples: needs a capture that is held out, to tell when to stop adding them");
  if (is_asked(options, "samples") && limits_of(model) > 0)
    return bad_input("options.samples: samples are not made of a model with energy limits");
  if (is_asked(options, "limits") && limits_of(model) != 1)
    return bad_input("options.limits: the model has " + std::to_string(limits_of(model)) +
                     " energy limits, and must have one");
  if (is_asked(options, "without_grid_error"))
    if (const std::string term = on_springs(model); !term.empty())
      return bad_input("options.without_grid_error: the term " + term +
                       " is of springs, which are another material on a finer grid");
  const auto held = options.find("hold_unseen");
  if (held != options.end() && *held != "none" && !held->is_null() &&
      options.value("staged", json(true)) == false)
    return bad_input(
        "options.hold_unseen: only a fit in stages has one that tells whether it is seen");
  if (is_asked(options, "convex=by_construction"))
    if (const std::string term = not_convex(model); !term.empty())
      return bad_input("options.convex: the term " + term +
                       ", which is not convex by construction");
  return {};
}

}  // namespace tenter::jobs
