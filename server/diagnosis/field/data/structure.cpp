// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/field/data/structure.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "common/base/not_a_number.h"

namespace tenter::diagnosis {
namespace {

using estimation::ObservationKind;
using estimation::Row;
using estimation::Sequence;

constexpr int kReferences = 150;  // points whose rings of neighbours are looked at

/// Residuals of one kind of one sequence, a row a channel and a column a frame; NaN where missing.
struct Field {
  int sequence = 0;
  ObservationKind kind = ObservationKind::position;
  std::vector<int> channels;
  Eigen::MatrixXd values;
};

/// Of each sequence and channel its place among the kinds, in the order of first rows.
std::vector<std::vector<int>> places_of_channels(const std::vector<Sequence>& sequences) {
  std::vector<std::vector<int>> places;
  int next = 0;
  for (const Sequence& sequence : sequences) {
    const estimation::Observations channels(sequence);
    int known[3] = {-1, -1, -1};
    auto& of_channel = places.emplace_back();
    for (int c = 0; c < channels.count(); ++c) {
      int& place = known[static_cast<int>(channels.kind(sequence, c))];
      if (place < 0) place = next++;
      of_channel.push_back(place);
    }
  }
  return places;
}

std::vector<Field> fields_of(const std::vector<Sequence>& sequences, const std::vector<Row>& rows,
                             const Eigen::VectorXd& residuals) {
  const auto places = places_of_channels(sequences);
  std::vector<Field> fields;
  std::vector<std::vector<Eigen::Index>> line(places.size());
  for (std::size_t s = 0; s < places.size(); ++s) {
    const estimation::Observations channels(sequences[s]);
    for (std::size_t c = 0; c < places[s].size(); ++c) {
      const auto p = static_cast<std::size_t>(places[s][c]);
      if (fields.size() <= p) fields.resize(p + 1);
      fields[p].sequence = static_cast<int>(s);
      fields[p].kind = channels.kind(sequences[s], static_cast<int>(c));
      line[s].push_back(static_cast<Eigen::Index>(fields[p].channels.size()));
      fields[p].channels.push_back(static_cast<int>(c));
    }
  }
  for (Field& field : fields)
    field.values.setConstant(static_cast<Eigen::Index>(field.channels.size()),
                             static_cast<Eigen::Index>(
                                 sequences[static_cast<std::size_t>(field.sequence)].frames.size()),
                             kNaN);
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const auto s = static_cast<std::size_t>(rows[r].curve);
    const auto c = static_cast<std::size_t>(rows[r].channel);
    fields[static_cast<std::size_t>(places[s][c])].values(line[s][c], rows[r].frame) =
        residuals[static_cast<Eigen::Index>(r)];
  }
  return fields;
}

/// Mean of products of what both have, and how many there are.
struct Product {
  double sum = 0.0;
  double count = 0.0;
  void add(double a, double b) {
    if (std::isnan(a) || std::isnan(b)) return;
    sum += a * b;
    count += 1.0;
  }
  double mean() const { return count > 0.0 ? sum / count : 0.0; }
};

double power_of(const Field& field) {
  Product own;
  for (Eigen::Index k = 0; k < field.values.size(); ++k)
    own.add(field.values.data()[k], field.values.data()[k]);
  return own.mean();
}

/// Correlation of frames `lag` apart in one block.
Product in_time(const Field& field, const Sequence& sequence, Eigen::Index lag) {
  Product product;
  for (Eigen::Index f = 0; f + lag < field.values.cols(); ++f) {
    if (sequence.frames[static_cast<std::size_t>(f)].block !=
        sequence.frames[static_cast<std::size_t>(f + lag)].block)
      continue;
    for (Eigen::Index c = 0; c < field.values.rows(); ++c)
      product.add(field.values(c, f), field.values(c, f + lag));
  }
  return product;
}

/// Rings of neighbours about some points: their mean number and correlation, from the nearest on.
struct Ring {
  double members = 0.0;
  Product product;
};

std::vector<Ring> rings_of(const Field& field, const Sequence& sequence) {
  const auto points = static_cast<int>(sequence.points.size());
  if (field.kind != ObservationKind::position || points < 8) return {};
  double area = 0.0;
  Eigen::Vector2d lo = sequence.points.front().material_m;
  Eigen::Vector2d hi = lo;
  for (const auto& p : sequence.points) {
    lo = lo.cwiseMin(p.material_m);
    hi = hi.cwiseMax(p.material_m);
  }
  area = std::max(1e-12, (hi - lo).prod());
  const double width = 1.2 * std::sqrt(area / points);
  constexpr int kMostRings = 24;
  std::vector<Ring> rings(kMostRings);
  const int step = std::max(1, points / kReferences);
  int references = 0;
  for (int i = 0; i < points; i += step) {
    ++references;
    for (int j = 0; j < points; ++j) {
      if (i == j) continue;
      const double distance = (sequence.points[static_cast<std::size_t>(i)].material_m -
                               sequence.points[static_cast<std::size_t>(j)].material_m)
                                  .norm();
      const int ring = static_cast<int>(distance / width);
      if (ring >= kMostRings) continue;
      Ring& at = rings[static_cast<std::size_t>(ring)];
      at.members += 1.0;
      // field.channels of positions are all x, y, z of the points in their order
      for (int c = 0; c < 3; ++c)
        for (Eigen::Index f = 0; f < field.values.cols(); ++f)
          at.product.add(field.values(3 * i + c, f), field.values(3 * j + c, f));
    }
  }
  for (Ring& ring : rings) ring.members /= std::max(1, references);
  return rings;
}

void measure_correlation(const Field& field, const Sequence& sequence, double power, Structure& s) {
  if (!(power > 0.0)) return;
  double tau_t = 1.0;
  for (Eigen::Index lag = 1; lag < field.values.cols(); ++lag) {
    const double rho = in_time(field, sequence, lag).mean() / power;
    if (lag == 1) s.in_time = rho;
    if (!(rho > 0.0)) break;
    tau_t += 2.0 * rho;
  }
  double tau_s = 1.0;
  bool goes_on = true;
  const auto rings = rings_of(field, sequence);
  for (std::size_t k = 0; k < rings.size(); ++k) {
    if (rings[k].members == 0.0) continue;
    const double rho = rings[k].product.mean() / power;
    if (s.neighbours == 0.0) s.neighbours = rho;
    goes_on = goes_on && rho > 0.0;
    if (goes_on) tau_s += rings[k].members * rho;
  }
  s.independent = std::clamp(s.rows / (tau_t * tau_s), 1.0, static_cast<double>(s.rows));
}

/// Share of the power that every frame has alike, less what white noise has of that.
double fixed_share(const Field& field, double power) {
  double fixed = 0.0;
  double white = 0.0;
  double lines = 0.0;
  for (Eigen::Index c = 0; c < field.values.rows(); ++c) {
    double sum = 0.0;
    double n = 0.0;
    for (Eigen::Index f = 0; f < field.values.cols(); ++f) {
      if (std::isnan(field.values(c, f))) continue;
      sum += field.values(c, f);
      n += 1.0;
    }
    if (n < 2.0) continue;
    fixed += std::pow(sum / n, 2);
    white += power / n;
    lines += 1.0;
  }
  const double most = lines * power - white;
  return most > 0.0 ? (fixed - white) / most : 0.0;
}

/// Mean square of points near free edges over that of the others, less one.
double at_edges(const Field& field, const Sequence& sequence) {
  Eigen::Vector2d lo = sequence.cloth.mesh.material_m.rowwise().minCoeff();
  Eigen::Vector2d hi = sequence.cloth.mesh.material_m.rowwise().maxCoeff();
  const double near = 0.1 * (hi - lo).minCoeff();
  Product edge;
  Product inside;
  for (std::size_t k = 0; k < sequence.points.size(); ++k) {
    const Eigen::Vector2d& p = sequence.points[k].material_m;
    const double distance = std::min((p - lo).minCoeff(), (hi - p).minCoeff());
    for (int c = 0; c < 3; ++c)
      for (Eigen::Index f = 0; f < field.values.cols(); ++f) {
        const double x = field.values(3 * static_cast<Eigen::Index>(k) + c, f);
        (distance < near ? edge : inside).add(x, x);
      }
  }
  return edge.count > 0.0 && inside.mean() > 0.0 ? edge.mean() / inside.mean() - 1.0 : 0.0;
}

/// Share of the power that is an affine function of the measured place, one for all frames.
double with_place(const Field& field, const Sequence& sequence, double power) {
  Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
  Eigen::Matrix<double, 4, 3> right = Eigen::Matrix<double, 4, 3>::Zero();
  double rows = 0.0;
  for (std::size_t f = 0; f < sequence.frames.size(); ++f)
    for (std::size_t k = 0; k < sequence.points.size(); ++k) {
      const auto column = static_cast<Eigen::Index>(k);
      const Eigen::Vector3d at = sequence.frames[f].points_m.col(column);
      const Eigen::Vector3d e =
          field.values.col(static_cast<Eigen::Index>(f)).segment<3>(3 * column);
      if (!at.allFinite() || !e.allFinite()) continue;
      const Eigen::Vector4d x(1.0, at.x(), at.y(), at.z());
      normal += x * x.transpose();
      right += x * e.transpose();
      rows += 3.0;
    }
  if (rows < 60.0 || !(power > 0.0)) return 0.0;
  normal.diagonal().array() += 1e-12 * normal.trace();
  const Eigen::Matrix<double, 4, 3> fit = normal.ldlt().solve(right);
  return std::max(0.0, (fit.cwiseProduct(right)).sum() / (rows * power) - 12.0 / rows);
}

}  // namespace

std::vector<Structure> structure_of(const std::vector<Sequence>& sequences,
                                    const std::vector<Row>& rows,
                                    const Eigen::VectorXd& residuals) {
  std::vector<Structure> all;
  for (const Field& field : fields_of(sequences, rows, residuals)) {
    const Sequence& sequence = sequences[static_cast<std::size_t>(field.sequence)];
    Structure s;
    s.sequence = field.sequence;
    s.kind = field.kind;
    s.rows = static_cast<int>((field.values.array() == field.values.array()).count());
    if (s.rows > 0) {
      const double power = power_of(field);
      s.chi2 = power * s.rows;
      s.independent = s.rows;
      measure_correlation(field, sequence, power, s);
      if (power > 0.0) s.fixed = fixed_share(field, power);
      if (field.kind == ObservationKind::position) {
        s.at_edges = at_edges(field, sequence);
        s.with_place = with_place(field, sequence, power);
      }
    }
    all.push_back(s);
  }
  return all;
}

Misfit misfit_of(const std::vector<estimation::Sequence>& sequences,
                 const std::vector<estimation::Row>& rows, const Eigen::VectorXd& residuals) {
  std::vector<estimation::Observations> seen;
  seen.reserve(sequences.size());
  for (const estimation::Sequence& sequence : sequences) seen.emplace_back(sequence);
  Misfit misfit;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const auto s = static_cast<std::size_t>(rows[r].curve);
    const bool is_position =
        seen[s].kind(sequences[s], rows[r].channel) == estimation::ObservationKind::position;
    const double x = residuals[static_cast<Eigen::Index>(r)];
    misfit.chi2[is_position ? 0 : 1] += x * x;
    misfit.rows[is_position ? 0 : 1] += 1.0;
  }
  return misfit;
}

double independent_rows(const std::vector<Sequence>& sequences, const std::vector<Row>& rows,
                        const Eigen::VectorXd& residuals) {
  double sum = 0.0;
  for (const Field& field : fields_of(sequences, rows, residuals)) {
    Structure s;
    s.rows = static_cast<int>((field.values.array() == field.values.array()).count());
    if (s.rows == 0) continue;
    s.independent = s.rows;
    measure_correlation(field, sequences[static_cast<std::size_t>(field.sequence)], power_of(field),
                        s);
    sum += s.independent;
  }
  return sum;
}

std::vector<int> kind_places(const std::vector<Sequence>& sequences, const std::vector<Row>& rows) {
  const auto places = places_of_channels(sequences);
  std::vector<int> all;
  all.reserve(rows.size());
  for (const Row& row : rows)
    all.push_back(
        places[static_cast<std::size_t>(row.curve)][static_cast<std::size_t>(row.channel)]);
  return all;
}

}  // namespace tenter::diagnosis
