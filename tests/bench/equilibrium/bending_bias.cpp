// SPDX-License-Identifier: GPL-3.0-or-later
// What meshes do to the bending stiffness of discrete shells, against the direction of the bend.
//
//   tenter-bench-bending
//
// First, energies of a bend held to a cylinder and of a strip free to twist, over what the material
// should take. Then strips that bend under their own weight, solved: the stiffness that a strip of
// 3 k a width would need to hang as deep.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "server/mechanics/mesh/outline.h"
#include "tests/server/mechanics/equilibrium/bending/bending_bias.h"

namespace {

using namespace tenter::mechanics;
using testing::bending_form;
using testing::cylinder;
using testing::free_strip;
using testing::strip_stiffness;

constexpr double kSide = 0.1;

void print_row(const std::string& name, const SurfaceMesh& mesh, const testing::Window& window) {
  const Eigen::Matrix3d form = bending_form(mesh, window);
  std::printf("%-26s", name.c_str());
  for (const double degrees : {0.0, 45.0, 90.0, 135.0})
    std::printf(" %6.3f", cylinder(form, degrees * M_PI / 180.0));
  double least = 1e300, most = 0.0;
  for (int degrees = 0; degrees < 180; ++degrees) {
    const double part = cylinder(form, degrees * M_PI / 180.0);
    least = std::min(least, part);
    most = std::max(most, part);
  }
  std::printf("   %6.3f %6.3f  ", least, most);
  for (const double degrees : {0.0, 45.0, 90.0, 135.0})
    std::printf(" %6.3f", free_strip(form, degrees * M_PI / 180.0));
  std::printf("\n");
}

void print_forms() {
  std::printf("%-26s %27s   %13s   %27s\n", "", "held to a cylinder", "all angles",
              "strip free to twist");
  std::printf("%-26s", "mesh, bend towards");
  std::printf(" %6s %6s %6s %6s   %6s %6s  ", "0", "45", "90", "135", "least", "most");
  std::printf(" %6s %6s %6s %6s\n", "0", "45", "90", "135");
  struct Cut {
    const char* name;
    Diagonals diagonals;
  };
  for (const Cut& cut :
       {Cut{"one diagonal", Diagonals::one}, Cut{"the other", Diagonals::other},
        Cut{"alternating", Diagonals::alternating}, Cut{"both, half each", Diagonals::both}}) {
    const auto mesh = grid_mesh({25, 25, kSide, kSide}, cut.diagonals);
    if (mesh) print_row(cut.name, *mesh, {kSide / 6.0, 5.0 * kSide / 6.0});
  }
  const std::vector<Eigen::Vector2d> square = {
      {0.0, 0.0}, {kSide, 0.0}, {kSide, kSide}, {0.0, kSide}};
  for (const int cells : {12, 24, 48, 96}) {
    const auto mesh = triangulate_outline(square, kSide / cells);
    if (mesh)
      print_row("irregular, edges 1/" + std::to_string(cells), *mesh,
                {kSide / 6.0, 5.0 * kSide / 6.0});
  }
}

void print_strips() {
  std::printf(
      "\nstrips of 100 mm under their own weight: stiffness that they bend with, over 3 k\n");
  std::printf("%-16s %6s %8s %10s %10s\n", "diagonals", "cells", "across", "300 N/m", "30 kN/m");
  struct Cut {
    const char* name;
    Diagonals diagonals;
  };
  for (const Cut& cut : {Cut{"one", Diagonals::one}, Cut{"alternating", Diagonals::alternating},
                         Cut{"both", Diagonals::both}})
    for (const int cells : {12, 24, 48})
      for (const int across : {2, cells / 4, cells})
        std::printf("%-16s %6d %8d %10.3f %10.3f\n", cut.name, cells, across,
                    strip_stiffness(cells, across, cut.diagonals, 3e2).value_or(std::nan("")),
                    strip_stiffness(cells, across, cut.diagonals, 3e4).value_or(std::nan("")));
}

}  // namespace

int main() {
  print_forms();
  print_strips();
  return 0;
}
