// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/service/body.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <random>

namespace tenter::service {
namespace {

using nlohmann::json;

std::string complaint(std::string_view text) {
  auto body = parse_body(text);
  EXPECT_FALSE(body) << text;
  EXPECT_TRUE(body || body.error().kind == ErrorKind::bad_input);
  return body ? "" : body.error().message;
}

TEST(Body, OnlyObjectsOfReasonableDepth) {
  EXPECT_TRUE(parse_body(""));
  EXPECT_TRUE(parse_body("{}"));
  EXPECT_TRUE(parse_body(R"({"text": "[[[[[[ \" {{{{"})"));
  EXPECT_NE(complaint("[]").find("object"), std::string::npos);
  EXPECT_NE(complaint("nonsense").find("JSON"), std::string::npos);
  EXPECT_NE(complaint("{\"a\": \"\xff\"}").find("JSON"), std::string::npos);
  EXPECT_NE(complaint(std::string(50000, '[')).find("64"), std::string::npos);
  std::string deep = "{\"a\":";
  for (int i = 0; i < 100; ++i) deep += "{\"a\":";
  EXPECT_NE(complaint(deep).find("64"), std::string::npos);
}

TEST(Body, MembersAreCheckedByTypeAndBound) {
  const json body = json::parse(
      R"({"t": "x", "n": 5, "f": 1.5, "l": ["1", 2], "null": null, "big": 18446744073709551615})");
  EXPECT_EQ(required_text(body, "t").value(), "x");
  EXPECT_FALSE(required_text(body, "n"));
  EXPECT_FALSE(required_text(body, "missing"));
  EXPECT_FALSE(required_text(body, "null"));
  EXPECT_EQ(optional_text(body, "missing").value(), std::nullopt);
  EXPECT_EQ(required_integer(body, "n", 1, 5).value(), 5);
  EXPECT_FALSE(required_integer(body, "n", 1, 4));
  EXPECT_FALSE(required_integer(body, "f", 1, 5));
  EXPECT_FALSE(required_integer(body, "big", 1, 5));
  EXPECT_EQ(optional_number(body, "f").value(), 1.5);
  EXPECT_FALSE(optional_number(body, "t"));
  EXPECT_EQ(optional_jobs(body, "l").value(), (std::vector<jobs::JobId>{1, 2}));
  EXPECT_FALSE(optional_jobs(body, "t"));
  EXPECT_FALSE(required_job(body, "t"));
  EXPECT_FALSE(required_job(body, "f"));
}

TEST(Body, OctetsAtRandomNeverDoMoreThanComplain) {
  std::mt19937 random(11);
  const std::string seed = R"({"job": "12", "limit": 10, "spec": {"a": [1, 2, {"b": null}]}})";
  for (int i = 0; i < 20000; ++i) {
    std::string text = seed;
    for (int k = 0; k < 3; ++k) text[random() % text.size()] = static_cast<char>(random());
    if (random() % 4 == 0) text.resize(random() % text.size());
    const auto body = parse_body(text);
    if (!body) continue;
    (void)required_job(*body, "job");
    (void)optional_integer(*body, "limit", 1, 1000);
    (void)optional_jobs(*body, "spec");
    (void)optional_text(*body, "job");
  }
}

TEST(Body, AJobAsJson) {
  jobs::JobRecord job;
  job.id = 7;
  job.state = jobs::JobState::failed;
  job.error = Error{ErrorKind::job_failed, "out of time"};
  job.depends_on = {3};
  job.spec_json = R"({"kind":"fit"})";
  const json out = to_json(job);
  EXPECT_EQ(out["id"], "7");
  EXPECT_EQ(out["state"], "failed");
  EXPECT_EQ(out["error"]["message"], "out of time");
  EXPECT_EQ(out["depends_on"], json::array({"3"}));
  EXPECT_EQ(out["spec"]["kind"], "fit");
  EXPECT_TRUE(out["started_ms"].is_null());
  EXPECT_TRUE(out["progress"].is_null());
}

}  // namespace
}  // namespace tenter::service
