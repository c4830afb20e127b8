// SPDX-License-Identifier: GPL-3.0-or-later
// Prints what Google Benchmark measured as one table: medians of the repetitions' CPU
// time (of all threads, so that what others do to the machine is left out), each beside the floor
// of its case in the same run.
#pragma once

#include <benchmark/benchmark.h>

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace tenter::mechanics::bench {

/// Benchmarks are named "case/way". The floor of a case is the fastest of its ways whose name
/// begins with "floor". Counters "iterations", "check" (residual of the answer or net force, N),
/// "Mflop" and "MB" become columns.
class RatioTable : public benchmark::BenchmarkReporter {
 public:
  bool ReportContext(const Context& context) override;
  void ReportRuns(const std::vector<Run>& runs) override;
  void Finalize() override;

 private:
  struct Row {
    std::string name;
    std::int64_t place = 0;  ///< in the order of registration
    std::vector<double> milliseconds;
    std::map<std::string, double> counters;
  };
  Row& row(const std::string& case_name, const std::string& way);

  std::vector<std::pair<std::string, std::vector<Row>>> cases_;
  std::vector<std::string> failures_;
};

}  // namespace tenter::mechanics::bench
