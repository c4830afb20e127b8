// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/twin/fabrics/sheet/sheet.h"

#include <cmath>
#include <utility>

namespace tenter::twin {

namespace {

/// Three points a span, exact to the fifth degree.
struct Gauss {
  double place, weight;  // on -1 to 1
};
constexpr std::array<Gauss, 3> kGauss = {
    Gauss{-0.7745966692414834, 5.0 / 9.0}, {0.0, 8.0 / 9.0}, {0.7745966692414834, 5.0 / 9.0}};

/// Function q of a span is q % 4 along u, q / 4 along v.
Eigen::Matrix<double, 16, 5> shape_of(const LineValue& u, const LineValue& v) {
  Eigen::Matrix<double, 16, 5> shape;
  for (std::size_t j = 0; j < 4; ++j)
    for (std::size_t i = 0; i < 4; ++i)
      shape.row(static_cast<Eigen::Index>(4 * j + i)) << u.slope[i] * v.value[j],
          u.value[i] * v.slope[j], u.curve[i] * v.value[j], u.value[i] * v.curve[j],
          u.slope[i] * v.slope[j];
  return shape;
}

/// What a quantity with these control points is at a place.
double sum_of(const SplineLine& line_u, const SplineLine& line_v, const Eigen::Vector2d& material_m,
              const double* controls, int stride) {
  const LineValue u = line_u.at(material_m.x()), v = line_v.at(material_m.y());
  double sum = 0.0;
  for (int j = 0; j < 4; ++j)
    for (int i = 0; i < 4; ++i)
      sum += u.value[static_cast<std::size_t>(i)] * v.value[static_cast<std::size_t>(j)] *
             controls[stride * ((v.first + j) * line_u.count() + u.first + i)];
  return sum;
}

std::vector<int> functions_on(const SplineLine& u, const SplineLine& v, const Region& region) {
  const auto [first_u, last_u] = u.functions_on(region.lo_u, region.hi_u);
  const auto [first_v, last_v] = v.functions_on(region.lo_v, region.hi_v);
  std::vector<int> found;
  for (int j = first_v; j <= last_v; ++j)
    for (int i = first_u; i <= last_u; ++i) found.push_back(j * u.count() + i);
  return found;
}

}  // namespace

Sheet::Sheet(Fabric fabric, SheetLines lines)
    : fabric_(std::move(fabric)), lines_(std::move(lines)) {
  weight_N_.setZero(unknown_count());
  const double density_N_m2 = fabric_.mass_kg * kGravity_m_s2 / (fabric_.side_m * fabric_.side_m);
  const auto& su = lines_.plane_u.spans();
  const auto& sv = lines_.plane_v.spans();
  for (std::size_t b = 0; b + 1 < sv.size(); ++b)
    for (std::size_t a = 0; a + 1 < su.size(); ++a) {
      Span& span = spans_.emplace_back();
      const double half_u = 0.5 * (su[a + 1] - su[a]), half_v = 0.5 * (sv[b + 1] - sv[b]);
      for (std::size_t k = 0; k < kGaussPoints; ++k) {
        const Gauss &gu = kGauss[k % 3], &gv = kGauss[k / 3];
        const double u = su[a] + half_u * (1.0 + gu.place), v = sv[b] + half_v * (1.0 + gv.place);
        const LineValue pu = lines_.plane_u.at(u), pv = lines_.plane_v.at(v);
        const LineValue hu = lines_.height_u.at(u), hv = lines_.height_v.at(v);
        GaussPoint& point = span.points[k];
        history_.emplace_back().stiffer = fabric_.hidden.stiffer_at({u, v});
        point.area = half_u * half_v * gu.weight * gv.weight;
        point.plane = shape_of(pu, pv);
        point.height = shape_of(hu, hv);
        for (int q = 0; q < 16; ++q) {
          const auto i = static_cast<std::size_t>(q % 4), j = static_cast<std::size_t>(q / 4);
          const int plane = (pv.first + q / 4) * lines_.plane_u.count() + pu.first + q % 4;
          const int height = (hv.first + q / 4) * lines_.height_u.count() + hu.first + q % 4;
          const auto place = static_cast<std::size_t>(q);
          span.unknowns[place] = x_of(plane);
          span.unknowns[16 + place] = x_of(plane) + 1;
          span.unknowns[32 + place] = z_of(height);
          weight_N_[z_of(height)] += density_N_m2 * point.area * hu.value[i] * hv.value[j];
        }
      }
    }
}

Eigen::Vector2d Sheet::place(int plane_point) const {
  const int across = lines_.plane_u.count();
  return {lines_.plane_u.place(plane_point % across), lines_.plane_v.place(plane_point / across)};
}

Eigen::VectorXd Sheet::flat() const {
  Eigen::VectorXd x = Eigen::VectorXd::Zero(unknown_count());
  for (int n = 0; n < plane_count(); ++n) x.segment<2>(x_of(n)) = place(n);
  return x;
}

Eigen::Vector3d Sheet::position(const Eigen::VectorXd& x, const Eigen::Vector2d& material_m) const {
  const double* plane = x.data();
  return {sum_of(lines_.plane_u, lines_.plane_v, material_m, plane, 2),
          sum_of(lines_.plane_u, lines_.plane_v, material_m, plane + 1, 2),
          sum_of(lines_.height_u, lines_.height_v, material_m, plane + z_of(0), 1)};
}

Gripped Sheet::gripped(const Region& region) const {
  return {functions_on(lines_.plane_u, lines_.plane_v, region),
          functions_on(lines_.height_u, lines_.height_v, region)};
}

std::vector<std::array<int, kSpanUnknowns>> Sheet::spans() const {
  std::vector<std::array<int, kSpanUnknowns>> result;
  for (const Span& span : spans_) result.push_back(span.unknowns);
  return result;
}

SurfaceVector Sheet::surface_at(const Span& span, const GaussPoint& point,
                                const Eigen::VectorXd& x) {
  Eigen::Matrix<double, 3, 16> controls;
  for (int c = 0; c < 3; ++c)
    for (int q = 0; q < 16; ++q)
      controls(c, q) = x[span.unknowns[static_cast<std::size_t>(16 * c + q)]];
  Eigen::Matrix<double, 3, 5> y;
  y.topRows<2>() = controls.topRows<2>() * point.plane;
  y.row(2) = controls.row(2) * point.height;
  return Eigen::Map<const SurfaceVector>(y.data());
}

double Sheet::evaluate(const Eigen::VectorXd& x, Eigen::VectorXd* gradient,
                       const std::vector<int>* slots, double* values, double convex_share) const {
  double energy = 0.0;
  for (Eigen::Index k = 2 * plane_count(); k < x.size(); ++k) energy += weight_N_[k] * x[k];
  if (gradient) *gradient = weight_N_;
  PointEnergy at;
  Eigen::Matrix<double, kSpanUnknowns, kSpanUnknowns> whole;
  for (std::size_t s = 0; s < spans_.size(); ++s) {
    const Span& span = spans_[s];
    if (slots) whole.setZero();
    for (std::size_t k = 0; k < kGaussPoints; ++k) {
      const GaussPoint& point = span.points[k];
      evaluate_point(fabric_, history_[s * kGaussPoints + k], surface_at(span, point, x),
                     slots != nullptr, convex_share, at);
      energy += point.area * at.energy;
      const Shape* shape[3] = {&point.plane, &point.plane, &point.height};
      if (gradient) {
        const Eigen::Map<const Eigen::Matrix<double, 3, 5>> by_y(at.gradient.data());
        for (int c = 0; c < 3; ++c) {
          const Eigen::Matrix<double, 16, 1> force =
              point.area * (*shape[c]) * by_y.row(c).transpose();
          for (int q = 0; q < 16; ++q)
            (*gradient)[span.unknowns[static_cast<std::size_t>(16 * c + q)]] += force[q];
        }
      }
      if (!slots) continue;
      // of both coordinates the five derivatives are three apart
      using Five = Eigen::Map<const Eigen::Matrix<double, 5, 5>, 0, Eigen::Stride<45, 3>>;
      for (int c = 0; c < 3; ++c)
        for (int d = 0; d <= c; ++d) {
          const Five by_yy(at.hessian.data() + 15 * c + d);
          whole.block<16, 16>(16 * d, 16 * c) +=
              *shape[d] * (point.area * by_yy * shape[c]->transpose());
        }
    }
    if (!slots) continue;
    whole.triangularView<Eigen::StrictlyLower>() = whole.transpose();
    const int* slot = slots->data() + s * kSpanUnknowns * kSpanUnknowns;
    for (int k = 0; k < kSpanUnknowns * kSpanUnknowns; ++k)
      if (slot[k] >= 0) values[slot[k]] += whole.data()[k];
  }
  return energy;
}

void Sheet::set_step(double step_s) {
  for (PointHistory& history : history_) history.step_s = step_s;
}

void Sheet::advance(const Eigen::VectorXd& x) {
  for (std::size_t s = 0; s < spans_.size(); ++s)
    for (std::size_t k = 0; k < kGaussPoints; ++k) {
      PointHistory& history = history_[s * kGaussPoints + k];
      history = twin::advance(fabric_, history, surface_at(spans_[s], spans_[s].points[k], x));
    }
}

}  // namespace tenter::twin
