// SPDX-License-Identifier: Apache-2.0
#include <charconv>

#include "common/model/export/curves.h"

namespace tenter::model {
namespace {

/// The shortest text that reads back as the same number.
std::string number(double value) {
  char text[32];
  const auto end = std::to_chars(text, text + sizeof text, value).ptr;
  return {text, end};
}

std::string quoted(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + "\"";
}

void add_band(const Band& band, std::size_t i, std::string& row) {
  row += "," + number(band.value[i]);
  row += "," + (band.lo.empty() ? std::string() : number(band.lo[i]));
  row += "," + (band.hi.empty() ? std::string() : number(band.hi[i]));
}

}  // namespace

Expected<Exported> write_curves_csv(const Model& model, int samples) {
  const CurveSet set = curves_of(model, samples);
  if (set.curves.empty())
    return bad_input("model '" + model.name + "' has no term that is a curve of one strain");
  Exported result;
  result.losses = set.left_out;
  std::string& text = result.text;
  text =
      "term,strain_measure,strain_unit,stress_unit,stiffness_unit,strain,stress,stress_lo,stress_"
      "hi,stiffness,stiffness_lo,stiffness_hi,within_data\n";
  for (const CurveTable& table : set.curves) {
    const std::string head = quoted(table.term) + "," + table.strain_measure + "," +
                             table.strain_unit + "," + table.stress_unit + "," +
                             table.stiffness_unit;
    for (std::size_t i = 0; i < table.strain.size(); ++i) {
      const double eps = table.strain[i];
      std::string row = head + "," + number(eps);
      add_band(table.stress, i, row);
      add_band(table.stiffness, i, row);
      const bool within =
          table.reached && eps >= table.reached->first && eps <= table.reached->second;
      row += table.reached ? (within ? ",yes" : ",no") : ",unknown";
      text += row + "\n";
    }
  }
  return result;
}

}  // namespace tenter::model
