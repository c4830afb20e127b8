// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/staged/start/equation_gap.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>

#include "server/estimation/least_squares/bounded_least_squares.h"
#include "server/estimation/sequences/observations.h"
#include "server/estimation/staged/resting_frames.h"
#include "server/estimation/staged/start/measured_shape.h"

namespace tenter::estimation {
namespace {

using mechanics::MeshModel;
using mechanics::PotentialValue;
using mechanics::State;

/// One sequence with the frames that are used and their shapes.
struct Measured {
  const Sequence* sequence = nullptr;
  GapRows rows = GapRows::all;
  std::unique_ptr<MeshModel> model;
  std::unique_ptr<MeasuredShape> shape;
  std::unique_ptr<Observations> channels;
  std::vector<std::size_t> frames;
  std::vector<State> filled;   ///< as measured
  std::vector<State> settled;  ///< by the last model
};

/// What a model remembers where a frame's step starts, and how that changes with its parameters.
struct Past {
  mechanics::History history;
  Eigen::MatrixXd by_parameter, shape_stays;
  std::vector<Eigen::Index> all_parameters;

  explicit Past(const MeshModel& model)
      : history(model.never_strained()),
        by_parameter(Eigen::MatrixXd::Zero(model.history_count(), model.parameter_count())),
        all_parameters(static_cast<std::size_t>(model.parameter_count())) {
    std::iota(all_parameters.begin(), all_parameters.end(), Eigen::Index{0});
  }

  /// To the end of the step to a shape.
  bool go_on(const MeshModel& model, const Eigen::VectorXd& x, const Eigen::VectorXd& parameters) {
    if (model.history_count() == 0) return true;
    shape_stays.setZero(x.size(), model.parameter_count());
    return model.carry_history_change(x, parameters, history, shape_stays, all_parameters,
                                      by_parameter) == mechanics::AssemblyStatus::ok &&
           model.end_of_step(x, parameters, history, history.state) ==
               mechanics::AssemblyStatus::ok;
  }
};

/// The rows of one frame, linear in the moving free numbers: A dq = b, whitened.
class FrameRows {
 public:
  FrameRows(Measured& measured, std::size_t frame, const Eigen::VectorXd& parameters,
            const Eigen::MatrixXd& moving, const Past& past)
      : measured_(measured), frame_(frame), parameters_(parameters), moving_(moving), past_(past) {}

  /// False where the stiffness cannot be factored.
  bool find(const State& state) {
    const mechanics::Loads loads = measured_.shape->loads(frame_);
    const mechanics::Contact no_contact;
    MeasuredShape::Site& site = measured_.shape->site(frame_);
    const mechanics::Potential potential(*measured_.model, parameters_,
                                         measured_.shape->boundary(frame_), *site.unknowns, loads,
                                         no_contact, nullptr, &past_.history);
    if (!factor(potential, *site.factor, state)) return false;
    Eigen::MatrixXd by_parameter;
    const MeshModel& model = *measured_.model;
    if (model.gradient_by_parameter(state.x, parameters_, by_parameter, nullptr, &past_.history) !=
            mechanics::AssemblyStatus::ok ||
        model.add_gradient_by_history(state.x, parameters_, past_.history, past_.by_parameter,
                                      by_parameter) != mechanics::AssemblyStatus::ok)
      return false;
    gap_by_q_ = by_parameter * moving_;
    // the way to equilibrium, at q_0 (column 0) and its change with q
    const Eigen::Index columns = gap_by_q_.cols() + 1;
    way_.x.resize(state.x.size(), columns);
    way_.gradient.resize(state.x.size(), columns);
    Eigen::VectorXd force, by_unknown, moved;
    for (Eigen::Index c = 0; c < columns; ++c) {
      // at the shape itself the gap is part of the state: only what the way adds is a change
      force.setZero(state.x.size());
      by_unknown = value_.by_unknown;  // cords and weight of free clips are in it
      if (c > 0) {
        force = gap_by_q_.col(c - 1);
        site.unknowns->restrict_to(state, force, by_unknown);
      }
      site.factor->solve(by_unknown.data(), by_unknown.data(), 1);
      by_unknown = -by_unknown;
      site.unknowns->expand(state, by_unknown, moved);
      value_.node_stiffness.multiply_add(moved.data(), force.data());
      way_.x.col(c) = moved;
      way_.gradient.col(c) = force;
    }
    write(state);
    return true;
  }

  const Eigen::MatrixXd& a() const { return a_; }
  const Eigen::VectorXd& b() const { return b_; }

 private:
  bool factor(const mechanics::Potential& potential, mechanics::SparseFactor& sparse,
              const State& state) {
    for (const double share : {0.0, 1.0}) {
      if (!potential.evaluate_with_stiffness(state, share, value_)) return false;
      if (sparse.factorize(value_.stiffness.data()) == mechanics::FactorStatus::ok) return true;
    }
    return false;
  }

  static bool counts(ObservationKind kind, GapRows rows) {
    return rows == GapRows::all || (rows == GapRows::forces && kind == ObservationKind::force) ||
           (rows == GapRows::positions && kind == ObservationKind::position);
  }

  /// Values at the shape, moved by the way to equilibrium (column 0) and its change with q.
  void write(const State& state) {
    const Sequence& sequence = *measured_.sequence;
    const Observations& channels = *measured_.channels;
    a_.resize(channels.count(), moving_.cols());
    b_.resize(channels.count());
    Eigen::Index used = 0;
    Observation seen;
    Eigen::RowVectorXd change;
    for (int c = 0; c < channels.count(); ++c) {
      const double measured = channels.measured(sequence.frames[frame_], c);
      if (std::isnan(measured) || !counts(channels.kind(sequence, c), measured_.rows)) continue;
      channels.observe(sequence, c, {measured_.shape->boundary(frame_), state, value_.by_node},
                       seen);
      change_of(seen, way_, change);
      const double sigma = channels.sigma(sequence, c);
      b_[used] = (measured - seen.value - change[0]) / sigma;
      a_.row(used++) = change.tail(change.size() - 1) / sigma;
    }
    a_.conservativeResize(used, Eigen::NoChange);
    b_.conservativeResize(used);
  }

  Measured& measured_;
  std::size_t frame_;
  const Eigen::VectorXd& parameters_;
  const Eigen::MatrixXd& moving_;
  const Past& past_;
  PotentialValue value_;
  Eigen::MatrixXd gap_by_q_, a_;
  Eigen::VectorXd b_;
  mechanics::Sensitivity way_;
};

class Gap {
 public:
  Gap(const ParameterTies& ties, const GapOptions& options, std::vector<Measured> measured)
      : ties_(ties), options_(options), measured_(std::move(measured)), q_(ties.values()) {
    for (std::size_t k = 0; k < ties.free.size(); ++k) {
      const model::Parameter& p = ties.free[k];
      if (p.fixed) continue;
      moving_.push_back(static_cast<Eigen::Index>(k));
      q_[static_cast<Eigen::Index>(k)] =
          std::clamp(p.value, p.lower.value_or(-kInfinity), p.upper.value_or(kInfinity));
    }
    map_ = ties.map(Eigen::indexing::all, moving_);
  }

  Expected<GapResult> run() {
    if (moving_.empty()) return fail(ErrorKind::refused, "no parameter is free");
    for (Measured& m : measured_) fill(m);
    for (int round = 1; round <= options_.most_rounds; ++round) {
      const Eigen::VectorXd before = q_;
      if (!take_round(round == options_.most_rounds)) break;
      result_.rounds = round;
      const double change =
          ((q_ - before).array().abs() / (before.array().abs() + 1e-300)).maxCoeff();
      if (change < options_.enough) break;
    }
    if (result_.rounds == 0)
      return fail(ErrorKind::refused, "no frame has a shape at which forces are known");
    result_.q = q_;
    return std::move(result_);
  }

 private:
  static constexpr double kInfinity = std::numeric_limits<double>::infinity();

  void fill(Measured& m) {
    State state = m.sequence->start;
    std::vector<std::size_t> usable;
    for (const std::size_t f : m.frames) {
      const SequenceFrame& frame = m.sequence->frames[f];
      State filled = frame.start ? *frame.start : state;
      if (!m.shape->fill(f, filled)) {
        ++result_.frames_left_out;
        continue;
      }
      usable.push_back(f);
      state = filled;
      m.filled.push_back(std::move(filled));
    }
    m.frames = usable;
    m.settled = m.filled;
  }

  bool take_round(bool is_last) {
    const auto count = static_cast<Eigen::Index>(moving_.size());
    BoundedLeastSquares problem(static_cast<int>(count));
    const Eigen::VectorXd parameters = ties_.all(q_);
    Eigen::Index rows = 0;
    int used = 0;
    int left_out = 0;
    for (Measured& m : measured_) {
      Past past(*m.model);
      for (std::size_t k = 0; k < m.frames.size(); ++k) {
        past.history.duration_s = m.sequence->frames[m.frames[k]].duration_s;
        FrameRows frame(m, m.frames[k], parameters, map_, past);
        State settled = m.settled[k];
        if (!m.shape->settle(m.frames[k], parameters, settled, &past.history) ||
            !frame.find(settled) || !past.go_on(*m.model, settled.x, parameters)) {
          ++left_out;
          m.settled[k] = m.filled[k];
          continue;
        }
        m.settled[k] = std::move(settled);
        const double weight = std::sqrt(m.sequence->weight);
        problem.add(weight * frame.a(), weight * (frame.b() + frame.a() * q_(moving_)));
        rows += frame.b().size();
        ++used;
      }
    }
    if (rows == 0) return false;
    result_.frames = used;
    result_.frames_left_out += left_out;
    const Eigen::VectorXd start = q_(moving_);
    const auto [lower, upper] = bounds(is_last);
    const BoundedSolution solution = problem.solve(lower, upper, &start);
    result_.rank = solution.rank;
    result_.misfit = solution.residual / std::sqrt(static_cast<double>(rows));
    result_.is_at_bound.assign(ties_.free.size(), false);
    for (Eigen::Index k = 0; k < count; ++k) {
      const Eigen::Index i = moving_[static_cast<std::size_t>(k)];
      q_[i] = solution.x[k];
      const model::Parameter& p = ties_.free[static_cast<std::size_t>(i)];
      result_.is_at_bound[static_cast<std::size_t>(i)] =
          (p.lower && q_[i] <= *p.lower) || (p.upper && q_[i] >= *p.upper);
    }
    return true;
  }

  /// The parameters' own; between rounds K must not lose a stiffness, nor grow out of all measure.
  std::pair<Eigen::VectorXd, Eigen::VectorXd> bounds(bool is_last) const {
    const auto count = static_cast<Eigen::Index>(moving_.size());
    Eigen::VectorXd lower(count), upper(count);
    for (Eigen::Index k = 0; k < count; ++k) {
      const Eigen::Index i = moving_[static_cast<std::size_t>(k)];
      const model::Parameter& p = ties_.free[static_cast<std::size_t>(i)];
      lower[k] = p.lower.value_or(-kInfinity);
      upper[k] = p.upper.value_or(kInfinity);
      if (is_last || !(p.lower && *p.lower >= 0.0) || !(q_[i] > 0.0)) continue;
      lower[k] = std::max(lower[k], q_[i] / options_.widest);
      upper[k] = std::min(upper[k], q_[i] * options_.widest);
    }
    return {lower, upper};
  }

  const ParameterTies& ties_;
  const GapOptions& options_;
  std::vector<Measured> measured_;
  Eigen::VectorXd q_;
  std::vector<Eigen::Index> moving_;
  Eigen::MatrixXd map_;
  GapResult result_;
};

}  // namespace

Expected<GapResult> equation_gap(const model::Model& model, const ParameterTies& ties,
                                 const std::vector<GapSequence>& sequences,
                                 const GapOptions& options) {
  std::vector<Measured> measured;
  for (const GapSequence& given : sequences) {
    Measured m;
    m.sequence = given.sequence;
    m.rows = given.rows;
    auto bound = MeshModel::make(model, given.sequence->cloth);
    if (!bound)
      return bad_input("sequence \"" + given.sequence->name + "\": " + bound.error().message);
    m.model = std::make_unique<MeshModel>(std::move(*bound));
    auto shape = MeasuredShape::make(*m.model, *given.sequence);
    if (!shape) return tl::unexpected(shape.error());
    m.channels = std::make_unique<Observations>(*given.sequence);
    m.shape = std::make_unique<MeasuredShape>(std::move(*shape));
    for (const int f :
         taken_frames(model, static_cast<int>(given.sequence->frames.size()), options.most_frames))
      m.frames.push_back(static_cast<std::size_t>(f));
    measured.push_back(std::move(m));
  }
  return Gap(ties, options, std::move(measured)).run();
}

}  // namespace tenter::estimation
