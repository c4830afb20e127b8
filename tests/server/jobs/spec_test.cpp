// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/spec.h"

#include <gtest/gtest.h>

#include "tests/server/jobs/jobs_fixture.h"

namespace tenter::jobs {
namespace {

std::string complaint(const std::string& text) {
  const auto spec = parse_spec(text);
  EXPECT_FALSE(spec) << text;
  if (spec) return "";
  EXPECT_EQ(spec.error().kind, ErrorKind::bad_input);
  return spec.error().message;
}

TEST(Spec, OrderAndSpacesDoNotMatter) {
  const auto one = MUST(parse_spec(spec_text("a")));
  const auto two =
      MUST(parse_spec(R"({ "options": {"fake": {}, "nonce": "a"}, "model": {}, "captures": [")" +
                      kCapture + R"("], "kind": "fit", "version": 1, "schema": "tenter.job" })"));
  EXPECT_EQ(one.canonical, two.canonical);
  EXPECT_EQ(one.sha256, two.sha256);
  EXPECT_EQ(one.kind, "fit");
  EXPECT_EQ(one.captures, std::vector<std::string>{kCapture});
  EXPECT_NE(one.sha256, MUST(parse_spec(spec_text("b"))).sha256);
}

TEST(Spec, MissingOptionsAreEmptyOptions) {
  const std::string head = R"({"schema":"tenter.job","version":1,"kind":"fit","captures":[")" +
                           kCapture + R"("],"model":{})";
  EXPECT_EQ(MUST(parse_spec(head + "}")).sha256,
            MUST(parse_spec(head + R"(,"options":{}})")).sha256);
}

TEST(Spec, ComplaintsNameTheKey) {
  const auto with = [](const std::string& from, const std::string& to) {
    std::string text = spec_text("a");
    return text.replace(text.find(from), from.size(), to);
  };
  EXPECT_NE(complaint("{").find("not JSON"), std::string::npos);
  EXPECT_NE(complaint("[]").find("not a JSON object"), std::string::npos);
  EXPECT_NE(complaint(with("tenter.job", "tenter.jab")).find("\"schema\""), std::string::npos);
  EXPECT_NE(complaint(with("\"version\":1", "\"version\":2")).find("\"version\""),
            std::string::npos);
  EXPECT_NE(complaint(with("\"version\":1", "\"version\":1.0")).find("\"version\""),
            std::string::npos);
  EXPECT_NE(complaint(with("\"fit\"", "\"fitt\"")).find("\"kind\""), std::string::npos);
  EXPECT_NE(complaint(with(kCapture, "abc")).find("captures[0]"), std::string::npos);
  EXPECT_NE(complaint(with("\"" + kCapture + "\"", "")).find("at least one capture"),
            std::string::npos);
  EXPECT_NE(complaint(with("\"" + kCapture + "\"", "\"" + kCapture + "\",\"" + kCapture + "\""))
                .find("twice"),
            std::string::npos);
  EXPECT_NE(complaint(with("\"model\":{}", "\"model\":[]")).find("\"model\""), std::string::npos);
  EXPECT_NE(complaint(with("\"options\":", "\"option\":")).find("unknown key \"option\""),
            std::string::npos);
  EXPECT_NE(complaint(with("\"kind\"", "\"version\"")).find("twice"), std::string::npos);
  EXPECT_NE(complaint(with("\"a\"", "\"\xff\"")).find("JSON"), std::string::npos);
  EXPECT_NE(complaint(std::string(kMaxSpecBytes + 1, ' ')).find("more than the allowed"),
            std::string::npos);
  EXPECT_NE(complaint(with("{}", std::string(500000, '['))).find("JSON"), std::string::npos);
  EXPECT_NE(
      complaint(with("{}", std::string(400000, '[') + std::string(400000, ']'))).find("nested"),
      std::string::npos);
}

TEST(Spec, TheModelIsCheckedByWhoKnowsModels) {
  const auto refuse_all = [](std::string_view) -> Expected<void> {
    return bad_input("terms: missing");
  };
  const auto spec = parse_spec(spec_text("a"), refuse_all);
  ASSERT_FALSE(spec);
  EXPECT_EQ(spec.error().message, "job specification: model: terms: missing");
}

std::string scene_text(const std::string& more = "", const std::string& kind = "simulate") {
  return R"({"schema":"tenter.job","version":1,"kind":")" + kind +
         R"(","scene":{"a":1},"model":{})" + more + "}";
}

TEST(Spec, ASceneIsSimulatedOnItsOwn) {
  const auto spec = MUST(parse_spec(scene_text()));
  EXPECT_TRUE(spec.captures.empty());
  EXPECT_EQ(spec.sha256, MUST(parse_spec(scene_text(R"(,"captures":[])"))).sha256);
  EXPECT_EQ(complaint(scene_text("", "fit")),
            "job specification: \"scene\" is for simulate, not for fit");
  EXPECT_EQ(complaint(scene_text(",\"captures\":[\"" + kCapture + "\"]")),
            "job specification: a scene without a mesh file has no \"captures\"");
  EXPECT_EQ(
      complaint(R"({"schema":"tenter.job","version":1,"kind":"simulate","scene":3,"model":{}})"),
      "job specification: \"scene\" must be a scene document");
  EXPECT_EQ(complaint(R"({"schema":"tenter.job","version":1,"kind":"simulate","model":{}})"),
            "job specification: \"captures\" must be a list of capture ids");
}

TEST(Spec, TheMeshFileOfASceneIsListed) {
  const auto text = [](const std::string& captures) {
    return R"({"schema":"tenter.job","version":1,"kind":"simulate","model":{},"scene":{"mesh":)"
           R"({"kind":"file","sha256":")" +
           std::string(kCapture) + "\"}}" + captures + "}";
  };
  const auto spec = MUST(parse_spec(text(R"(,"captures":[")" + std::string(kCapture) + "\"]")));
  EXPECT_EQ(spec.captures, std::vector<std::string>{kCapture});
  EXPECT_NE(complaint(text("")).find("\"captures\" must be a list"), std::string::npos);
  EXPECT_EQ(complaint(text(R"(,"captures":[")" + std::string(64, '0') + "\"]")),
            "job specification: \"captures\" must list the scene's mesh.sha256 alone");
}

TEST(Spec, TheSceneIsCheckedByWhoKnowsScenes) {
  const auto spec = parse_spec(scene_text(), {}, [](std::string_view text) -> Expected<void> {
    return bad_input("scene: " + std::string(text));
  });
  ASSERT_FALSE(spec);
  EXPECT_EQ(spec.error().message, "job specification: scene: {\"a\":1}");
}

}  // namespace
}  // namespace tenter::jobs
