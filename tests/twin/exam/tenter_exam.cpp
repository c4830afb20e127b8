// SPDX-License-Identifier: GPL-3.0-or-later
// tenter-exam: examines the diagnosis on twins in which a known effect hides.
//
//   tenter-exam --effects viscosity internal_friction --sizes 3 10 --seeds 5 --threads 2
//   --list-failures tenter-exam --full --out exam          writes exam/exam.txt and exam/exam.json
//
// Exit code 0 where every target is met, 1 where one is missed, 2 on bad options.
#include <CLI/CLI.hpp>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <string>
#include <vector>

#include "tests/twin/exam/question.h"
#include "tests/twin/exam/sheet.h"
#include "tests/twin/exam/sit.h"

namespace {

using namespace tenter::exam;

struct Options {
  Paper paper;
  bool full = false;
  bool list_failures = false;
  int threads = 1;
  std::string out;
};

/// The whole examination: the rich suite at three sizes with nulls and foreign effects, and the
/// questions of rate where the rate is hidden.
std::vector<Paper> full_examination(std::uint64_t first_seed) {
  Paper rich;
  rich.sizes = {1.0, 3.0, 10.0};
  rich.seeds = 10;
  rich.nulls = 200;
  rich.foreign = true;
  rich.resolve = true;
  rich.first_seed = first_seed;
  Paper hidden_rate;
  hidden_rate.effects = {"internal_friction", "strain_dependent_friction", "viscosity"};
  hidden_rate.suites = {"single_rate", "no_time"};
  hidden_rate.seeds = 10;
  hidden_rate.nulls = 40;
  hidden_rate.resolve = true;
  hidden_rate.first_seed = first_seed;
  Paper pairs;
  pairs.sizes = {3.0};
  pairs.seeds = 0;
  pairs.pairs = 100;
  pairs.first_seed = first_seed;
  Paper sheets = rich;
  sheets.suites = {"sheet_field"};
  sheets.seeds = 2;
  sheets.nulls = 20;
  Paper markers = sheets;
  markers.suites = {"sheet_markers"};
  markers.sizes = {3.0, 10.0};
  markers.seeds = 1;
  Paper sheets_at_one_rate = hidden_rate;
  sheets_at_one_rate.suites = {"sheet_single_rate", "sheet_no_time"};
  sheets_at_one_rate.seeds = 2;
  sheets_at_one_rate.nulls = 8;
  return {rich, hidden_rate, pairs, sheets, markers, sheets_at_one_rate};
}

void write_file(const std::filesystem::path& path, const auto& write) {
  std::ofstream file(path);
  write(file);
  if (!file.flush()) std::cerr << "tenter-exam: cannot write " << path.string() << "\n";
}

int run(const Options& options) {
  std::vector<Question> questions;
  const std::vector<Paper> papers =
      options.full ? full_examination(options.paper.first_seed) : std::vector<Paper>{options.paper};
  for (const Paper& paper : papers) {
    auto more = set_questions(paper);
    if (!more) {
      std::cerr << "tenter-exam: " << more.error().message << "\n";
      return 2;
    }
    questions.insert(questions.end(), more->begin(), more->end());
  }
  std::size_t answered = 0;
  const std::vector<Entry> entries = sit(questions, options.threads, [&](const Entry& entry) {
    std::cerr << "[" << ++answered << "/" << questions.size() << "] "
              << grade_name(entry.mark.grade) << ": " << entry.question.name() << " -> "
              << entry.answer.line() << "\n";
    if (options.list_failures) write_failures({entry}, std::cerr);
  });
  write_table(entries, std::cout);
  if (!options.out.empty()) {
    std::error_code error;
    std::filesystem::create_directories(options.out, error);
    write_file(std::filesystem::path(options.out) / "exam.txt", [&](std::ostream& out) {
      write_table(entries, out);
      write_failures(entries, out);
    });
    write_file(std::filesystem::path(options.out) / "exam.json",
               [&](std::ostream& out) { write_json(entries, out); });
  }
  for (const auto& [kind, own] : apart(entries))
    for (const Figure& figure : figures(own))
      if (!figure.met()) return 1;
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app{"Examines the diagnosis on synthetic captures with hidden effects."};
  app.add_flag("--full", options.full,
               "the whole examination, some hours on two cores: sheets cost 10 to 20 s each");
  app.add_option("--effects", options.paper.effects, "ids of the effects to hide; default: all");
  app.add_option("--sizes", options.paper.sizes, "effect over noise; default: 3 10")
      ->check(CLI::PositiveNumber);
  app.add_option("--suites,--suite", options.paper.suites,
                 "rich, single_rate, no_time, knit_like, specimens; sheet_field, sheet_markers, "
                 "sheet_single_rate, sheet_no_time; default: rich");
  app.add_option("--seeds", options.paper.seeds, "questions of each effect and size; default: 3")
      ->check(CLI::NonNegativeNumber);
  app.add_option("--nulls", options.paper.nulls, "twins in which nothing hides; default: 0")
      ->check(CLI::NonNegativeNumber);
  app.add_option("--pairs", options.paper.pairs,
                 "twins of each size in which two effects hide; default: 0")
      ->check(CLI::NonNegativeNumber);
  app.add_flag("--compare", options.paper.compare,
               "errors on left-out data with those of the model that holds what hides");
  app.add_flag("--resolve", options.paper.resolve,
               "do the capture that an AMBIGUOUS answer asks for, and ask again");
  app.add_flag("--foreign", options.paper.foreign, "effects that the catalogue lacks, too");
  app.add_option("--first-seed", options.paper.first_seed, "default: 1");
  app.add_option("--threads", options.threads)->check(CLI::Range(1, 64));
  app.add_flag("--list-failures", options.list_failures,
               "tell every answer that is not right as it comes");
  app.add_option("--out", options.out, "folder for exam.txt and exam.json");
  CLI11_PARSE(app, argc, argv);
  return run(options);
}
