// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/twin/exam/sheet.h"

#include <algorithm>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>
#include <ostream>
#include <set>

#include "tests/twin/sheets/sheet_suite.h"

namespace tenter::exam {
namespace {

constexpr double kSmallestCounted = 3.0;
constexpr double kReached = 0.8;

bool found(const Entry& entry) {
  return !entry.mark.holding.empty();
}

bool is_made(const Entry& entry) {
  return entry.question.twin.size >= kSmallestCounted &&
         entry.answer.achieved_size >= kReached * entry.question.twin.size;
}

bool counts_for_recall(const Entry& entry) {
  return entry.question.kind == Kind::effect && is_made(entry);
}

bool is_pair(const Entry& entry) {
  return entry.question.kind == Kind::pair && is_made(entry);
}

bool has_wrong_name(const Entry& entry) {
  return !entry.mark.wrong_names.empty() || !entry.mark.wrong_groups.empty();
}

template <class Belongs, class Counts>
Figure figure(const std::string& name, const std::vector<Entry>& entries, Belongs belongs,
              Counts counts) {
  Figure result;
  result.name = name;
  for (const Entry& entry : entries) {
    if (!belongs(entry)) continue;
    ++result.of;
    if (counts(entry)) ++result.count;
  }
  return result;
}

template <class... Values>
std::string formatted(const char* format, Values... values) {
  char text[200];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

std::string size_text(double size) {
  return formatted("%g", size);
}

/// What the answer says, as one column of the confusion matrix each.
std::set<std::string> columns_of(const Entry& entry) {
  std::set<std::string> columns;
  if (!entry.answer.trouble.empty()) return {"(failed)"};
  for (const Said& said : entry.answer.said) {
    if (said.verdict == "NAMED" || said.verdict == "SENSOR") columns.insert(said.effect);
    if (said.verdict == "AMBIGUOUS") {
      const std::vector<std::string> group = said.group();
      std::string leader = said.effect;
      for (const std::string& truth : entry.question.truths)
        if (std::any_of(group.begin(), group.end(),
                        [&](const std::string& id) { return counts_as(id, truth); }))
          leader = truth;
      columns.insert("~" + leader);
    }
  }
  if (entry.mark.unexplained) columns.insert("(unexplained)");
  if (columns.empty()) columns.insert("(nothing)");
  return columns;
}

std::string row_of(const Entry& entry) {
  return entry.question.kind == Kind::null ? "(null)" : entry.question.truth();
}

void write_recall(const std::vector<Entry>& entries, std::ostream& out) {
  // suite and effect -> size -> {found, certain, wrong, asked}
  struct Cell {
    int found = 0, certain = 0, wrong = 0, asked = 0;
  };
  std::map<std::string, std::map<double, Cell>> rows;
  std::set<double> sizes;
  for (const Entry& entry : entries) {
    if (entry.question.kind != Kind::effect) continue;
    sizes.insert(entry.question.twin.size);
    Cell& cell =
        rows[entry.question.twin.suite + " " + entry.question.truth()][entry.question.twin.size];
    ++cell.asked;
    if (found(entry)) ++cell.found;
    if (entry.mark.certain) ++cell.certain;
    if (has_wrong_name(entry)) ++cell.wrong;
  }
  if (rows.empty()) return;
  out << "found / asked (NAMED or SENSOR; with a wrong name), by size over noise\n";
  out << formatted("%-40s", "");
  for (const double size : sizes) out << formatted("  %-18s", size_text(size).c_str());
  out << "\n";
  for (const auto& [name, cells] : rows) {
    out << formatted("%-40s", name.c_str());
    for (const double size : sizes) {
      const auto at = cells.find(size);
      const Cell cell = at == cells.end() ? Cell() : at->second;
      const std::string text =
          formatted("%d/%d (%d; %d)", cell.found, cell.asked, cell.certain, cell.wrong);
      out << formatted("  %-18s", cell.asked > 0 ? text.c_str() : "-");
    }
    out << "\n";
  }
  out << "\n";
}

void write_confusion(const std::vector<Entry>& entries, std::ostream& out) {
  std::map<std::string, std::map<std::string, int>> matrix;
  std::map<std::string, int> asked;
  for (const Entry& entry : entries) {
    const std::string row = row_of(entry) + (entry.question.rate_hidden ? " (rate hidden)" : "");
    ++asked[row];
    for (const std::string& column : columns_of(entry)) ++matrix[row][column];
  }
  out << "confusion: what hides -> what was said (~: an ambiguity group that holds the truth, else "
         "the group's first)\n";
  for (const auto& [row, columns] : matrix) {
    out << formatted("%-40s %4d ->", row.c_str(), asked[row]);
    for (const auto& [column, count] : columns) out << "  " << column << " " << count;
    out << "\n";
  }
  out << "\n";
}

nlohmann::json json_of(const Entry& entry) {
  nlohmann::json verdicts = nlohmann::json::array();
  for (const Said& said : entry.answer.said)
    verdicts.push_back({{"verdict", said.verdict},
                        {"effect", said.effect},
                        {"alternatives", said.alternatives},
                        {"size", said.size},
                        {"interval", {said.size_lo, said.size_hi}}});
  nlohmann::json json = {{"suite", entry.question.twin.suite},
                         {"truth", entry.question.truth()},
                         {"forms", entry.question.twin.effects},
                         {"size", entry.question.twin.size},
                         {"achieved_size", entry.answer.achieved_size},
                         {"true_share_of_force", entry.answer.true_share},
                         {"seed", entry.question.twin.seed},
                         {"grade", grade_name(entry.mark.grade)},
                         {"wrong_names", entry.mark.wrong_names},
                         {"wrong_groups", entry.mark.wrong_groups},
                         {"verdicts", verdicts},
                         {"path", entry.answer.path},
                         {"noise_floor", entry.answer.noise_floor},
                         {"error_before", entry.answer.error_before},
                         {"error_after", entry.answer.error_after},
                         {"unexplained_share", entry.answer.unexplained_share},
                         {"seconds", entry.answer.seconds}};
  if (entry.answer.held_out_before) json["held_out_before"] = *entry.answer.held_out_before;
  if (entry.answer.held_out_after) json["held_out_after"] = *entry.answer.held_out_after;
  if (!entry.answer.trouble.empty()) json["trouble"] = entry.answer.trouble;
  return json;
}

}  // namespace

bool Figure::met() const {
  if (of == 0) return true;
  const double judged = mean.value_or(share());
  return (!at_least || judged >= *at_least) && (!at_most || judged <= *at_most);
}

/// Error on left-out data over that of the true model: how many stay within a tenth, and the mean.
Figure held_out_figure(const std::vector<Entry>& entries) {
  Figure result;
  result.name = "left-out error within 1.10 of the true model's";
  double sum = 0.0;
  for (const Entry& entry : entries) {
    const Answer& answer = entry.answer;
    const bool asked = entry.question.kind != Kind::foreign && answer.held_out_after &&
                       answer.held_out_truth && *answer.held_out_truth > 0.0;
    if (!asked) continue;
    const double ratio = *answer.held_out_after / *answer.held_out_truth;
    sum += ratio;
    ++result.of;
    if (ratio <= 1.10) ++result.count;
  }
  if (result.of > 0) result.mean = sum / result.of;
  result.at_most = 1.10;
  return result;
}

/// The statement that names what hides, with its interval; nothing where the force is not its
/// measure (an accident, readings, a camera).
const Said* sized_statement(const Entry& entry) {
  static const std::set<std::string> kNotOfForce = {
      "outliers",       "clip_slip",  "camera_scale",  "camera_pose",
      "occlusion_bias", "wrong_mass", "heterogeneity", "load_cell_quantisation"};
  if (entry.question.kind != Kind::effect || entry.answer.true_share <= 0.0 ||
      kNotOfForce.contains(entry.question.truths.front()) || !entry.mark.wrong_names.empty())
    return nullptr;
  for (const Said& said : entry.answer.said)
    if ((said.verdict == "NAMED" || said.verdict == "SENSOR" || said.verdict == "AMBIGUOUS") &&
        counts_as(said.effect, entry.question.truths.front()))
      return &said;
  return nullptr;
}

std::vector<Figure> figures(const std::vector<Entry>& entries) {
  const auto is = [](Kind kind) {
    return [kind](const Entry& entry) { return entry.question.kind == kind; };
  };
  std::vector<Figure> list;
  list.push_back(figure("effects found, size 3 and more", entries, counts_for_recall, found));
  list.back().at_least = 0.95;
  std::set<double> sizes;
  for (const Entry& entry : entries)
    if (entry.question.kind == Kind::effect) sizes.insert(entry.question.twin.size);
  for (const double size : sizes) {
    list.push_back(figure(
        "  found at size " + size_text(size), entries,
        [size](const Entry& entry) {
          return entry.question.kind == Kind::effect && entry.question.twin.size == size;
        },
        found));
  }
  list.push_back(figure(
      "  found as NAMED or SENSOR, where the rate is not hidden", entries,
      [](const Entry& entry) { return counts_for_recall(entry) && !entry.question.rate_hidden; },
      [](const Entry& entry) { return entry.mark.certain; }));
  list.back().at_least = 0.80;
  list.push_back(figure("pairs, size 3 and more: both named", entries, is_pair,
                        [](const Entry& entry) { return entry.mark.held.size() == 2; }));
  list.back().at_least = 0.85;
  list.push_back(figure(
      "AMBIGUOUS, right, resolved by the capture it proposes", entries,
      [](const Entry& entry) {
        return counts_for_recall(entry) && entry.answer.was_ambiguous && found(entry) &&
               !entry.mark.certain;
      },
      [](const Entry& entry) { return entry.mark.resolved; }));
  list.back().at_least = 0.90;
  const auto hides = [](const Entry& entry) {
    return entry.question.kind == Kind::effect || entry.question.kind == Kind::pair;
  };
  list.push_back(figure("wrong names, any size", entries, hides, has_wrong_name));
  list.back().at_most = 0.02;
  list.push_back(figure("  of these NAMED or SENSOR", entries, hides,
                        [](const Entry& entry) { return !entry.mark.wrong_names.empty(); }));
  list.push_back(figure("false alarms on null twins", entries, is(Kind::null), has_wrong_name));
  list.back().at_most = 0.05;
  list.push_back(figure("  of these NAMED or SENSOR", entries, is(Kind::null),
                        [](const Entry& entry) { return !entry.mark.wrong_names.empty(); }));
  list.back().at_most = 0.01;
  list.push_back(figure("foreign effects unexplained and unnamed", entries, is(Kind::foreign),
                        [](const Entry& entry) { return entry.mark.grade == Grade::right; }));
  list.back().at_least = 0.90;
  list.push_back(held_out_figure(entries));
  list.push_back(figure(
      "95 % intervals of sizes hold the truth", entries,
      [](const Entry& entry) { return sized_statement(entry) != nullptr; },
      [](const Entry& entry) {
        const Said* said = sized_statement(entry);
        return said->size_lo <= entry.answer.true_share && entry.answer.true_share <= said->size_hi;
      }));
  list.push_back(figure(
      "questions without an answer", entries, [](const Entry&) { return true; },
      [](const Entry& entry) { return entry.mark.grade == Grade::no_answer; }));
  list.back().at_most = 0.0;
  return list;
}

std::vector<std::pair<std::string, std::vector<Entry>>> apart(const std::vector<Entry>& entries) {
  std::vector<std::pair<std::string, std::vector<Entry>>> kinds;
  for (const char* kind : {"curves", "sheets"}) {
    std::vector<Entry> own;
    for (const Entry& entry : entries)
      if (twin::is_sheet_suite(entry.question.twin.suite) == (kind == std::string("sheets")))
        own.push_back(entry);
    if (!own.empty()) kinds.emplace_back(kind, std::move(own));
  }
  return kinds;
}

namespace {

void write_kind(const std::vector<Entry>& entries, std::ostream& out) {
  for (const Figure& figure : figures(entries)) {
    if (figure.of == 0) continue;
    out << formatted("%-58s %4d of %4d  %5.1f %%", figure.name.c_str(), figure.count, figure.of,
                     100.0 * figure.share());
    if (figure.mean) out << formatted("   mean %.3f", *figure.mean);
    if (figure.at_least) out << formatted("   at least %.4g %%", 100.0 * *figure.at_least);
    if (figure.at_most) out << formatted("   at most %.4g %%", 100.0 * *figure.at_most);
    if (figure.at_least || figure.at_most) out << (figure.met() ? "   met" : "   MISSED");
    out << "\n";
  }
  out << "\n";
  write_recall(entries, out);
  write_confusion(entries, out);
}

}  // namespace

void write_table(const std::vector<Entry>& entries, std::ostream& out) {
  for (const auto& [kind, own] : apart(entries)) {
    out << kind << "\n";
    write_kind(own, out);
  }
}

void write_failures(const std::vector<Entry>& entries, std::ostream& out) {
  for (const Entry& entry : entries) {
    const bool unresolved = entry.answer.was_ambiguous && !entry.mark.resolved;
    if (entry.mark.grade == Grade::right && !unresolved) continue;
    out << grade_name(entry.mark.grade) << ": " << entry.question.name();
    if (entry.question.kind != Kind::null)
      out << formatted(" (made %.2f)", entry.answer.achieved_size);
    out << "\n    " << entry.answer.line() << "\n";
    for (const std::string& step : entry.answer.path) out << "    path: " << step << "\n";
    if (!entry.answer.proposed.empty()) out << "    next: " << entry.answer.proposed << "\n";
    for (const Said& said : entry.answer.said_next)
      if (said.verdict != "NOT_EXCITED") out << "    then: " << said.line() << "\n";
  }
}

void write_json(const std::vector<Entry>& entries, std::ostream& out) {
  nlohmann::json summary = nlohmann::json::array();
  for (const auto& [kind, own] : apart(entries))
    for (const Figure& figure : figures(own)) {
      nlohmann::json row = {{"of_what", kind}, {"name", figure.name},     {"count", figure.count},
                            {"of", figure.of}, {"share", figure.share()}, {"met", figure.met()}};
      if (figure.mean) row["mean"] = *figure.mean;
      if (figure.at_least) row["at_least"] = *figure.at_least;
      if (figure.at_most) row["at_most"] = *figure.at_most;
      summary.push_back(std::move(row));
    }
  nlohmann::json questions = nlohmann::json::array();
  for (const Entry& entry : entries) questions.push_back(json_of(entry));
  out << nlohmann::json{{"figures", summary}, {"questions", questions}}.dump(1) << "\n";
}

}  // namespace tenter::exam
