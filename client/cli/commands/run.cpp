// SPDX-License-Identifier: Apache-2.0
// fit, simulate, diagnose: three kinds of one job (client/cli/job_run.h).
#include <CLI/CLI.hpp>
#include <memory>

#include "client/cli/commands/commands.h"
#include "client/cli/job_run.h"
#include "client/cli/output.h"
#include "client/cli/scene_run.h"
#include "client/cli/sheet/fit_options.h"

namespace tenter::cli {

namespace {

constexpr const char* kUsualModel = "stvk_diagonal";

constexpr const char* kSimulateFooter =
    "Of captures: nothing is fitted; the model's own values predict every frame, and the error "
    "against the measurement is shown. `tenter residuals` prints the predictions.\n"
    "\n"
    "Of a scene (--scene): a mesh of cloth or of a solid is held, pulled and loaded as the scene "
    "says, and brought to rest frame after frame (net force below 1e-5 N unless the scene says "
    "otherwise). With -o DIR the folder gets frames.h5 (positions in m, reactions in N and N m on "
    "every clip, energies in J and strains per term, for every frame), frames.xdmf (open this one "
    "in ParaView) and result.json. --set TERM.PARAMETER=VALUE changes the model, in the units "
    "that `tenter model show` prints. A scene document has lengths in m, masses in kg, forces in "
    "N, turns in rad; `tenter scene show hanging_square` prints one to begin with.\n"
    "\n"
    "Exit code 2: the scene or the model is not well formed. 7: the job failed (nodes that are "
    "not there, no equilibrium at the start), or a frame has no equilibrium; the frames before "
    "it are delivered all the same.\n"
    "EXAMPLES\n"
    "    tenter simulate pull.h5 --model fitted.json\n"
    "    tenter residuals last --format csv > predictions.csv\n"
    "    tenter simulate --scene hanging_square -o hanging\n"
    "    tenter simulate --scene mine.scene.json --model cloth_stvk --set weft.k=80 -o mine\n"
    "    tenter simulate --scene unrolling_felt --report felt.html\n"
    "    tenter --json simulate --scene picture_frame | jq '.frames[-1].reactions'\n";

/// --set KEY=VALUE: VALUE is JSON, or text where it is not.
Expected<void> set_option(nlohmann::json& options, const std::string& assignment) {
  const std::size_t at = assignment.find('=');
  if (at == std::string::npos || at == 0)
    return bad_input("--set " + assignment + ": must be KEY=VALUE");
  const std::string key = assignment.substr(0, at);
  const std::string text = assignment.substr(at + 1);
  nlohmann::json value = nlohmann::json::parse(text, nullptr, false);
  options[key] = value.is_discarded() ? nlohmann::json(text) : value;
  return {};
}

struct Draft {
  JobRun run;
  long long seed = -1;
  std::string leave_out;
  int max_effects = -1;
  std::vector<std::string> sets;
  std::string protocol;  ///< fit: a test with a way of its own
  std::string scene;     ///< simulate: instead of captures
  std::string figure;    ///< simulate --scene
};

Expected<void> start_scene(Context& context, const Draft& draft) {
  const JobRun& run = draft.run;
  if (!run.captures.empty())
    return bad_input("a scene is simulated on its own: give either captures or --scene");
  if (!run.save_model.empty()) return bad_input("--save-model is for captures, not for a scene");
  if (draft.seed >= 0)
    return bad_input("--seed is for captures; the seed of a scene is in its document");
  return run_scene(context, {draft.scene, run.model, draft.sets, run.submit, run.detach,
                             draft.figure, run.report, run.output});
}

Expected<void> start(Context& context, Draft& draft) {
  if (!draft.scene.empty()) return start_scene(context, draft);
  if (!draft.figure.empty()) return bad_input("--figure is for a scene (--scene)");
  if (draft.run.captures.empty())
    return bad_input("what is to be simulated: captures, or a scene (--scene)?");
  if (!draft.protocol.empty()) {
    if (!draft.run.model.empty() || !draft.leave_out.empty())
      return bad_input("--protocol has its own model, and leaves nothing out");
    draft.run.options["protocol"] = draft.protocol;
  }
  if (draft.run.model.empty() && draft.run.continues.empty()) draft.run.model = kUsualModel;
  nlohmann::json& options = draft.run.options;
  if (draft.seed >= 0) options["seed"] = draft.seed;
  if (!draft.leave_out.empty()) options["leave_out"] = draft.leave_out;
  if (draft.max_effects >= 0) options["max_effects"] = draft.max_effects;
  for (const std::string& assignment : draft.sets)
    if (auto set = set_option(options, assignment); !set) return set;
  return run_job(context, draft.run);
}

CLI::App* add_run(CLI::App& app, Context& context, const char* kind, const char* words,
                  const char* footer, const std::shared_ptr<Draft>& draft) {
  draft->run.kind = kind;
  CLI::App* command = app.add_subcommand(kind, words);
  command->footer(footer);
  command
      ->add_option("CAPTURE", draft->run.captures,
                   "Capture files (.h5), sent to the server unless it has them, or the SHA-256 of "
                   "captures on the server (6 digits or more).")
      ->required();
  command
      ->add_option("--model", draft->run.model,
                   "Name of a shipped model, or a model file. Default: stvk_diagonal.")
      ->type_name("NAME_OR_FILE");
  command->add_option("--seed", draft->seed, "Seed of everything random in the job.")
      ->type_name("N")
      ->check(CLI::Range(0LL, 4294967295LL));
  command
      ->add_option("--set", draft->sets,
                   "Any other option of the job as KEY=VALUE; may be repeated.")
      ->type_name("KEY=VALUE")
      ->expected(1)
      ->take_all();
  command->add_flag("--detach", draft->run.detach, "Do not wait for the job; print its number.");
  command
      ->add_option("-o,--output", draft->run.output,
                   "Keep the result document (JSON) in this file.")
      ->type_name("FILE");
  command
      ->add_option("--report", draft->run.report, "Write the report, one HTML page, to this file.")
      ->type_name("FILE");
  command
      ->add_option("--save-model", draft->run.save_model,
                   "Write the resulting model document to this file.")
      ->type_name("FILE");
  add_submit_options(*command, draft->run.submit);
  command->callback([&context, draft] {
    context.command = [&context, draft] { return start(context, *draft); };
  });
  return command;
}

void add_leave_out(CLI::App* command, const std::shared_ptr<Draft>& draft) {
  command
      ->add_option(
          "--leave-out", draft->leave_out,
          "What is left out in turn to measure the error on what a fit never saw: "
          "protocols, repeats, runs or blocks. Default: the hardest that the captures allow.")
      ->type_name("WHAT")
      ->check(CLI::IsMember({"protocols", "repeats", "runs", "blocks"}));
}

}  // namespace

void add_diagnose(CLI::App& app, Context& context) {
  auto draft = std::make_shared<Draft>();
  CLI::App* command = add_run(
      app, context, "diagnose",
      "find what a model gets wrong on captures, why, and which model would be right",
      "Fits the model, compares what it misses with the noise, screens every known cause, refits "
      "with the best ones, "
      "and tests the gain on captures that the fit never saw. Prints one verdict per finding: "
      "NAMED, AMBIGUOUS (with the "
      "capture that would decide: the pull that tells its causes apart best within --set "
      "rig_strain=, rig_N_m=, rig_rate_per_s= and rig_seconds=, by default 1.5 times what the "
      "captures reached, their fastest rate and an hour), SENSOR, NOT EXCITED, UNEXPLAINED, "
      "NUMERICAL or NOTHING FOUND. "
      "Several captures, of one "
      "specimen or of several of one material, are diagnosed together.\n"
      "\n"
      "Captures of a deforming sheet (tracked points, clip forces) are diagnosed on a mesh: give a "
      "model of cloth, and with --hold-out the captures that no fit shall see. Where something is "
      "missed, the grid is compared with one of half its spacing before any material is blamed; "
      "--set without_grid_error=false leaves that out.\n"
      "\n"
      "Ctrl-C stops waiting, the job goes on. The same job again is answered from the store.\n"
      "\n"
      "With --json the object has verdicts (each: verdict, effect, size, interval, p_value, "
      "alternatives, "
      "next_protocol), noise_floor, error_before, error_after, held_out_before, held_out_after, "
      "unexplained_share, "
      "captures, parameters, path, screen, checklist, model and job_id.\n"
      "EXAMPLES\n"
      "    tenter diagnose pull.h5 --report report.html\n"
      "    tenter diagnose warp.h5 weft.h5 shear.h5 --model soft_constraints\n"
      "    tenter diagnose u.h5 v.h5 shear.h5 corner.h5 --model cloth_stvk --hold-out corner.h5\n"
      "    tenter --json diagnose pull.h5 | jq -r '.verdicts[] | [.verdict, .effect] | @tsv'\n"
      "    tenter diagnose 3fa9c1 --detach --priority 20\n"
      "    tenter diagnose two_rates.h5 --continue last\n",
      draft);
  add_leave_out(command, draft);
  command
      ->add_option("--continue", draft->run.continues,
                   "Go on from this diagnosis with the captures it asked for: its captures, its "
                   "model and its options count as given. Where the new captures have time, old "
                   "ones without time are set aside, and named.")
      ->type_name("JOB");
  command
      ->add_option("--max-effects", draft->max_effects,
                   "At most so many effects are added to the model.")
      ->type_name("N")
      ->check(CLI::Range(0, 20));
  auto sheet = std::make_shared<SheetFitDraft>();
  add_sheet_reading_options(*command, *sheet);
  draft->run.complete_options = [sheet, names = &draft->run.captures](
                                    const std::vector<std::string>& ids, nlohmann::json& options) {
    return complete_options(*sheet, *names, ids, options);
  };
}

void add_fit(CLI::App& app, Context& context) {
  auto draft = std::make_shared<Draft>();
  CLI::App* command = add_run(
      app, context, "fit", "fit the parameters of a model to captures",
      "Prints the error against the noise floor, and keeps the fitted model with the "
      "intervals of its parameters.\n"
      "\n"
      "Captures of a deforming sheet are fitted on a mesh, in stages: stretch, then shear, "
      "then bending, then all together (--role says what each capture is for). The fit can "
      "take long; if its worker or the server is killed it goes on after the last finished "
      "stage, with the same result. `tenter residuals last --vertices` prints what is left "
      "at the vertices.\n"
      "\n"
      "--protocol hanging-weights: one capture of weights and lengths along weft or warp; "
      "stiffness k1 + k2 eps, friction a + b eps and tau with 95 % intervals, or a word in "
      "place of a number that the data do not tell (key friction_test with --json).\n"
      "--protocol loops: load-unload loops in which weft or warp alone is strained (--set "
      "direction=weft): the same numbers. Where the captures say that the load depends on the rate "
      "of strain (it falls in a hold, or loops at two rates lose other work) this is no friction: "
      "the job is refused with the evidence in words, exit code 7.\n"
      "--protocol spiral: profiles of strips that were rolled around cylinders and unrolled, "
      "with or without cantilevers (captures of kind strip_profiles): the same numbers of "
      "bending, positive and negative sense of curvature each on its own. --protocol "
      "cantilever: cantilevers alone, stiffness only. --set samples=5: of each profile.\n"
      "EXAMPLES\n"
      "    tenter fit pull.h5 --model stvk_orthotropic_spline --save-model fitted.json\n"
      "    tenter --json fit pull.h5 | jq '.parameters'\n"
      "    tenter fit warp.h5 --protocol hanging-weights --report friction.html\n"
      "    tenter fit slow.h5 fast.h5 --protocol loops --set direction=warp\n"
      "    tenter fit spirals.h5 cantilevers.h5 --protocol spiral --report bending.html\n"
      "    tenter fit u.h5 v.h5 --role u.h5=stretch_u --role v.h5=stretch_v --report "
      "fit.html\n",
      draft);
  command
      ->add_option("--protocol", draft->protocol,
                   "How the captures were made, where that has a fit of its own.")
      ->type_name("NAME")
      ->check(CLI::IsMember({"hanging-weights", "loops", "spiral", "cantilever"}));
  auto sheet = std::make_shared<SheetFitDraft>();
  add_sheet_fit_options(*command, *sheet);
  draft->run.complete_options = [sheet, names = &draft->run.captures](
                                    const std::vector<std::string>& ids, nlohmann::json& options) {
    return complete_options(*sheet, *names, ids, options);
  };
  add_leave_out(command, draft);
}

void add_simulate(CLI::App& app, Context& context) {
  auto draft = std::make_shared<Draft>();
  CLI::App* command =
      add_run(app, context, "simulate",
              "run a model as it is: along the paths of captures, or on the mesh of a scene",
              kSimulateFooter, draft);
  command->get_option("CAPTURE")->required(false);
  command
      ->add_option("--scene", draft->scene,
                   "A shipped scene (`tenter scene list`) or a scene file, instead of captures. "
                   "The model is then by default the scene's own, or cloth_stvk (of bodies: "
                   "solid_neo_hookean), "
                   "--output is a folder and --set changes the model.")
      ->type_name("NAME_OR_FILE");
  command
      ->add_option("--figure", draft->figure,
                   "Of a scene with an experiment: its pictures, numbers and curves, of all of its "
                   "runs, as an SVG file.")
      ->type_name("FILE");
}

}  // namespace tenter::cli
