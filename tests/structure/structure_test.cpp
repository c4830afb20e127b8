// SPDX-License-Identifier: GPL-3.0-or-later
// The rooms of the project and the arrows between them, read from the #include lines: an arrow that
// runs back fails here. Also: the licence line of every source file, the libraries that only one
// room may know, and that every room has its README and CMakeLists.txt.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;

const fs::path& root() {
  static const fs::path path = fs::canonical(TENTER_TEST_DATA "/../..");
  return path;
}

/// Room -> rooms that it may include besides itself. A new room is a new row.
const std::map<std::string, std::set<std::string>>& arrows() {
  static const std::set<std::string> common = {
      "common/base",      "common/h5",         "common/capture",    "common/model",
      "common/scene",     "common/frames",     "common/report",     "common/wire",
      "common/mesh_text", "common/experiment", "common/photograph", "common/effects"};
  static const auto with = [](std::set<std::string> rooms, const std::set<std::string>& more) {
    rooms.insert(more.begin(), more.end());
    return rooms;
  };
  static const std::map<std::string, std::set<std::string>> table = {
      {"idl", {}},
      {"common/base", {}},
      {"common/h5", {"common/base"}},
      {"common/capture", {"common/base", "common/h5", "common/mesh_text", "common/photograph"}},
      {"common/photograph", {"common/base"}},
      {"common/mesh_text", {"common/base"}},
      {"common/model", {"common/base"}},
      {"common/scene", {"common/base"}},
      {"common/frames", {"common/base", "common/h5"}},
      {"common/effects", {}},
      {"common/experiment", {"common/base", "common/frames", "common/scene"}},
      {"common/report", {"common/base", "common/h5", "common/capture", "common/model"}},
      {"common/wire", {"common/base", "idl"}},
      {"server/mechanics", {"common/base", "common/mesh_text", "common/model", "common/scene"}},
      {"server/estimation", with(common, {"server/mechanics"})},
      {"server/diagnosis", with(common, {"server/mechanics", "server/estimation"})},
      {"server/jobs", with(common, {"server/mechanics", "server/estimation", "server/diagnosis"})},
      {"server/service", with(common, {"server/jobs"})},
      {"server", with(common, {"server/diagnosis", "server/jobs", "server/service"})},
      {"client/api", common},
      {"client/cli", with(common, {"client/api"})},
  };
  return table;
}

struct SourceFile {
  std::string path;  ///< from the root
  std::vector<std::string> lines;
};

bool is_script(const fs::path& path) {
  std::ifstream file(path);
  std::string line;
  return std::getline(file, line) && line.starts_with("#!");
}

const std::vector<SourceFile>& sources() {
  static const std::vector<SourceFile> files = [] {
    std::vector<SourceFile> found;
    const std::set<std::string> kinds = {".h", ".cpp", ".idl", ".py", ".sh"};
    for (const char* top : {"idl", "common", "server", "client", "tests", "deploy", ".ci"}) {
      if (!fs::exists(root() / top)) continue;
      for (const fs::directory_entry& entry : fs::recursive_directory_iterator(root() / top)) {
        if (!entry.is_regular_file()) continue;
        const bool script = !entry.path().has_extension() && is_script(entry.path());
        if (!script && kinds.count(entry.path().extension().string()) == 0) continue;
        SourceFile source{fs::relative(entry.path(), root()).string(), {}};
        std::ifstream file(entry.path());
        for (std::string line; std::getline(file, line);) source.lines.push_back(line);
        found.push_back(std::move(source));
      }
    }
    return found;
  }();
  return files;
}

/// "server/jobs/queue/queue.h" -> "server/jobs"; "server/tenterd.cpp" -> "server"; "idl/x" ->
/// "idl".
std::string room_of(const std::string& path) {
  const fs::path p(path);
  auto part = p.begin();
  const std::string top = part->string();
  if (top == "idl") return top;
  const std::string second = (++part)->string();
  return std::next(part) == p.end() ? top : top + "/" + second;
}

/// What stands between the quotes or brackets of an #include line, or "".
std::string included(const std::string& line, char open, char close) {
  const std::size_t word = line.find_first_not_of(" \t");
  if (word == std::string::npos || line.compare(word, 8, "#include") != 0) return "";
  const std::size_t begin = line.find(open);
  const std::size_t end = begin == std::string::npos ? begin : line.find(close, begin + 1);
  return end == std::string::npos ? "" : line.substr(begin + 1, end - begin - 1);
}

bool in_rooms(const std::string& path) {
  return path.starts_with("common/") || path.starts_with("server/") || path.starts_with("client/");
}

TEST(Structure, ArrowsPointOneWay) {
  std::size_t checked = 0;
  for (const SourceFile& source : sources()) {
    if (!in_rooms(source.path)) continue;
    const std::string room = room_of(source.path);
    const auto allowed = arrows().find(room);
    ASSERT_NE(allowed, arrows().end()) << room << " has no row in this test: " << source.path;
    for (const std::string& line : source.lines) {
      const std::string target = included(line, '"', '"');
      if (!in_rooms(target)) continue;
      ++checked;
      const std::string to = room_of(target);
      EXPECT_TRUE(to == room || allowed->second.count(to) > 0)
          << source.path << " includes " << target << ", but " << room << " may not know " << to;
    }
  }
  EXPECT_GT(checked, 300U);
}

TEST(Structure, TestsOfThinClientsDoNotTouchTheServer) {
  for (const SourceFile& source : sources())
    if (source.path.starts_with("tests/common/") || source.path.starts_with("tests/client/")) {
      for (const std::string& line : source.lines)
        EXPECT_FALSE(included(line, '"', '"').starts_with("server/"))
            << source.path << ": " << line;
    }
}

/// Heavy libraries stay behind one room each; mechanics is numbers only.
TEST(Structure, LibrariesStayInTheirRooms) {
  struct Rule {
    std::vector<std::string> headers;
    std::set<std::string> rooms;
  };
  const Rule rules[] = {{{"hdf5.h", "H5"}, {"common/h5"}},
                        {{"fastdds/", "fastrtps/", "fastcdr/"}, {"common/wire"}},
                        {{"sqlite3.h"}, {"server/jobs"}},
                        {{"CLI/"}, {"client/cli", "server"}},
                        {{"ceres/"}, {"server/estimation", "server/diagnosis", "server/mechanics"}},
                        {{"CGAL/"}, {"server/mechanics"}},
                        {{"udunits2.h"}, {"common/capture"}},
                        {{"png.h"}, {"common/photograph"}},
                        {{"cholmod.h", "amd.h"}, {"server/mechanics"}}};
  const std::vector<std::string> no_files_no_clock = {"fstream", "filesystem", "chrono", "thread",
                                                      "cstdio"};
  std::size_t seen = 0;
  for (const SourceFile& source : sources()) {
    if (!in_rooms(source.path)) continue;
    const std::string room = room_of(source.path);
    for (const std::string& line : source.lines) {
      const std::string header = included(line, '<', '>');
      if (header.empty()) continue;
      for (const Rule& rule : rules)
        for (const std::string& start : rule.headers)
          if (header.starts_with(start)) {
            ++seen;
            EXPECT_TRUE(rule.rooms.count(room) > 0)
                << source.path << " includes <" << header << ">";
          }
      if (room == "server/mechanics") {
        EXPECT_EQ(std::count(no_files_no_clock.begin(), no_files_no_clock.end(), header), 0)
            << source.path << " includes <" << header << ">: mechanics has no files and no clock";
      }
    }
  }
  EXPECT_GT(seen, 5U);
}

TEST(Structure, EveryFileSaysItsLicence) {
  for (const SourceFile& source : sources()) {
    const bool thin = source.path.starts_with("idl/") || source.path.starts_with("common/") ||
                      source.path.starts_with("client/") ||
                      source.path.starts_with("tests/common/") ||
                      source.path.starts_with("tests/client/");
    const std::string wanted =
        std::string("SPDX-License-Identifier: ") + (thin ? "Apache-2.0" : "GPL-3.0-or-later");
    const std::size_t first = !source.lines.empty() && source.lines[0].starts_with("#!") ? 1 : 0;
    ASSERT_GT(source.lines.size(), first) << source.path;
    EXPECT_NE(source.lines[first].find(wanted), std::string::npos)
        << source.path << " must begin with " << wanted;
  }
}

TEST(Structure, RoomsHaveAReadmeAndABuildFile) {
  for (const auto& [room, allowed] : arrows()) {
    if (room == "server") continue;
    EXPECT_TRUE(fs::exists(root() / room / "README.md")) << room;
    EXPECT_TRUE(fs::exists(root() / room / "CMakeLists.txt")) << room;
  }
}

TEST(Structure, FilesStayReadable) {
  for (const SourceFile& source : sources())
    EXPECT_LE(source.lines.size(), 600U) << source.path << ": one file, one job?";
}

/// The rules themselves: a wrong arrow would be seen.
TEST(Structure, ReadsIncludeLines) {
  EXPECT_EQ(included("#include \"server/jobs/queue/queue.h\"", '"', '"'),
            "server/jobs/queue/queue.h");
  EXPECT_EQ(included("  #include <hdf5.h>  // x", '<', '>'), "hdf5.h");
  EXPECT_EQ(included("// #include \"x.h\"", '"', '"'), "");
  EXPECT_EQ(room_of("server/mechanics/laws/dahl.cpp"), "server/mechanics");
  EXPECT_EQ(room_of("server/tenterd.cpp"), "server");
  EXPECT_EQ(arrows().at("server/mechanics").count("server/estimation"), 0U);
  EXPECT_EQ(arrows().at("client/cli").count("server/jobs"), 0U);
  EXPECT_EQ(arrows().at("common/wire").count("client/api"), 0U);
}

}  // namespace
