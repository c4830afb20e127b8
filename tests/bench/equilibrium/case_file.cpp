// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/bench/equilibrium/case_file.h"

#include <fstream>
#include <nlohmann/json.hpp>
#include <random>
#include <sstream>
#include <string>

#include "common/model/document.h"
#include "server/mechanics/mesh/grid.h"

namespace tenter::mechanics::bench {
namespace {

using nlohmann::json;

std::string text_of(const std::filesystem::path& path) {
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

Eigen::Vector3d vector3(const json& numbers) {
  return {numbers.at(0).get<double>(), numbers.at(1).get<double>(), numbers.at(2).get<double>()};
}

/// The flat square in its plane, its nodes off it by uniform noise.
Eigen::VectorXd flat_start(const SurfaceMesh& mesh, const json& start) {
  const bool is_vertical = start.at("plane").get<std::string>() == "vertical";
  const auto noise_m = start.at("noise_m").get<double>();
  std::mt19937 random(start.at("seed").get<unsigned>());
  Eigen::VectorXd x(3 * mesh.node_count());
  for (int n = 0; n < mesh.node_count(); ++n) {
    const double unit = static_cast<double>(random()) / static_cast<double>(std::mt19937::max());
    const double off_m = noise_m * (2.0 * unit - 1.0);
    const Eigen::Vector2d at = mesh.material_m.col(n);
    x.segment<3>(3 * n) = is_vertical ? Eigen::Vector3d(at.x(), off_m, at.y())
                                      : Eigen::Vector3d(at.x(), at.y(), off_m);
  }
  return x;
}

Expected<Case> case_of(const json& document, const std::filesystem::path& path) {
  Case result;
  const json& m = document.at("mesh");
  const Grid grid{m.at("nodes_u"), m.at("nodes_v"), m.at("length_u_m"), m.at("length_v_m")};
  const std::string diagonals = m.at("diagonals");
  if (diagonals != "alternating")
    return bad_input(path.string() + ": mesh.diagonals: only \"alternating\" is known");
  auto cloth = cloth_of_grid(grid, Diagonals::alternating);
  if (!cloth) return tl::unexpected(cloth.error());
  result.cloth = std::move(*cloth);
  result.nodes_a_side = grid.nodes_u;

  const auto model_path = path.parent_path() / document.at("model").get<std::string>();
  auto model = model::parse_model(text_of(model_path), model_path.string());
  if (!model) return tl::unexpected(model.error());
  result.model = std::move(*model);
  result.parameters = term_parameters(result.model);

  const auto masses = lumped_masses_kg(result.cloth.mesh, document.at("area_density_kg_m2"));
  result.loads.node_mass_kg =
      Eigen::Map<const Eigen::VectorXd>(masses.data(), static_cast<Eigen::Index>(masses.size()));
  result.loads.gravity_m_s2 = vector3(document.at("gravity_m_s2"));

  const int left_pin = grid.node(0, grid.nodes_v - 1);
  result.right_pin = grid.node(grid.nodes_u - 1, grid.nodes_v - 1);
  result.boundary.held = {left_pin, result.right_pin};
  result.start.x = flat_start(result.cloth.mesh, document.at("start"));
  const double inwards_m =
      0.5 * (grid.length_u_m - document.at("pins").at("distance_m").get<double>());
  result.start.x[3 * static_cast<Eigen::Index>(left_pin)] += inwards_m;
  result.start.x[3 * static_cast<Eigen::Index>(result.right_pin)] -= inwards_m;
  result.tolerance_N = document.at("tolerance_N");

  if (!document.contains("then")) return result;
  const json& then = document.at("then");
  if (then.contains("scale_parameters")) {
    const auto scale = then.at("scale_parameters").get<std::vector<double>>();
    result.scale =
        Eigen::Map<const Eigen::VectorXd>(scale.data(), static_cast<Eigen::Index>(scale.size()));
    if (result.scale.size() != result.parameters.size())
      return bad_input(path.string() + ": then.scale_parameters: one number a parameter");
  }
  if (then.contains("frames")) {
    result.frames = then.at("frames");
    result.move_m = vector3(then.at("move_right_pin_m"));
  }
  return result;
}

}  // namespace

Expected<Case> read_case(const std::filesystem::path& path) {
  try {
    return case_of(json::parse(text_of(path)), path);
  } catch (const json::exception& problem) {
    return bad_input(path.string() + ": " + problem.what());
  }
}

}  // namespace tenter::mechanics::bench
