// SPDX-License-Identifier: Apache-2.0
#include "common/report/experiment/found.h"

#include <cmath>

#include "common/report/words.h"

namespace tenter::report {

namespace {

struct ShownUnit {
  std::string name;
  double factor = 1.0;
};

/// Of a unit, for values up to `largest`.
ShownUnit shown_unit(const std::string& unit, double largest) {
  if (unit == "m") return {"mm", 1e3};
  if (unit == "J") return largest < 1e-4 ? ShownUnit{"\u00b5J", 1e6} : ShownUnit{"mJ", 1e3};
  if (unit == "1") return {"%", 1e2};
  return {unit, 1.0};
}

double largest_of(const Json& values) {
  double most = 0.0;
  for (const Json& value : values) most = std::max(most, std::abs(number(value).value_or(0.0)));
  return most;
}

std::vector<double> scaled(const Json& values, double factor) {
  std::vector<double> result;
  for (const Json& value : values) result.push_back(factor * number(value).value_or(NAN));
  return result;
}

/// Of the curves of this number in all runs: lines in one plot share their units.
double largest_of(const Json& runs, std::size_t number_of_curve, const char* axis) {
  double most = 0.0;
  for (const Json& run : runs) {
    const Json& curves = list(run, "curves");
    if (number_of_curve < curves.size())
      most = std::max(most, largest_of(list(member(curves[number_of_curve], axis), "values")));
  }
  return most;
}

FoundLine line_of(const Json& curve, double largest_x, double largest_y) {
  FoundLine line;
  line.words = text(curve, "words");
  const auto axis = [](const Json& from, double largest, std::string& label,
                       std::vector<double>& values) {
    const ShownUnit unit = shown_unit(text(from, "unit"), largest);
    label = text(from, "name") + " (" + unit.name + ")";
    values = scaled(list(from, "values"), unit.factor);
  };
  axis(member(curve, "x"), largest_x, line.x_label, line.x);
  axis(member(curve, "y"), largest_y, line.y_label, line.y);
  return line;
}

Point3 point_of(const Json& value, const Point3& otherwise) {
  if (!value.is_array() || value.size() != 3) return otherwise;
  Point3 p{};
  for (std::size_t c = 0; c < 3; ++c) p[c] = number(value[c]).value_or(NAN);
  return p;
}

FoundPicture picture_of(const Json& from) {
  FoundPicture picture;
  picture.title = text(from, "title");
  picture.view.eye = point_of(member(from, "eye"), picture.view.eye);
  picture.view.up = point_of(member(from, "up"), picture.view.up);
  for (const Json& value : list(from, "position_m"))
    picture.points.push_back(point_of(value, {NAN, NAN, NAN}));
  return picture;
}

std::vector<Corners> triangles_of(const Json& run) {
  std::vector<Corners> triangles;
  for (const Json& value : list(run, "triangles")) {
    const Point3 corners = point_of(value, {-1.0, -1.0, -1.0});
    Corners triangle = {-1, -1, -1};  // no node: not painted
    for (std::size_t c = 0; c < 3; ++c)
      if (corners[c] >= 0.0 && corners[c] < 1e9) triangle[c] = static_cast<int>(corners[c]);
    triangles.push_back(triangle);
  }
  return triangles;
}

}  // namespace

Expected<Found> found_of(const std::string& result_json) {
  const Json result = Json::parse(result_json, nullptr, false);
  if (result.is_discarded() || text(result, "schema") != "tenter.simulation")
    return bad_input("this is no result of a simulated scene");
  return found_of(result);
}

Expected<Found> found_of(const Json& result) {
  const Json& experiment = member(result, "experiment");
  if (!experiment.is_object()) return bad_input("the scene has no experiment, so it has no figure");
  Found found;
  found.scene = text(result, "scene");
  found.model = text(result, "model");
  const Json& runs = list(experiment, "runs");
  for (const Json& from : runs) {
    RunFound run;
    run.name = text(from, "name");
    run.reason = text(from, "reason");
    const Json& curves = list(from, "curves");
    for (std::size_t c = 0; c < curves.size(); ++c)
      run.lines.push_back(line_of(curves[c], largest_of(runs, c, "x"), largest_of(runs, c, "y")));
    for (const Json& picture : list(from, "pictures")) run.pictures.push_back(picture_of(picture));
    run.triangles = triangles_of(from);
    found.runs.push_back(std::move(run));
  }
  for (const Json& measure : list(experiment, "measures")) {
    const std::string id = text(measure, "id");
    double most = 0.0;
    std::vector<std::optional<double>> values;
    for (const Json& run : runs) {
      values.push_back(number(member(run, "measures"), id.c_str()));
      most = std::max(most, std::abs(values.back().value_or(0.0)));
    }
    const ShownUnit unit = shown_unit(text(measure, "unit"), most);
    found.heads.push_back(text(measure, "words") +
                          (unit.name.empty() ? "" : " (" + unit.name + ")"));
    for (std::size_t r = 0; r < found.runs.size(); ++r)
      found.runs[r].numbers.push_back(values[r] ? significant(unit.factor * *values[r])
                                                : significant(std::nullopt));
  }
  return found;
}

}  // namespace tenter::report
