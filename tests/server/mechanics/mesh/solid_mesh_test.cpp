// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/mesh/solid_mesh.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <sstream>
#include <string>

#include "server/mechanics/mesh/hexahedron.h"
#include "server/mechanics/mesh/solid_text.h"
#include "tests/server/mechanics/mesh/random_mesh.h"

namespace tenter::mechanics {
namespace {

using testing::sum;
using testing::tolerance;

const Eigen::Vector3d kSize(0.2, 0.1, 0.05);

/// Inner nodes of a box moved by up to a fifth of a cell: the body keeps its volume.
SolidMesh shaken(SolidMesh mesh, const Eigen::Vector3i& cells, unsigned seed) {
  testing::Numbers numbers(seed);
  for (int n = 0; n < mesh.node_count(); ++n)
    for (int k = 0; k < 3; ++k) {
      const double x = mesh.rest_m(k, n);
      const bool inner = x > 1e-9 && x < kSize[k] - 1e-9;
      if (inner) mesh.rest_m(k, n) += numbers.between(-0.2, 0.2) * kSize[k] / cells[k];
    }
  return mesh;
}

TEST(SolidMesh, VolumesAndMassesSumToTheWhole) {
  const Eigen::Vector3i cells(5, 4, 3);
  const double volume = kSize.prod();
  const SolidMesh boxes[] = {box_tetrahedra(5, 4, 3, kSize).value(),
                             box_hexahedra(5, 4, 3, kSize).value()};
  EXPECT_EQ(boxes[0].tetrahedra.size(), 6U * 60);
  EXPECT_EQ(boxes[1].hexahedra.size(), 60U);
  for (const SolidMesh& box : boxes)
    for (unsigned seed = 1; seed <= 10; ++seed) {
      const SolidMesh mesh = shaken(box, cells, seed);
      ASSERT_TRUE(check(mesh)) << check(mesh).error().message;
      EXPECT_EQ(mesh.node_count(), 6 * 5 * 4);
      EXPECT_NEAR(sum(volumes_m3(mesh)), volume, tolerance(1e-13 * volume));
      EXPECT_NEAR(sum(lumped_masses_kg(mesh, 1050.0)), 1050.0 * volume,
                  tolerance(1e-13 * 1050.0 * volume));
      const std::vector<double> weighed = lumped_masses_of_total_kg(mesh, 0.83);
      EXPECT_NEAR(sum(weighed), 0.83, tolerance(1e-13));
      for (const double mass : weighed) EXPECT_GT(mass, 0.0);
    }
}

/// Integrals of linear functions over a shaken mesh: the mass keeps the centre of the box, exactly
/// for tetrahedra.
TEST(SolidMesh, TetrahedraKeepTheCentreOfMass) {
  const SolidMesh mesh = shaken(box_tetrahedra(4, 4, 4, kSize).value(), {4, 4, 4}, 3);
  const std::vector<double> mass = lumped_masses_kg(mesh, 1.0);
  const Eigen::Map<const Eigen::VectorXd> m(mass.data(), mesh.node_count());
  EXPECT_LT((mesh.rest_m * m / m.sum() - 0.5 * kSize).norm(), 1e-15);
}

TEST(Hexahedron, ShapeFunctionsAndTheirSlopes) {
  testing::Numbers numbers(2);
  testing::Comparison slopes("slopes");
  for (int round = 0; round < 20; ++round) {
    const Eigen::Vector3d xi(numbers.between(-1, 1), numbers.between(-1, 1),
                             numbers.between(-1, 1));
    EXPECT_NEAR(hexahedron_shape(xi).sum(), 1.0, 1e-15);
    EXPECT_LT((hexahedron_corners() * hexahedron_shape(xi) - xi).norm(), 1e-15);
    for (int k = 0; k < 3; ++k)
      for (int a = 0; a < 8; ++a) {
        const auto shape_along = [&](double x) {
          Eigen::Vector3d moved = xi;
          moved[k] = x;
          return hexahedron_shape(moved)[a];
        };
        slopes.add(hexahedron_slopes(xi)(a, k), testing::difference(shape_along, xi[k], 1e-3));
      }
  }
  slopes.judge(1e-10);
  for (int a = 0; a < 8; ++a)
    EXPECT_NEAR(hexahedron_shape(hexahedron_corners().col(a))[a], 1.0, 1e-15);
}

/// A frustum: bottom square of side 2, top of side 1, height 3, volume 7.
TEST(Hexahedron, FrustumByHand) {
  SolidMesh mesh;
  mesh.rest_m.resize(3, 8);
  mesh.rest_m << -1, 1, 1, -1, -0.5, 0.5, 0.5, -0.5,  //
      -1, -1, 1, 1, -0.5, -0.5, 0.5, 0.5,             //
      0, 0, 0, 0, 3, 3, 3, 3;
  mesh.hexahedra = {{0, 1, 2, 3, 4, 5, 6, 7}};
  ASSERT_TRUE(check(mesh));
  EXPECT_NEAR(volumes_m3(mesh)[0], 7.0, 1e-14);
  // mass of the bottom: integral of (1 - z/3) over the frustum = 4.25, a quarter each
  EXPECT_NEAR(lumped_masses_kg(mesh, 1.0)[0], 4.25 / 4.0, 1e-14);
}

TEST(SolidMesh, ErrorsNameTheElement) {
  struct Case {
    const char* message;
    SolidMesh mesh;
  };
  std::vector<Case> cases;
  const auto add = [&](const char* message, const SolidMesh& from, auto change) {
    SolidMesh mesh = from;
    change(mesh);
    cases.push_back({message, mesh});
  };
  const SolidMesh tets = box_tetrahedra(1, 1, 1, kSize).value();
  const SolidMesh hexes = box_hexahedra(2, 1, 1, kSize).value();
  add("no elements", tets, [](SolidMesh& m) { m.tetrahedra.clear(); });
  add("tetrahedron 2", tets, [](SolidMesh& m) { m.tetrahedra[2][1] = 8; });
  add("tetrahedron 2", tets, [](SolidMesh& m) { m.tetrahedra[2][1] = -1; });
  add("hexahedron 1 (nodes", hexes, [](SolidMesh& m) { m.hexahedra[1][7] = 99; });
  add("uses a node twice", tets, [](SolidMesh& m) { m.tetrahedra[0][1] = m.tetrahedra[0][0]; });
  add("tetrahedron 3", tets,
      [](SolidMesh& m) { std::swap(m.tetrahedra[3][0], m.tetrahedra[3][1]); });
  add("left-handed", tets, [](SolidMesh& m) { m.rest_m.row(2) *= -1.0; });
  add("left-handed", hexes, [](SolidMesh& m) { m.rest_m.row(0) *= -1.0; });
  add("hexahedron 0", hexes, [](SolidMesh& m) { m.rest_m(0, m.hexahedra[0][1]) = -0.05; });
  add("degenerate", tets, [](SolidMesh& m) { m.rest_m.row(2) *= 1e-9; });
  add("degenerate", hexes, [](SolidMesh& m) { m.rest_m.row(2) *= 0.0; });
  add("degenerate", tets, [](SolidMesh& m) { m.rest_m *= 1e200; });
  add("node 3 is not finite", tets, [](SolidMesh& m) { m.rest_m(1, 3) = std::nan(""); });
  add("more than two elements", tets, [](SolidMesh& m) {
    m.tetrahedra.push_back(m.tetrahedra[0]);
    m.tetrahedra.push_back(m.tetrahedra[0]);
  });
  add("node 8 belongs to no element", tets, [](SolidMesh& m) {
    m.rest_m.conservativeResize(3, 9);
    m.rest_m.col(8).setZero();
  });
  for (const Case& c : cases) {
    const auto checked = check(c.mesh);
    ASSERT_FALSE(checked) << c.message;
    EXPECT_NE(checked.error().message.find(c.message), std::string::npos)
        << c.message << ": " << checked.error().message;
  }
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(box_tetrahedra(0, 1, 1, kSize));
  EXPECT_FALSE(box_hexahedra(1, -1, 1, kSize));
  EXPECT_FALSE(box_hexahedra(2000000000, 2000000000, 2000000000, kSize));
  EXPECT_FALSE(box_hexahedra(1, 1, 1, {1.0, 0.0, 1.0}));
  EXPECT_FALSE(box_hexahedra(1, 1, 1, {1.0, nan, 1.0}));
}

/// Tags that are not consecutive, a point that belongs to the geometry alone, a boundary triangle.
std::string msh2(const SolidMesh& mesh) {
  std::ostringstream out;
  out.precision(17);
  out << "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n3 7 \"gel\"\n"
         "$EndPhysicalNames\n$Nodes\n"
      << mesh.node_count() + 1 << "\n5 9 9 9\n";
  for (int n = 0; n < mesh.node_count(); ++n)
    out << 10 + 3 * n << ' ' << mesh.rest_m(0, n) << ' ' << mesh.rest_m(1, n) << ' '
        << mesh.rest_m(2, n) << '\n';
  out << "$EndNodes\n$Elements\n"
      << 2 + mesh.tetrahedra.size() + mesh.hexahedra.size()
      << "\n1 15 2 0 1 5\n2 2 2 0 1 10 13 16\n";
  for (const auto& t : mesh.tetrahedra) {
    out << "3 4 2 7 1";
    for (const int n : t) out << ' ' << 10 + 3 * n;
    out << '\n';
  }
  for (const auto& h : mesh.hexahedra) {
    out << "4 5 0";
    for (const int n : h) out << ' ' << 10 + 3 * n;
    out << '\n';
  }
  out << "$EndElements\n";
  return out.str();
}

std::string msh4(const SolidMesh& mesh) {
  std::ostringstream out;
  out.precision(17);
  const int half = mesh.node_count() / 2;
  out << "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Entities\n0 0 0 0\n$EndEntities\n$Nodes\n3 "
      << mesh.node_count() + 1 << " 5 999\n0 1 0 1\n5\n9 9 9\n";
  for (const auto& [from, to] : {std::pair(0, half), std::pair(half, mesh.node_count())}) {
    out << "3 1 0 " << to - from << '\n';
    for (int n = from; n < to; ++n) out << 10 + 3 * n << '\n';
    for (int n = from; n < to; ++n)
      out << mesh.rest_m(0, n) << ' ' << mesh.rest_m(1, n) << ' ' << mesh.rest_m(2, n) << '\n';
  }
  const bool tets = !mesh.tetrahedra.empty();
  out << "$EndNodes\n$Elements\n2 " << 1 + mesh.tetrahedra.size() + mesh.hexahedra.size()
      << " 1 99\n2 1 2 1\n1 10 13 16\n3 1 " << (tets ? 4 : 5) << ' '
      << mesh.tetrahedra.size() + mesh.hexahedra.size() << '\n';
  for (const auto& t : mesh.tetrahedra) {
    out << 3;
    for (const int n : t) out << ' ' << 10 + 3 * n;
    out << '\n';
  }
  for (const auto& h : mesh.hexahedra) {
    out << 4;
    for (const int n : h) out << ' ' << 10 + 3 * n;
    out << '\n';
  }
  out << "$EndElements\n";
  return out.str();
}

TEST(SolidText, BothVersionsGiveTheMeshBack) {
  const SolidMesh meshes[] = {shaken(box_tetrahedra(3, 2, 2, kSize).value(), {3, 2, 2}, 1),
                              shaken(box_hexahedra(3, 2, 2, kSize).value(), {3, 2, 2}, 2)};
  for (const SolidMesh& mesh : meshes)
    for (const std::string& text : {msh2(mesh), msh4(mesh)}) {
      const auto read = read_msh(text);
      ASSERT_TRUE(read) << read.error().message;
      EXPECT_TRUE(read->mesh.rest_m == mesh.rest_m);
      EXPECT_EQ(read->mesh.tetrahedra, mesh.tetrahedra);
      EXPECT_EQ(read->mesh.hexahedra, mesh.hexahedra);
      ASSERT_EQ(read->node_tag.size(), static_cast<std::size_t>(mesh.node_count()));
      EXPECT_EQ(read->node_tag[2], 16);
      EXPECT_TRUE(read_msh(text, 1e-3)->mesh.rest_m.isApprox(1e-3 * mesh.rest_m, 1e-15));
    }
}

TEST(SolidText, FaultsNameTheLine) {
  const std::string format = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n";
  const std::string nodes = "$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n$EndNodes\n";  // 4..10
  const auto elements = [&](const std::string& line) {
    return format + nodes + "$Elements\n1\n" + line + "\n$EndElements\n";
  };
  ASSERT_TRUE(read_msh(elements("1 4 0 1 2 3 4")));
  const std::pair<std::string, const char*> faults[] = {
      {"", "no tetrahedra"},
      {"hello\n", "line 1: '$MeshFormat' expected"},
      {"$MeshFormat\n3.0 0 8\n", "line 2: version '3.0'"},
      {"$MeshFormat\n4.1 1 8\n", "line 2: only the ascii form"},
      {format + "$Nodes\n1000000000000\n1 0 0 0\n", "line 5: number of nodes 1000000000000 cannot"},
      {format + "$Nodes\n-1\n", "line 5: number of nodes -1"},
      {format + "$Nodes\n2\n1 0 0 0\n", "line 6: the text ends"},
      {format + "$Nodes\n1\n1 0 0 inf\n$EndNodes\n", "line 6: coordinate 'inf'"},
      {format + "$Nodes\n1\nx 0 0 0\n$EndNodes\n", "line 6: node tag"},
      {format + "$Nodes\n1\n1 0 0 0\n2 0 0 0\n$EndNodes\n", "line 7: '$EndNodes' expected"},
      {format + "$Comments\nnever ends\n", "line 5: the text ends inside"},
      {elements("1 11 0 1 2 3 4"), "line 13: elements of type 11"},
      {elements("1 4 0 1 2 3"), "line 13: node tag"},
      {elements("1 4 0 1 2 3 9"), "line 13: there is no node 9"},
      {elements("1 4 99999999 1 2 3 4"), "line 13: number of tags"},
      {elements("1 4 0 1 3 2 4"), "tetrahedron 0 (nodes 0 2 1 3) is left-handed"},
      {format +
           "$Nodes\n2\n1 0 0 0\n1 1 0 0\n$EndNodes\n$Elements\n1\n1 4 0 1 1 1 1\n$EndElements\n",
       "node 1 twice"},
      {"$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 5 1 5\n3 1 0 1000000000\n1\n", "line 6"},
      {"$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n9999999 5 1 5\n3 1 0 1\n", "line 5"},
  };
  for (const auto& [text, message] : faults) {
    const auto read = read_msh(text);
    ASSERT_FALSE(read) << text;
    EXPECT_NE(read.error().message.find(message), std::string::npos)
        << text << "\n-> " << read.error().message;
  }
}

TEST(SolidText, PrefixesAndChangedBytes) {
  const SolidMesh mesh = box_tetrahedra(1, 1, 1, kSize).value();
  testing::Numbers numbers(23);
  int refused = 0;
  for (const std::string& text : {msh2(mesh), msh4(mesh)}) {
    for (std::size_t size = 0; size + 1 < text.size(); ++size)
      refused += read_msh(text.substr(0, size)) ? 0 : 1;
    for (int round = 0; round < 3000; ++round) {
      std::string changed = text;
      changed[static_cast<std::size_t>(numbers.between(0.0, 0.999999) *
                                       static_cast<double>(text.size()))] =
          static_cast<char>(numbers.between(0.0, 255.0));
      const auto read = read_msh(changed);
      refused += read ? 0 : 1;
      if (read) {
        EXPECT_TRUE(check(read->mesh));
      }
    }
  }
  EXPECT_GT(refused, 2000);
}

}  // namespace
}  // namespace tenter::mechanics
