// SPDX-License-Identifier: Apache-2.0
#include "client/cli/sheet/vertex_table.h"

#include <cmath>
#include <cstdio>

#include "common/report/text_report.h"

namespace tenter::cli {

namespace {

using report::VertexResiduals;

std::string number(double value, const char* format) {
  if (!std::isfinite(value)) return "";
  char text[40];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

/// A row's numbers by name, after frame and vertex.
struct Column {
  const char* name;
  double (*value)(const VertexResiduals&, std::size_t frame, std::size_t vertex);
};

template <std::vector<double> VertexResiduals::*Positions, std::size_t Coordinate>
double coordinate(const VertexResiduals& b, std::size_t f, std::size_t v) {
  return (b.*Positions)[b.at(f, v) + Coordinate];
}

double length(const VertexResiduals& b, std::size_t f, std::size_t v) {
  return b.residual_m(f, v);
}

constexpr Column kColumns[] = {
    {"u_m",
     [](const VertexResiduals& b, std::size_t, std::size_t v) { return b.material_m[2 * v]; }},
    {"v_m",
     [](const VertexResiduals& b, std::size_t, std::size_t v) { return b.material_m[2 * v + 1]; }},
    {"measured_x_m", coordinate<&VertexResiduals::measured_m, 0>},
    {"measured_y_m", coordinate<&VertexResiduals::measured_m, 1>},
    {"measured_z_m", coordinate<&VertexResiduals::measured_m, 2>},
    {"start_x_m", coordinate<&VertexResiduals::start_m, 0>},
    {"start_y_m", coordinate<&VertexResiduals::start_m, 1>},
    {"start_z_m", coordinate<&VertexResiduals::start_m, 2>},
    {"fitted_x_m", coordinate<&VertexResiduals::fitted_m, 0>},
    {"fitted_y_m", coordinate<&VertexResiduals::fitted_m, 1>},
    {"fitted_z_m", coordinate<&VertexResiduals::fitted_m, 2>},
    {"residual_m", length},
    {"sigma_m", [](const VertexResiduals& b, std::size_t, std::size_t v) { return b.sigma_m[v]; }}};

}  // namespace

std::string vertex_text(const std::vector<VertexResiduals>& blocks) {
  std::string out;
  for (const VertexResiduals& b : blocks) {
    out += (out.empty() ? "" : "\n") + report::printable(b.capture_title) + "  " +
           b.capture_id.substr(0, 12) + "\n";
    Table lines({">frame", ">vertex", ">u mm", ">v mm", ">x mm", ">y mm", ">z mm", ">left x mm",
                 ">left y mm", ">left z mm", ">left mm", ">in sigmas"});
    for (std::size_t f = 0; f < b.frame.size(); ++f)
      for (std::size_t v = 0; v < b.vertex.size(); ++v) {
        std::vector<std::string> cells = {std::to_string(b.frame[f]), std::to_string(b.vertex[v])};
        const auto add = [&cells](double value) {
          const std::string shown = number(value, "%.4g");
          cells.push_back(shown.empty() ? "-" : shown);
        };
        add(1e3 * b.material_m[2 * v]);
        add(1e3 * b.material_m[2 * v + 1]);
        const std::size_t first = b.at(f, v);
        for (std::size_t c = 0; c < 3; ++c) add(1e3 * b.measured_m[first + c]);
        for (std::size_t c = 0; c < 3; ++c)
          add(1e3 * (b.measured_m[first + c] - b.fitted_m[first + c]));
        add(1e3 * b.residual_m(f, v));
        add(b.residual_m(f, v) / b.sigma_m[v]);
        lines.add(std::move(cells));
      }
    out += lines.text();
  }
  return out;
}

std::string vertex_csv(const std::vector<VertexResiduals>& blocks) {
  std::string out = "capture,frame,vertex";
  for (const Column& column : kColumns) out += std::string(",") + column.name;
  out += "\n";
  for (const VertexResiduals& b : blocks)
    for (std::size_t f = 0; f < b.frame.size(); ++f)
      for (std::size_t v = 0; v < b.vertex.size(); ++v) {
        out += report::printable(b.capture_id) + "," + std::to_string(b.frame[f]) + "," +
               std::to_string(b.vertex[v]);
        for (const Column& column : kColumns) out += "," + number(column.value(b, f, v), "%.9g");
        out += "\n";
      }
  return out;
}

Json vertex_json(const std::vector<VertexResiduals>& blocks, const std::string& job_id) {
  Json list = Json::array();
  for (const VertexResiduals& b : blocks) {
    Json rows = Json::array();
    for (std::size_t f = 0; f < b.frame.size(); ++f)
      for (std::size_t v = 0; v < b.vertex.size(); ++v) {
        Json row = {{"frame", b.frame[f]}, {"vertex", b.vertex[v]}};
        for (const Column& column : kColumns) {
          const double value = column.value(b, f, v);
          row[column.name] = std::isfinite(value) ? Json(value) : Json(nullptr);
        }
        rows.push_back(std::move(row));
      }
    list.push_back(
        {{"capture", b.capture_id}, {"title", b.capture_title}, {"rows", std::move(rows)}});
  }
  return {{"job_id", job_id}, {"vertices", std::move(list)}};
}

}  // namespace tenter::cli
