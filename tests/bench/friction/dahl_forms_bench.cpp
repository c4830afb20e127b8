// SPDX-License-Identifier: GPL-3.0-or-later
// Dahl's law in the forms of the thesis.
//
//   tenter-bench-dahl-forms [FILE.csv | FILE.svg]
//
// First, what equation 5.3 leaves out: for the samples of tables 5.1 and 5.2, loops from rest to
// 0.2, 0.4, ... 1 of the largest strain and back, 5.3 against the exact solution of 5.2.
// Then figure 5.3: loops of half a per cent about several offsets between 0 and 3 %, by the law
// with linear sigma_max and constant tau, and the best of each parameterisation for them:
//
//   left     linear sigma_max, constant tau       (and the same by 5.3)
//   middle   constant sigma_max, constant tau
//   right    linear sigma_max, constant slope alpha
//
// A CSV file has a row a point: loop, strain, and the friction stress (N/m) of each; an SVG file is
// figure 5.3, the three parameterisations beside each other over the loops.
#include <Eigen/Dense>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include "common/report/svg_file.h"
#include "server/mechanics/friction/dahl_forms.h"
#include "server/mechanics/friction/dahl_work.h"
#include "tests/twin/friction/friction_sample.h"

namespace {

using namespace tenter;

using Form = std::function<double(double e0, double s0, double e1, const Eigen::VectorXd& p)>;

double linear_tau(double e0, double s0, double e1, const Eigen::VectorXd& p) {
  return mechanics::dahl_constant_tau(e0, s0, e1, {p[0], p[1]}, p[2]);
}
double approximate(double e0, double s0, double e1, const Eigen::VectorXd& p) {
  return mechanics::dahl_approximate(e0, s0, e1, {p[0], p[1]}, p[2]);
}
double constant_tau(double e0, double s0, double e1, const Eigen::VectorXd& p) {
  return mechanics::dahl_constant_tau(e0, s0, e1, {p[0], 0.0}, p[1]);
}
double linear_slope(double e0, double s0, double e1, const Eigen::VectorXd& p) {
  return mechanics::dahl_constant_slope(e0, s0, e1, {p[0], p[1]}, p[2]);
}

/// Strains of one walk; a loop's points lie between its turns.
struct Walk {
  std::vector<double> strain;
  std::vector<int> loop;

  void go_to(double to, int steps, int number) {
    const double from = strain.empty() ? 0.0 : strain.back();
    for (int i = 1; i <= steps; ++i) {
      strain.push_back(from + (to - from) * i / steps);
      loop.push_back(number);
    }
  }
};

/// Point by point; 5.3 from turn to turn, as it is meant: cut into steps it is another law.
Eigen::VectorXd follow(const Walk& walk, const Form& form, const Eigen::VectorXd& p) {
  Eigen::VectorXd stress(static_cast<Eigen::Index>(walk.strain.size()));
  double turn_strain = 0.0, turn_stress = 0.0, before = 0.0, before_stress = 0.0, sign = 1.0;
  for (std::size_t k = 0; k < walk.strain.size(); ++k) {
    const double e = walk.strain[k];
    const double now = e >= before ? 1.0 : -1.0;
    if (now != sign) {
      turn_strain = before;
      turn_stress = before_stress;
      sign = now;
    }
    stress[static_cast<Eigen::Index>(k)] = form(turn_strain, turn_stress, e, p);
    before = e;
    before_stress = stress[static_cast<Eigen::Index>(k)];
  }
  return stress;
}

/// Levenberg-Marquardt over logarithms of the parameters, Jacobian by differences.
double fit(const Walk& walk, const Eigen::VectorXd& wanted, const Form& form, Eigen::VectorXd& p) {
  const auto at = [&](const Eigen::VectorXd& q) {
    return Eigen::VectorXd(follow(walk, form, q.array().exp().matrix()) - wanted);
  };
  Eigen::VectorXd q = p.array().log();
  Eigen::VectorXd r = at(q);
  double damping = 1e-3;
  for (int turn = 0; turn < 200 && damping < 1e12; ++turn) {
    Eigen::MatrixXd j(r.size(), q.size());
    for (Eigen::Index k = 0; k < q.size(); ++k) {
      const Eigen::VectorXd h = 1e-6 * Eigen::VectorXd::Unit(q.size(), k);
      j.col(k) = (at(q + h) - at(q - h)) / 2e-6;
    }
    Eigen::MatrixXd normal = j.transpose() * j;
    normal.diagonal() *= 1.0 + damping;
    const Eigen::VectorXd next = q - normal.ldlt().solve(j.transpose() * r);
    const Eigen::VectorXd there = at(next);
    if (there.squaredNorm() < r.squaredNorm()) {
      q = next;
      r = there;
      damping *= 0.2;
    } else {
      damping *= 5.0;
    }
  }
  p = q.array().exp();
  return std::sqrt(r.squaredNorm() / static_cast<double>(r.size()));
}

void print_left_out(const char* table, const std::vector<twin::FrictionSample>& samples,
                    double largest) {
  for (const twin::FrictionSample& sample : samples) {
    Walk walk;
    for (int n = 1; n <= 5; ++n) {
      walk.go_to(largest * n / 5.0, 200, n);
      walk.go_to(0.0, 200, n);
    }
    const Eigen::Vector3d p(sample.a, sample.b, sample.tau);
    const Eigen::VectorXd exact = follow(walk, linear_tau, p);
    const Eigen::VectorXd off = follow(walk, approximate, p) - exact;
    const double values[] = {sample.a, sample.b, 0.0, sample.tau};
    const auto check = mechanics::check_dissipation(values, largest);
    std::printf("%-5s %-12s %10.4g %10.4g %10.4g   %8.2f %% %8.2f %%   ", table,
                sample.name.c_str(), sample.a, sample.b, sample.tau,
                100.0 * off.cwiseAbs().maxCoeff() / exact.cwiseAbs().maxCoeff(),
                100.0 * std::sqrt(off.squaredNorm() / exact.squaredNorm()));
    if (check.holds)
      std::printf("never\n");
    else
      std::printf("below %.4g (b tau = %.2f times 2 sigma_max)\n", check.fails_to, check.worst);
  }
}

struct Row {
  const char* words;
  Form form;
  Eigen::VectorXd p;
  bool is_drawn;  ///< in figure 5.3
  Eigen::VectorXd stress;
};

/// Of every parameterisation but 5.3, over what it was fitted to.
bool draw(const std::string& path, const Walk& walk, const Eigen::VectorXd& wanted,
          const std::vector<Row>& rows) {
  std::vector<report::Plot> plots;
  for (const Row& row : rows) {
    if (!row.is_drawn) continue;
    report::Plot plot;
    plot.label = row.words;
    plot.x_label = "strain (%)";
    plot.y_label = "friction stress (N/m)";
    plot.zero_line = true;
    plot.width = 420;
    const auto line = [&](const char* name, std::size_t colour, const Eigen::VectorXd& stress) {
      report::PlotSeries series{
          name, report::line_class(colour), report::PlotSeries::Mark::line, {}, {}};
      for (std::size_t k = 0; k < walk.strain.size(); ++k) {
        series.x.push_back(100.0 * walk.strain[k]);
        series.y.push_back(stress[static_cast<Eigen::Index>(k)]);
      }
      plot.series.push_back(std::move(series));
    };
    line("loops", 5, wanted);
    line("fitted", 1, row.stress);
    plots.push_back(std::move(plot));
  }
  std::ofstream file(path);
  file << report::svg_file(plots, 3);
  return file.good();
}

}  // namespace

int main(int count, char** arguments) {
  std::printf("5.3 against the exact solution of 5.2, of the largest stress (rms: of its rms)\n");
  std::printf("%-5s %-12s %10s %10s %10s   %10s %10s   gains work\n", "table", "", "a", "b", "tau",
              "largest", "rms");
  print_left_out("5.1", twin::stretch_samples(), 0.1);
  print_left_out("5.2", twin::bending_samples(), 400.0);

  Walk walk;
  int loop = 0;
  for (const double middle : {0.005, 0.01, 0.015, 0.02, 0.025}) {
    walk.go_to(middle + 0.005, 40, loop);
    for (int cycle = 0; cycle < 2; ++cycle, ++loop) {
      walk.go_to(middle - 0.005, 60, loop);
      walk.go_to(middle + 0.005, 60, loop);
    }
  }
  walk.go_to(0.0, 120, loop);
  const Eigen::VectorXd truth = (Eigen::VectorXd(3) << 0.6, 120.0, 0.0025).finished();
  const Eigen::VectorXd wanted = follow(walk, linear_tau, truth);
  std::vector<Row> rows = {
      {"linear sigma_max, constant tau", linear_tau, truth, true, {}},
      {"the same by 5.3", approximate, truth, false, {}},
      {"constant sigma_max, constant tau", constant_tau, Eigen::Vector2d(2.0, 0.003), true, {}},
      {"linear sigma_max, constant alpha",
       linear_slope,
       Eigen::Vector3d(0.6, 120.0, 600.0),
       true,
       {}}};
  const double rms = std::sqrt(wanted.squaredNorm() / static_cast<double>(wanted.size()));
  std::printf("\nFigure 5.3: loops about offsets from 0 to 3 %%, friction stress rms %.3f N/m\n",
              rms);
  std::printf("%-34s %12s %10s   parameters\n", "", "misfit", "largest");
  for (Row& row : rows) {
    const double misfit = fit(walk, wanted, row.form, row.p);
    row.stress = follow(walk, row.form, row.p);
    std::printf("%-34s %10.3f %% %8.2f %%  ", row.words, 100.0 * misfit / rms,
                100.0 * (row.stress - wanted).cwiseAbs().maxCoeff() / wanted.cwiseAbs().maxCoeff());
    for (const double value : row.p) std::printf(" %.5g", value);
    std::printf("\n");
  }
  if (count < 2) return 0;
  if (std::string(arguments[1]).ends_with(".svg"))
    return draw(arguments[1], walk, wanted, rows) ? 0 : 1;
  std::FILE* file = std::fopen(arguments[1], "w");
  if (!file) {
    std::fprintf(stderr, "tenter-bench-dahl-forms: cannot write %s\n", arguments[1]);
    return 1;
  }
  std::fprintf(file, "loop,strain,truth,linear_tau,approximate,constant_tau,linear_slope\n");
  for (std::size_t k = 0; k < walk.strain.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    std::fprintf(file, "%d,%.8g,%.8g", walk.loop[k], walk.strain[k], wanted[i]);
    for (const Row& row : rows) std::fprintf(file, ",%.8g", row.stress[i]);
    std::fprintf(file, "\n");
  }
  return std::fclose(file) == 0 ? 0 : 1;
}
