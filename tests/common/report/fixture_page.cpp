// SPDX-License-Identifier: Apache-2.0
// Writes the fixture's page (and, with --hostile, one full of markup) for the browser test:
// fixture_page OUT.html; with --sheet that of a fit to a sheet, with --scene
// that of a simulated scene.
#include <fstream>
#include <iostream>
#include <string>

#include "common/report/html_report.h"
#include "tests/common/report/experiment/fixture_simulation.h"
#include "tests/common/report/fixture_result.h"
#include "tests/common/report/sheet/fixture_sheet.h"

int main(int argc, char** argv) {
  if (argc < 2) return 2;
  nlohmann::ordered_json result = tenter::report::fixture::result();
  if (argc > 2 && std::string(argv[2]) == "--sheet") result = tenter::report::fixture::sheet_fit();
  if (argc > 2 && std::string(argv[2]) == "--scene") result = tenter::report::fixture::simulation();
  if (argc > 2 && std::string(argv[2]) == "--hostile") {
    const std::string attack =
        "\"'></title></svg><script>console.error('owned')</script><img src=http://127.0.0.1:9/x "
        "onerror=\"console.error('owned')\">";
    for (auto& capture : result["captures"]) capture["title"] = attack;
    for (auto& verdict : result["verdicts"]) verdict["words"] = attack;
    for (auto& figure : result["figures"]) {
      figure["title"] = attack;
      for (auto& series : figure["series"]) series["name"] = attack;
    }
  }
  const auto page = tenter::report::render_html(result.dump());
  if (!page) {
    std::cerr << page.error().message << "\n";
    return 1;
  }
  std::ofstream(argv[1]) << *page;
  return 0;
}
