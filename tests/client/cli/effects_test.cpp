// SPDX-License-Identifier: Apache-2.0
// `tenter effects`: every row of the catalogue is whole, and said the same in words and in JSON.
#include "common/effects/effects.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>

#include "client/cli/app.h"

namespace tenter::cli {
namespace {

using EffectsJson = nlohmann::ordered_json;

std::string said_by(std::vector<const char*> arguments, int expected_code) {
  arguments.insert(arguments.begin(), "tenter");
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  EXPECT_EQ(run(static_cast<int>(arguments.size()), arguments.data()), expected_code);
  const std::string out = testing::internal::GetCapturedStdout();
  const std::string err = testing::internal::GetCapturedStderr();
  return expected_code == 0 ? out : err;
}

TEST(Effects, RowsAreWholeAndNeighboursAreRows) {
  std::set<std::string> ids;
  std::set<effects::Kind> kinds;
  for (const effects::Row& row : effects::catalogue()) {
    EXPECT_TRUE(ids.insert(row.id).second) << row.id;
    EXPECT_EQ(effects::find(row.id), &row);
    kinds.insert(row.kind);
    for (const std::string* text :
         {&row.words, &row.signature, &row.extension, &row.protocol.name, &row.protocol.words})
      EXPECT_FALSE(text->empty()) << row.id;
    EXPECT_FALSE(row.mistaken_for.empty()) << row.id;
    const bool is_numerical = row.kind == effects::Kind::numerical;
    EXPECT_TRUE(is_numerical || !row.protocol.phases.empty()) << row.id;
  }
  EXPECT_GE(ids.size(), 17U);
  EXPECT_EQ(kinds.size(), 3U);
  EXPECT_EQ(effects::find("gremlins"), nullptr);
  for (const effects::Row& row : effects::catalogue())
    for (const std::string& other : row.mistaken_for) {
      EXPECT_TRUE(ids.contains(other)) << row.id << ": " << other;
      EXPECT_NE(other, row.id);
    }
}

TEST(Effects, ListAndShowSayTheSame) {
  const EffectsJson list = EffectsJson::parse(said_by({"effects", "list", "--json"}, 0))["effects"];
  ASSERT_EQ(list.size(), effects::catalogue().size());
  const std::string table = said_by({"effects", "list"}, 0);
  for (const EffectsJson& row : list) {
    const std::string id = row["id"];
    EXPECT_NE(table.find(id + " "), std::string::npos) << id;
    EXPECT_EQ(EffectsJson::parse(said_by({"effects", "show", id.c_str(), "--json"}, 0)), row);
    const std::string page = said_by({"effects", "show", id.c_str()}, 0);
    for (const char* key : {"words", "signature", "extension"})
      EXPECT_NE(page.find(row[key].get<std::string>()), std::string::npos) << id << " " << key;
    for (const EffectsJson& phase : row["protocol"]["phases"])
      EXPECT_NE(page.find(phase["words"].get<std::string>()), std::string::npos) << id;
  }
  EXPECT_NE(said_by({"effects", "show", "gremlins"}, 3).find("gremlins"), std::string::npos);
}

}  // namespace
}  // namespace tenter::cli
