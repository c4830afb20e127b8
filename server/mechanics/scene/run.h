// SPDX-License-Identifier: GPL-3.0-or-later
// Walks a scene: the equilibrium of the start, then of every frame of the protocol, each from the
// one before. A scene with dynamics moves instead (dynamics/walk.h): its frames are instants.
//
//   auto run = SceneRun::make(scene, model);
//   if (!run) return tl::unexpected(run.error());
//   auto end = run->walk({.on_frame = [&](const SceneFrame& f) { keep(f); },
//                         .go_on = [&](int frame, int) { return !stop; }});
//   if (end && end->how != SceneEnd::How::complete) log(end->reason);
//
// A frame starts from the last one's state with its factor (equilibrium.h predicts); where that
// fails, from the state alone; where that fails, from the equilibrium half a step further, and so
// on down to 1/2^most_halvings of the step. What cannot be reached ends the walk: frames before it
// are good and have been handed out. A frame that is handed out is in equilibrium, and holds finite
// numbers only.
//
// Laws that remember their path (friction, plastic slip) do so from equilibrium to equilibrium,
// those of halved steps too; the start counts as one straight pull from rest, unless the scene says
// that the material remembers it: then it was brought to its start before anything else, with work
// that is not counted.
//
// A run keeps its solver and scratch; it belongs to one thread at a time. The same scene and model
// give the same bytes.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/base/error.h"
#include "common/model/model.h"
#include "common/scene/scene.h"
#include "server/mechanics/assembly/term_strains.h"
#include "server/mechanics/dynamics/walk.h"
#include "server/mechanics/equilibrium/equilibrium.h"
#include "server/mechanics/scene/body.h"
#include "server/mechanics/scene/levels.h"
#include "server/mechanics/scene/set_up.h"

namespace tenter::mechanics {

/// Of a frame of a motion.
struct SceneInstant {
  double time_s = 0.0;
  double kinetic_J = 0.0;
  double error_m = 0.0;          ///< estimates of all steps since the frame before, summed
  Eigen::VectorXd velocity_m_s;  ///< 3 a node
};

struct SceneFrame {
  int number = 0;      ///< 0: the start
  int phase = -1;      ///< -1: the start
  double share = 1.0;  ///< of the phase that is done
  State state;
  Levels levels;
  std::vector<Wrench> reactions;  ///< on every clip, about its position: loads.h, reaction()
  /// The potential: material, loads, contact. In motion: loads and what the material stores.
  double energy_J = 0.0;
  /// Of the material, as the model's terms; of one that remembers its path, the work that it took
  /// along it, stored or lost.
  Eigen::VectorXd term_energies_J;
  std::vector<TermStrains> strains;
  Stability stability = Stability::not_checked;
  double net_force_N = 0.0;
  double contact_violation_m = 0.0;
  double limit_violation = 0.0;  ///< of the model's energy limits, in parts of psi_max
  int steps = 1;                 ///< equilibria on the way here; 1: the step was not cut
  int iterations = 0;
  int factorisations = 0;
  std::optional<SceneInstant> instant;  ///< of scenes with dynamics
};

struct SceneHooks {
  std::function<void(const SceneFrame&)> on_frame;
  /// Asked before every equilibrium or time step with the frame's number and its iterations so far;
  /// false ends the walk.
  std::function<bool(int frame, int iterations)> go_on;
};

struct SceneEnd {
  enum class How {
    complete,
    failed,  ///< a frame has no equilibrium that could be reached, or a shortest step fails
    stopped  ///< by go_on
  };
  How how = How::complete;
  int frames = 0;      ///< handed out
  std::string reason;  ///< one sentence, where it failed
};

class SceneRun {
 public:
  /// bad_input: the scene or the model does not fit the mesh; messages begin with the path of the
  /// scene's key or name the model's term. The scene has passed validate().
  static Expected<SceneRun> make(const scene::Scene& scene, const model::Model& model);

  const scene::Scene& scene() const { return scene_; }
  const SceneBody& body() const { return body_; }
  const SetUp& set_up() const { return set_up_; }
  /// As it is run: with the damping that the scene asks for.
  const model::Model& model() const { return description_; }

  Expected<SceneEnd> walk(const SceneHooks& hooks);

 private:
  SceneRun() = default;
  /// One equilibrium; `state` is changed only where it was found.
  Expected<bool> solve(const Levels& levels, bool is_near, State& state, SceneFrame& frame);
  /// The start: at once, else with its loads coming in steps.
  Expected<bool> begin(const Levels& levels, const SceneHooks& hooks, State& state,
                       SceneFrame& frame);
  /// From the state that belongs to levels(from) to that of levels(to).
  Expected<bool> advance(const std::function<Levels(double)>& levels, double from, double to,
                         const SceneHooks& hooks, State& state, SceneFrame& frame);
  /// Nothing remembered yet but, where the scene says so, the start as it is placed.
  bool begin_history(const State& start);
  /// Takes the history from `from` to the equilibrium at `to`; false where it leaves the range of
  /// numbers.
  bool remember(const State& from, const State& to);
  Expected<bool> finish(const Levels& levels, const State& state, SceneFrame& frame);
  /// Of every frame: where it is, what holds it (`by_node`: slope of the energy over all nodes),
  /// its strains and energies. False where those are no numbers.
  bool tell(const Levels& levels, const State& state, Eigen::VectorXd by_node, SceneFrame& frame);
  /// How well the last equilibrium is one.
  void tell_rest(SceneFrame& frame) const;

  // in motion: walk_in_time.cpp
  Expected<SceneEnd> walk_in_time(const SceneHooks& hooks);
  StepInput input_at(const Levels& levels) const;
  /// The work of a step that was taken, of terms that remember.
  bool count_work(const Motion& motion);
  bool finish_instant(const Levels& levels, const Motion& motion, const Eigen::VectorXd& by_node,
                      SceneFrame& frame);

  scene::Scene scene_;
  SceneBody body_;
  SetUp set_up_;
  model::Model description_;
  std::unique_ptr<const MeshModel> model_;
  Eigen::VectorXd parameters_;
  EquilibriumOptions options_;
  std::unique_ptr<EquilibriumSolver> solver_;
  std::string failure_;  ///< of the last attempt
  bool was_stopped_ = false;
  EquilibriumResult last_;
  History history_;
  std::vector<int> remembering_;  ///< terms
  Eigen::VectorXd work_J_;        ///< of those, along the path so far
  bool is_new_ = true;            ///< not yet strained
};

}  // namespace tenter::mechanics
