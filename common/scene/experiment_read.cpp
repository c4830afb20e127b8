// SPDX-License-Identifier: Apache-2.0
#include "common/scene/experiment_read.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace tenter::scene {

namespace {

const Kind& kind_of(const JsonNode& node, const std::vector<Kind>& kinds) {
  const std::string name = node["kind"].text();
  std::string known;
  for (const Kind& kind : kinds) {
    if (kind.name == name) return kind;
    known += (known.empty() ? "" : ", ") + std::string(kind.name);
  }
  node["kind"].refuse("is '" + name + "', must be one of " + known);
}

void expect_keys(const JsonNode& node, const Kind& kind) {
  node.expect_object();
  for (const std::string& key : node.keys())
    if (key != "id" && key != "kind" && key != "words" &&
        std::find(kind.keys.begin(), kind.keys.end(), key) == kind.keys.end())
      node.child(key).refuse("is no key of the kind '" + std::string(kind.name) + "'");
}

bool has_key(const Kind& kind, std::string_view key) {
  return std::find(kind.keys.begin(), kind.keys.end(), key) != kind.keys.end();
}

Measure read_measure(const JsonNode& node) {
  const Kind& kind = kind_of(node, measure_kinds());
  expect_keys(node, kind);
  Measure measure;
  measure.id = node["id"].text();
  measure.kind = kind.name;
  measure.words = node.text_or("words", std::string(kind.words));
  if (has_key(kind, "strain")) measure.strain = node["strain"].text();
  if (has_key(kind, "clip")) measure.clip = node["clip"].text();
  measure.at = node.text_or("at", "");
  measure.from = node.text_or("from", "");
  measure.like = node.text_or("like", "");
  measure.share = node.number_or("share", 0.0);
  measure.width_m = node.number_or("width_m", measure.width_m);
  measure.bound_m_s = node.number_or("bound_m_s", measure.bound_m_s);
  return measure;
}

Curve read_curve(const JsonNode& node) {
  const Kind& kind = kind_of(node, curve_kinds());
  expect_keys(node, kind);
  Curve curve;
  curve.id = node["id"].text();
  curve.kind = kind.name;
  curve.words = node.text_or("words", std::string(kind.words));
  if (has_key(kind, "strain")) curve.strain = node["strain"].text();
  if (has_key(kind, "clip")) curve.clip = node["clip"].text();
  curve.at = node.text_or("at", "");
  if (node.has("direction")) curve.direction = node["direction"].numbers<3>();
  return curve;
}

Picture read_picture(const JsonNode& node) {
  node.expect_object({"title", "at", "eye", "up"});
  Picture picture;
  picture.title = node["title"].text();
  picture.at = node.text_or("at", "");
  if (node.has("eye")) picture.eye = node["eye"].numbers<3>();
  if (node.has("up")) picture.up = node["up"].numbers<3>();
  return picture;
}

Variant read_variant(const JsonNode& node) {
  node.expect_object({"name", "without_laws", "pace", "scene"});
  Variant variant;
  variant.name = node["name"].text();
  if (node.has("without_laws")) variant.without_laws = node["without_laws"].texts();
  variant.pace = node.number_or("pace", 1.0);
  if (node.has("scene")) {
    node["scene"].expect_object();
    if (node["scene"].has("experiment"))
      node["scene"]["experiment"].refuse("a variant has no experiment of its own");
    variant.patch = node["scene"].json().dump();
  }
  return variant;
}

/// The first thing that is wrong.
class ExperimentCheck {
 public:
  explicit ExperimentCheck(const Scene& scene) : scene_(scene) {
    moments_.insert({"", "start"});
    for (const Phase& phase : scene.protocol) moments_.insert(phase.name);
  }
  void that(bool good, const std::string& path, const std::string& reason) {
    if (!good && trouble_.empty()) trouble_ = path + ": " + reason;
  }
  void moment(const std::string& name, const std::string& path) {
    that(moments_.count(name) > 0, path, "there is no phase '" + name + "'");
  }
  void clip(const std::string& id, const std::string& path) {
    bool found = id.empty();
    for (const Clip& clip : scene_.clips) found = found || clip.id == id;
    that(found, path, "there is no clip '" + id + "'");
  }
  void line(const std::string& text, const std::string& path) {
    bool good = !text.empty() && text.size() <= 200;
    for (const char c : text) good = good && static_cast<unsigned char>(c) >= 0x20 && c != 0x7f;
    that(good, path, "must be 1 to 200 bytes of text without line feeds");
  }
  void direction(const std::array<double, 3>& v, const std::string& path) {
    that(std::isfinite(v[0] + v[1] + v[2]) && std::hypot(v[0], v[1], v[2]) > 0.0, path,
         "must be a finite vector with a length");
  }
  Expected<void> result() const {
    if (trouble_.empty()) return {};
    return bad_input(trouble_);
  }

 private:
  const Scene& scene_;
  std::set<std::string> moments_;
  std::string trouble_;
};

std::string entry(const char* list, std::size_t index) {
  return std::string("experiment.") + list + "[" + std::to_string(index) + "]";
}

}  // namespace

const std::vector<Kind>& measure_kinds() {
  static const std::vector<Kind> kinds = {
      {"mean_strain", {"strain", "at"}, "mean strain"},
      {"rms_strain", {"strain", "at"}, "rms strain"},
      {"rms_curvature", {"strain", "at"}, "rms curvature"},
      {"work", {"clip", "from", "at"}, "work done by the clip"},
      {"force_difference", {"clip"}, "largest difference of force to the first run"},
      {"kinetic_energy", {"at"}, "kinetic energy"},
      {"curvature_change", {"from", "at"}, "rms change of curvature"},
      {"wrinkle_height", {"from", "at", "width_m"}, "height of wrinkles"},
      {"wrinkle_likeness", {"from", "at", "like", "width_m"}, "likeness of wrinkles"},
      {"settling_time", {"from", "bound_m_s"}, "time to settle"},
  };
  return kinds;
}

const std::vector<Kind>& curve_kinds() {
  static const std::vector<Kind> kinds = {
      {"force_travel", {"clip", "direction"}, "force against travel"},
      {"curvature_along", {"strain", "at", "direction"}, "curvature along the material"},
      {"kinetic_energy", {}, "kinetic energy"},
  };
  return kinds;
}

Experiment read_experiment(const JsonNode& node) {
  node.expect_object({"run", "measures", "curves", "pictures", "variants"});
  Experiment experiment;
  experiment.run = node.text_or("run", experiment.run);
  if (node.has("measures"))
    for (const JsonNode& one : node["measures"].list())
      experiment.measures.push_back(read_measure(one));
  if (node.has("curves"))
    for (const JsonNode& one : node["curves"].list()) experiment.curves.push_back(read_curve(one));
  if (node.has("pictures"))
    for (const JsonNode& one : node["pictures"].list())
      experiment.pictures.push_back(read_picture(one));
  if (node.has("variants"))
    for (const JsonNode& one : node["variants"].list())
      experiment.variants.push_back(read_variant(one));
  return experiment;
}

Expected<void> check_experiment(const Scene& scene) {
  const Experiment& experiment = *scene.experiment;
  ExperimentCheck check(scene);
  std::set<std::string> ids;
  for (std::size_t i = 0; i < experiment.measures.size(); ++i) {
    const Measure& measure = experiment.measures[i];
    const std::string path = entry("measures", i);
    check.line(measure.id, path + ".id");
    check.that(ids.insert(measure.id).second, path + ".id", "'" + measure.id + "' is used twice");
    check.line(measure.words, path + ".words");
    check.clip(measure.clip, path + ".clip");
    check.moment(measure.at, path + ".at");
    check.moment(measure.from, path + ".from");
    check.moment(measure.like, path + ".like");
    check.that(std::isfinite(measure.width_m) && measure.width_m > 0.0, path + ".width_m",
               "must be above 0");
    check.that(std::isfinite(measure.bound_m_s) && measure.bound_m_s > 0.0, path + ".bound_m_s",
               "must be above 0");
    check.that(measure.share >= 0.0 && measure.share <= 1.0, path + ".share", "must be 0 to 1");
  }
  ids.clear();
  for (std::size_t i = 0; i < experiment.curves.size(); ++i) {
    const Curve& curve = experiment.curves[i];
    const std::string path = entry("curves", i);
    check.line(curve.id, path + ".id");
    check.that(ids.insert(curve.id).second, path + ".id", "'" + curve.id + "' is used twice");
    check.line(curve.words, path + ".words");
    check.clip(curve.clip, path + ".clip");
    check.moment(curve.at, path + ".at");
    check.direction(curve.direction, path + ".direction");
  }
  for (std::size_t i = 0; i < experiment.pictures.size(); ++i) {
    const Picture& picture = experiment.pictures[i];
    const std::string path = entry("pictures", i);
    check.line(picture.title, path + ".title");
    check.moment(picture.at, path + ".at");
    check.direction(picture.eye, path + ".eye");
    check.direction(picture.up, path + ".up");
    const auto& e = picture.eye;
    const auto& u = picture.up;
    const double across =
        std::hypot(e[1] * u[2] - e[2] * u[1], e[2] * u[0] - e[0] * u[2], e[0] * u[1] - e[1] * u[0]);
    check.that(across > 1e-9 * std::hypot(e[0], e[1], e[2]) * std::hypot(u[0], u[1], u[2]),
               path + ".up", "must not point at who looks");
  }
  ids = {experiment.run};
  check.line(experiment.run, "experiment.run");
  for (std::size_t i = 0; i < experiment.variants.size(); ++i) {
    const Variant& variant = experiment.variants[i];
    const std::string path = entry("variants", i);
    check.line(variant.name, path + ".name");
    check.that(ids.insert(variant.name).second, path + ".name",
               "'" + variant.name + "' is used twice");
    check.that(std::isfinite(variant.pace) && variant.pace > 0.0, path + ".pace",
               "must be above 0");
    check.that(variant.pace == 1.0 || scene.dynamics.has_value(), path + ".pace",
               "equilibria take no time: it is for a scene with 'dynamics'");
  }
  check.that(experiment.variants.size() < 32, "experiment.variants", "has more than 31 entries");
  return check.result();
}

}  // namespace tenter::scene
