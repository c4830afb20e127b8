// SPDX-License-Identifier: Apache-2.0
#include "client/cli/sheet/fit_options.h"

#include <CLI/CLI.hpp>
#include <cmath>
#include <filesystem>

namespace tenter::cli {

namespace {

/// The id of the capture that the user means: as it was named, by its file's name, or by the
/// beginning of its SHA-256.
Expected<std::string> id_of(const std::string& option, const std::string& name,
                            const std::vector<std::string>& names,
                            const std::vector<std::string>& ids) {
  constexpr std::size_t kShortest = 6;
  std::string found;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const bool is_meant = name == names[i] ||
                          name == std::filesystem::path(names[i]).filename().string() ||
                          (name.size() >= kShortest && ids[i].starts_with(name));
    if (!is_meant || found == ids[i]) continue;
    if (!found.empty()) return bad_input(option + " " + name + ": means more than one capture");
    found = ids[i];
  }
  if (found.empty()) return bad_input(option + " " + name + ": is none of the captures given");
  return found;
}

/// CAPTURE=VALUE, split at the last sign: file names may hold one.
Expected<std::pair<std::string, std::string>> split(const std::string& option,
                                                    const std::string& given) {
  const std::size_t at = given.rfind('=');
  if (at == std::string::npos || at == 0 || at + 1 == given.size())
    return bad_input(option + " " + given + ": must be CAPTURE=VALUE");
  return std::pair{given.substr(0, at), given.substr(at + 1)};
}

/// Every "CAPTURE=VALUE" of `given`, with the capture's id.
template <class Take>
Expected<void> each(const char* option, const std::vector<std::string>& given,
                    const std::vector<std::string>& names, const std::vector<std::string>& ids,
                    const Take& take) {
  for (const std::string& entry : given) {
    const auto parts = split(option, entry);
    if (!parts) return tl::unexpected(parts.error());
    const auto id = id_of(option, parts->first, names, ids);
    if (!id) return tl::unexpected(id.error());
    if (auto taken = take(*id, parts->second); !taken)
      return bad_input(std::string(option) + " " + entry + ": " + taken.error().message);
  }
  return {};
}

/// What is done after the stages where it is asked for. The server says which go together.
void add_requests(CLI::App& command, SheetFitDraft& draft) {
  command
      .add_option(
          "--starts", draft.starts,
          "Sheets: fit from so many random starts as well, and say how many end in the best "
          "basin (the waterfall). --seed chooses them.")
      ->type_name("N")
      ->check(CLI::Range(0, 1000));
  command
      .add_option("--convex", draft.convex,
                  "Sheets: an energy that is convex, by projecting every step of a last fit "
                  "(every_step), the fitted values (afterwards), or by curves that cannot be "
                  "anything else (by_construction).")
      ->type_name("WORD")
      ->check(CLI::IsMember({"every_step", "afterwards", "by_construction"}));
  command
      .add_option("--samples", draft.samples,
                  "Sheets: let stiffness differ over the material, at no more than so many samples "
                  "of 4 x 4, added until the held-out captures gain nothing more.")
      ->type_name("N")
      ->check(CLI::Range(0, 16));
  command.add_flag("--limits", draft.limits,
                   "Sheets: fit the largest energy density of the model's limit as well.");
  command
      .add_option("--hold-unseen", draft.hold_unseen,
                  "Sheets: hold diagonal bending where the strips do not tell it: at what stands "
                  "in for it (stand_in), at the model's value (start), at this one in N m, or "
                  "not at all (none). Default: stand_in.")
      ->type_name("WORD|NUMBER");
}

}  // namespace

void add_sheet_reading_options(CLI::App& command, SheetFitDraft& draft) {
  command
      .add_option("--held-out,--hold-out", draft.held_out,
                  "Sheets: compare this capture at the end, but do not fit to it; may be repeated.")
      ->type_name("CAPTURE")
      ->expected(1)
      ->take_all();
  command
      .add_option("--resolution", draft.resolution,
                  "Sheets: nodes on a side of the simulated sheet, were it a square of the same "
                  "area; its cells are squares, nearly. Default: 25.")
      ->type_name("N")
      ->check(CLI::Range(3, 201));
  command
      .add_option(
          "--grid", draft.grid,
          "Sheets: lines of the simulated sheet through the ends of clips and dense towards "
          "their corners (graded), or everywhere alike (equal). Springs are always on equal "
          "cells. Default: graded.")
      ->type_name("WORD")
      ->check(CLI::IsMember({"graded", "equal"}));
  command
      .add_option("--points", draft.points,
                  "Sheets: compare at most so many vertices of a capture. Default: all.")
      ->type_name("N")
      ->check(CLI::NonNegativeNumber);
  command
      .add_option("--frames", draft.frames,
                  "Sheets: compare at most so many frames of a capture, spread evenly. Default: "
                  "all.")
      ->type_name("N")
      ->check(CLI::NonNegativeNumber);
  command.add_flag(
      "--without-grid-error", draft.without_grid_error,
      "Sheets: estimate what the simulated grid is wrong by, from one of half its spacing, "
      "take it off and fit again: curves of the cloth instead of those that suit this grid.");
}

void add_sheet_fit_options(CLI::App& command, SheetFitDraft& draft) {
  add_sheet_reading_options(command, draft);
  command
      .add_option("--role", draft.roles,
                  "Sheets: what a capture is for: stretch_u, stretch_v, shear, bend_u, bend_v, or "
                  "evaluation (held out); one for each capture.")
      ->type_name("CAPTURE=ROLE")
      ->expected(1)
      ->take_all();
  command
      .add_option("--weight", draft.weights, "Sheets: weight of a capture in the cost. Default: 1.")
      ->type_name("CAPTURE=NUMBER")
      ->expected(1)
      ->take_all();
  command
      .add_option("--max-control-points", draft.max_control_points,
                  "Sheets: of a stiffness curve. Default: 5.")
      ->type_name("N")
      ->check(CLI::Range(1, 12));
  command
      .add_option("--knots", draft.knots,
                  "Sheets: control points of a stiffness curve at even strains (even), or where "
                  "what is left of the errors asks for them (data). Default: even.")
      ->type_name("WORD")
      ->check(CLI::IsMember({"even", "data"}));
  command.add_flag("--keep-points", draft.keep_points,
                   "Sheets, with --at-once: fit curves with the control points that the model "
                   "gives, instead of beginning with one.");
  command
      .add_option(
          "--start", draft.start,
          "Sheets: begin with what the measured forces say (equation_gap), or with the model's own "
          "values (model). Default: equation_gap.")
      ->type_name("WORD")
      ->check(CLI::IsMember({"equation_gap", "model"}));
  command
      .add_option(
          "--channels", draft.channels,
          "Sheets: compare as the thesis does, forces of stretch and shear and positions of "
          "bending (thesis), or all. Default: thesis.")
      ->type_name("WORD")
      ->check(CLI::IsMember({"thesis", "all"}));
  command.add_option("--robust", draft.robust, "Sheets: loss against outliers. Default: none.")
      ->type_name("WORD")
      ->check(CLI::IsMember({"none", "huber", "cauchy"}));
  command.add_flag("--at-once", draft.at_once,
                   "Sheets: fit all curves to all captures in one stage, instead of in stages.");
  command.add_flag("--profiles", draft.profiles,
                   "Sheets: say of each parameter how well the captures determine it, by refits "
                   "(profile likelihood). Takes longer than the fit.");
  add_requests(command, draft);
}

Expected<void> complete_options(const SheetFitDraft& draft, const std::vector<std::string>& names,
                                const std::vector<std::string>& ids, nlohmann::json& options) {
  auto roles = each("--role", draft.roles, names, ids,
                    [&](const std::string& id, const std::string& role) -> Expected<void> {
                      options["roles"][id] = role;
                      return {};
                    });
  if (!roles) return roles;
  auto weights = each("--weight", draft.weights, names, ids,
                      [&](const std::string& id, const std::string& text) -> Expected<void> {
                        const auto value = nlohmann::json::parse(text, nullptr, false);
                        if (!value.is_number()) return bad_input("the weight is no number");
                        options["weights"][id] = value;
                        return {};
                      });
  if (!weights) return weights;
  for (const std::string& name : draft.held_out) {
    const auto id = id_of("--held-out", name, names, ids);
    if (!id) return tl::unexpected(id.error());
    options["held_out"].push_back(*id);
  }
  if (draft.resolution >= 0) options["resolution"] = draft.resolution;
  if (!draft.grid.empty()) options["grid"] = draft.grid;
  if (draft.points >= 0) options["points"] = draft.points;
  if (draft.frames >= 0) options["frames"] = draft.frames;
  if (draft.max_control_points >= 0) options["max_control_points"] = draft.max_control_points;
  if (!draft.knots.empty()) options["knots"] = draft.knots;
  if (draft.keep_points) options["keep_points"] = true;
  if (!draft.start.empty()) options["start"] = draft.start;
  if (!draft.channels.empty()) options["channels"] = draft.channels;
  if (!draft.robust.empty()) options["robust"] = draft.robust;
  if (draft.at_once) options["staged"] = false;
  if (draft.profiles) options["profiles"] = true;
  if (draft.starts >= 0) options["starts"] = draft.starts;
  if (!draft.convex.empty()) options["convex"] = draft.convex;
  if (draft.samples >= 0) options["samples"] = draft.samples;
  if (draft.limits) options["limits"] = true;
  if (draft.without_grid_error) options["without_grid_error"] = true;
  if (!draft.hold_unseen.empty()) {
    const auto value = nlohmann::json::parse(draft.hold_unseen, nullptr, false);
    options["hold_unseen"] = value.is_number() ? value : nlohmann::json(draft.hold_unseen);
  }
  return {};
}

}  // namespace tenter::cli
