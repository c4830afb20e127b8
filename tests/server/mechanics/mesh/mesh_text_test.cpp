// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/mesh/mesh_text.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <sstream>
#include <string>

#include "tests/server/mechanics/mesh/random_mesh.h"

namespace tenter::mechanics {
namespace {

using mesh_text::read_obj;
using mesh_text::read_ply;
using mesh_text::read_surface_text;

using testing::random_mesh;
using testing::sum;

constexpr Grid kGrid{5, 4, 0.25, 0.125};

/// The sheet lifted into space by a turn, so that no plane of the axes helps.
Eigen::Matrix3Xd lifted(const SurfaceMesh& mesh) {
  const Eigen::Vector3d a = Eigen::Vector3d(0.6, 0.0, 0.8);
  const Eigen::Vector3d b = Eigen::Vector3d(0.0, 1.0, 0.0);
  return (a * mesh.material_m.row(0) + b * mesh.material_m.row(1)).colwise() +
         Eigen::Vector3d(3.0, -2.0, 1.0);
}

std::string obj_of(const SurfaceMesh& mesh, bool texture) {
  std::ostringstream out;
  out.precision(17);
  out << "# a sheet\nmtllib none.mtl\no sheet\r\n";
  const Eigen::Matrix3Xd x = lifted(mesh);
  for (int n = 0; n < mesh.node_count(); ++n) {
    out << "v " << x(0, n) << ' ' << x(1, n) << ' ' << x(2, n) << '\n';
    if (texture) out << "vt " << mesh.material_m(0, n) << ' ' << mesh.material_m(1, n) << '\n';
  }
  for (const auto& t : mesh.triangles) {
    out << 'f';
    for (const int n : t) {
      out << ' ' << n + 1;
      if (texture) out << '/' << n + 1;
    }
    out << "  # corner\n";
  }
  return out.str();
}

template <class T>
void put(std::string& out, T value, bool big) {
  char bytes[sizeof(T)];
  std::memcpy(bytes, &value, sizeof(T));
  if (big) std::reverse(bytes, bytes + sizeof(T));
  out.append(bytes, sizeof(T));
}

enum class Form { ascii, little, big };

/// Vertex of double x, y, z, a byte of colour, float s and t; an element that nobody knows; faces.
std::string ply_of(const SurfaceMesh& mesh, Form form) {
  std::ostringstream head;
  head.precision(17);
  const char* const names[] = {"ascii", "binary_little_endian", "binary_big_endian"};
  head << "ply\nformat " << names[static_cast<int>(form)] << " 1.0\ncomment made here\n"
       << "element vertex " << mesh.node_count() << "\nproperty double x\nproperty double y\n"
       << "property double z\nproperty uchar red\nproperty double s\nproperty double t\n"
       << "element mark 2\nproperty list uchar short where\nelement face " << mesh.triangles.size()
       << "\nproperty uchar flags\nproperty list uchar int vertex_indices\nend_header\n";
  const Eigen::Matrix3Xd x = lifted(mesh);
  if (form == Form::ascii) {
    for (int n = 0; n < mesh.node_count(); ++n)
      head << x(0, n) << ' ' << x(1, n) << ' ' << x(2, n) << " 200 " << mesh.material_m(0, n) << ' '
           << mesh.material_m(1, n) << '\n';
    head << "0\n2 -7 8\n";
    for (const auto& t : mesh.triangles)
      head << "1 3 " << t[0] << ' ' << t[1] << ' ' << t[2] << '\n';
    return head.str();
  }
  const bool big = form == Form::big;
  std::string out = head.str();
  for (int n = 0; n < mesh.node_count(); ++n) {
    for (int k = 0; k < 3; ++k) put(out, x(k, n), big);
    put<std::uint8_t>(out, 200, big);
    for (int k = 0; k < 2; ++k) put(out, mesh.material_m(k, n), big);
  }
  put<std::uint8_t>(out, 0, big);
  put<std::uint8_t>(out, 2, big);
  put<std::int16_t>(out, -7, big);
  put<std::int16_t>(out, 8, big);
  for (const auto& t : mesh.triangles) {
    put<std::uint8_t>(out, 1, big);
    put<std::uint8_t>(out, 3, big);
    for (const int n : t) put<std::int32_t>(out, n, big);
  }
  return out;
}

std::vector<std::string> all_forms(const SurfaceMesh& mesh) {
  return {obj_of(mesh, true), ply_of(mesh, Form::ascii), ply_of(mesh, Form::little),
          ply_of(mesh, Form::big)};
}

TEST(MeshText, EveryFormGivesTheMeshBack) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    const SurfaceMesh mesh = random_mesh(seed, kGrid);
    for (const std::string& text : all_forms(mesh)) {
      const auto read = read_surface_text(text);
      ASSERT_TRUE(read) << read.error().message;
      EXPECT_EQ(read->triangles, mesh.triangles);
      EXPECT_TRUE(read->positions_m == lifted(mesh));
      EXPECT_TRUE(read->texture == mesh.material_m);
      const auto back = surface_mesh(*read);
      ASSERT_TRUE(back) << back.error().message;
      EXPECT_TRUE(back->material_m == mesh.material_m);
      EXPECT_TRUE(read_surface_text(text, 1e-3)->positions_m.isApprox(1e-3 * lifted(mesh), 1e-15));
      EXPECT_TRUE(surface_mesh(*read, 0.5)->material_m == 0.5 * mesh.material_m);
    }
  }
}

TEST(MeshText, FlatSurfaceIsItsOwnMaterial) {
  const SurfaceMesh mesh = random_mesh(4, kGrid);
  const auto read = read_obj(obj_of(mesh, false));
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->texture.cols(), 0);
  const auto flat = surface_mesh(*read);
  ASSERT_TRUE(flat) << flat.error().message;
  EXPECT_NEAR(sum(triangle_areas_m2(*flat)), 0.25 * 0.125, 1e-15);
  // u is the x axis seen in the plane: here the sheet's own u, up to where the origin is
  const Eigen::Matrix2Xd shift = flat->material_m - mesh.material_m;
  EXPECT_LT((shift.colwise() - shift.col(0)).cwiseAbs().maxCoeff(), 1e-14);

  ReadMesh bent = *read;
  bent.positions_m.col(7) += 1e-4 * Eigen::Vector3d(0.8, 0.0, -0.6);
  const auto refused = surface_mesh(bent);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("node 7 is 0.09"), std::string::npos)
      << refused.error().message;
  ReadMesh flipped = *read;
  std::swap(flipped.triangles[3][0], flipped.triangles[3][1]);
  EXPECT_NE(surface_mesh(flipped).error().message.find("triangle 3"), std::string::npos);
}

TEST(MeshText, ObjForms) {
  // quads, normals, later and negative indices, a plus sign
  const auto quad =
      read_obj("v 0 0 0\nv 1 0 0\nf 1//9 2//9 3//9 4//9\n\tv +1 1e0 0 0.5\nv 0 1 0\nvn 0 0 1\n");
  ASSERT_TRUE(quad) << quad.error().message;
  EXPECT_EQ(quad->triangles, (std::vector<std::array<int, 3>>{{0, 1, 2}, {0, 2, 3}}));
  const auto back = read_obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\n");
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_EQ(back->triangles[0], (std::array<int, 3>{0, 1, 2}));
}

struct Fault {
  std::string text;
  const char* message;
};

void expect_faults(const std::vector<Fault>& faults) {
  for (const Fault& fault : faults) {
    const auto read = read_surface_text(fault.text);
    ASSERT_FALSE(read) << fault.text;
    EXPECT_EQ(read.error().kind, ErrorKind::bad_input);
    EXPECT_NE(read.error().message.find(fault.message), std::string::npos)
        << fault.text << "\n-> " << read.error().message;
  }
}

TEST(MeshText, ObjFaultsNameTheLine) {
  const std::string nodes = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  expect_faults(
      {{"", "no faces"},
       {nodes, "no faces"},
       {"v 0 0\n", "line 1: 2 numbers"},
       {"v 0 0 nan\n", "line 1: 'nan'"},
       {"v 0 0 1e999\n", "line 1: '1e999'"},
       {"v 0 0 0x\n", "line 1: '0x'"},
       {nodes + "f 1 2\n", "line 4: a face of 2 corners"},
       {nodes + "f 1 2 3 1 2\n", "line 4: a face of more than 4"},
       {nodes + "f 1 2 0\n", "line 4: face corner '0' names no node"},
       {nodes + "f 1 2 -4\n", "line 4: face corner '-4' names no node"},
       {nodes + "f 1 2 -9223372036854775808\n", "line 4"},
       {nodes + "f 1 2 4\n", "line 4: there is no node 4"},
       {nodes + "f 1 2 99999999999999999999\n", "line 4"},
       {nodes + "f 1 2 x\n", "line 4: face corner 'x'"},
       {nodes + "vt 0 0\nf 1/1 2/1 3/2\n", "line 5: there is no texture coordinate 2"},
       {nodes + "vt 0 0\nf 1/1 2/1 3\n", "line 5: some corners"},
       {nodes + "vt 0 0\nf 1 2/1 3\n", "line 5: some corners"},
       {nodes + "vt 0 0\nvt 1 1\nf 1/1 2/1 3/1\nf 1/2 2/1 3/1\n", "line 7: node 1 has two"},
       {nodes + "curv 0 1 2\n", "line 4: unknown word 'curv'"},
       {std::string("\0\1\2", 3), "line 1: unknown word"}});
}

std::string ply(const std::string& head, const std::string& data) {
  return "ply\nformat ascii 1.0\n" + head + "end_header\n" + data;
}

TEST(MeshText, PlyFaultsNameTheLine) {
  const std::string xyz = "property float x\nproperty float y\nproperty float z\n";
  const std::string list = "property list uchar int vertex_indices\n";
  const std::string head =
      "element vertex 3\n" + xyz + "element face 1\n" + list;  // 11 lines in all
  const std::string nodes = "0 0 0\n1 0 0\n0 1 0\n";           // 10, 11, 12
  ASSERT_TRUE(read_ply(ply(head, nodes + "3 0 1 2\n")));
  expect_faults({{"ply\n", "line 1"},
                 {"ply\nformat ascii 2.0\n", "line 2: only version 1.0"},
                 {"ply\nformat morse 1.0\n", "line 2: unknown format 'morse'"},
                 {"ply\nend_header\n", "line 2: the header names no format"},
                 {ply("element vertex -1\n", ""), "line 3"},
                 {ply("property float x\n", ""), "line 3: a property before any element"},
                 {ply("element vertex 1\nproperty half x\n", ""), "line 4: unknown type 'half'"},
                 {ply("element vertex 1\nproperty list float int x\n", ""), "line 4: 'float'"},
                 {ply("bananas\n", ""), "line 3: unknown word 'bananas'"},
                 {ply(list, ""), "line 3"},
                 {ply("element face 0\n" + list, ""), "no element 'vertex'"},
                 {ply("element vertex 1\nproperty float x\n", "1\n"), "lacks x, y or z"},
                 {ply("element vertex 1\n" + xyz + "element vertex 1\n" + xyz, "0 0 0\n0 0 0\n"),
                  "'vertex' twice"},
                 {ply(head, nodes), "face"},
                 {ply(head, "0 0 0\n1 0\n0 1 0\n3 0 1 2\n"), "line 11: fewer values"},
                 {ply(head, "0 0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"), "line 10: more values"},
                 {ply(head, "0 0 inf\n1 0 0\n0 1 0\n3 0 1 2\n"), "line 10: 'inf'"},
                 {ply(head, nodes + "3 0 1 3\n"), "line 13: a face names node 3"},
                 {ply(head, nodes + "3 0 1 -1\n"), "line 13: a face names node -1"},
                 {ply(head, nodes + "3 0 1 0.5\n"), "line 13: a face names node 0.5"},
                 {ply(head, nodes + "5 0 1 2 0 1\n"), "line 13: a face of 5 corners"},
                 {ply(head, nodes + "-3 0 1 2\n"), "line 13: a list of length"}});
}

/// Counts that lie are refused before anything is made of them: a gigabyte would fail the test's
/// time and memory.
TEST(MeshText, HostileCounts) {
  const std::string xyz = "property float x\nproperty float y\nproperty float z\n";
  const std::string faces = "element face 1\nproperty list uint int vertex_indices\n";
  for (const char* count : {"1000000000000", "9223372036854775807", "1000"})
    for (const char* format : {"ascii", "binary_little_endian", "binary_big_endian"}) {
      const std::string start = std::string("ply\nformat ") + format + " 1.0\n";
      expect_faults({{start + "element vertex " + count + "\n" + xyz + "end_header\n0 0 0\n",
                      "cannot stand in the 6 bytes"},
                     {start + "element vertex 0\n" + xyz + "element x " + count + "\nend_header\n",
                      "has no properties"}});
    }
  expect_faults(
      {{"ply\nformat ascii 1.0\nelement vertex 9223372036854775808\n" + xyz, "line 3"},
       {ply("element vertex 0\n" + xyz + faces, "4000000000 1 2 3\n"), "more values than"},
       {"ply\nformat binary_little_endian 1.0\nelement vertex 0\n" + xyz + faces +
            "end_header\n\xff\xff\xff\xff....",
        "row 0 of element 'face': a list of more values than"}});
}

/// No prefix and no changed byte of a good file does harm; nothing read is out of range.
TEST(MeshText, PrefixesAndChangedBytes) {
  const SurfaceMesh mesh = random_mesh(5, {3, 3, 0.2, 0.2});
  int refused = 0;
  const auto judge = [&](const std::string& text) {
    const auto read = read_surface_text(text);
    refused += read ? 0 : 1;
    if (!read) return;
    for (const auto& t : read->triangles)
      for (const int n : t) ASSERT_TRUE(n >= 0 && n < read->positions_m.cols());
    ASSERT_TRUE(read->positions_m.allFinite());
    (void)surface_mesh(*read);
  };
  testing::Numbers numbers(17);
  for (const std::string& text : all_forms(mesh)) {
    for (std::size_t size = 0; size < text.size(); ++size) judge(text.substr(0, size));
    for (int round = 0; round < 2000; ++round) {
      std::string changed = text;
      const auto at = static_cast<std::size_t>(numbers.between(0.0, 0.999999) *
                                               static_cast<double>(text.size()));
      changed[at] = static_cast<char>(numbers.between(0.0, 255.0));
      judge(changed);
    }
  }
  EXPECT_GT(refused, 3000);
}

}  // namespace
}  // namespace tenter::mechanics
