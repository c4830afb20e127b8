// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/sheet_fit/sheet_options.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace tenter::jobs {
namespace {

using estimation::Channels;
using estimation::Loss;
using estimation::Role;
using nlohmann::json;

template <class T>
struct Word {
  const char* word;
  T value;
};
constexpr Word<Role> kRoles[] = {{"stretch_u", Role::stretch_u}, {"stretch_v", Role::stretch_v},
                                 {"shear", Role::shear},         {"bend_u", Role::bend_u},
                                 {"bend_v", Role::bend_v},       {"evaluation", Role::evaluation}};
constexpr Word<bool> kStarts[] = {{"equation_gap", true}, {"model", false}};
constexpr Word<bool> kGrids[] = {{"graded", true}, {"equal", false}};
constexpr Word<bool> kKnots[] = {{"even", false}, {"data", true}};
constexpr Word<Channels> kChannels[] = {{"thesis", Channels::thesis}, {"all", Channels::all}};
constexpr Word<Loss> kLosses[] = {
    {"none", Loss::none}, {"huber", Loss::huber}, {"cauchy", Loss::cauchy}};
constexpr Word<ConvexWay> kConvexWays[] = {{"none", ConvexWay::none},
                                           {"every_step", ConvexWay::every_step},
                                           {"afterwards", ConvexWay::afterwards},
                                           {"by_construction", ConvexWay::by_construction}};
constexpr Word<HoldUnseen> kHoldUnseen[] = {
    {"none", HoldUnseen::none}, {"stand_in", HoldUnseen::stand_in}, {"start", HoldUnseen::start}};
// of unit variance lost where there are no outliers: 5 %
constexpr double kHuber = 1.345;
constexpr double kCauchy = 2.385;

/// Reads one key after the other; the first complaint stands.
class OptionReader {
 public:
  OptionReader(const json& given, const std::vector<std::string>& captures)
      : given_(given), captures_(captures) {}

  template <class T, std::size_t N>
  void word(const char* key, const Word<T> (&words)[N], T& value) {
    if (const json* found = member(key)) value = word_at(key, *found, words).value_or(value);
  }
  void whole(const char* key, int lo, int hi, int& value) {
    const json* found = member(key);
    if (found == nullptr) return;
    if (!found->is_number_integer() || found->get<long long>() < lo || found->get<long long>() > hi)
      return complain(key, "must be a whole number from " + std::to_string(lo) + " to " +
                               std::to_string(hi) + ", not " + shown(*found));
    value = found->get<int>();
  }
  void flag(const char* key, bool& value) {
    const json* found = member(key);
    if (found == nullptr) return;
    if (!found->is_boolean()) return complain(key, "must be true or false, not " + shown(*found));
    value = found->get<bool>();
  }
  void positive(const char* key, double& value) {
    const json* found = member(key);
    if (found == nullptr) return;
    const double x = found->is_number() ? found->get<double>() : -1.0;
    if (!(x > 0.0) || !std::isfinite(x))
      return complain(key, "must be a number above zero, not " + shown(*found));
    value = x;
  }
  /// A word, or a number of at least zero, which makes it `otherwise`.
  template <class T, std::size_t N>
  void word_or_number(const char* key, const Word<T> (&words)[N], T otherwise, T& value,
                      double& number) {
    const json* found = member(key);
    if (found == nullptr) return;
    if (!found->is_number()) return word(key, words, value);
    if (!(found->get<double>() >= 0.0) || !std::isfinite(found->get<double>()))
      return complain(key, "must not be below zero: " + shown(*found));
    value = otherwise;
    number = found->get<double>();
  }
  void roles(std::map<std::string, Role>& roles) {
    by_capture("roles", [&](const std::string& path, const std::string& id, const json& value) {
      if (const auto role = word_at(path, value, kRoles)) roles[id] = *role;
    });
  }
  void weights(std::map<std::string, double>& weights) {
    by_capture("weights", [&](const std::string& path, const std::string& id, const json& value) {
      const double x = value.is_number() ? value.get<double>() : -1.0;
      if (!(x > 0.0) || !std::isfinite(x))
        return complain(path, "must be a number above zero, not " + shown(value));
      weights[id] = x;
    });
  }
  void held_out(std::set<std::string>& held_out) {
    const json* found = member("held_out");
    if (found == nullptr) return;
    if (!found->is_array()) return complain("held_out", "must be a list of captures");
    for (std::size_t i = 0; i < found->size(); ++i) {
      const std::string path = "held_out[" + std::to_string(i) + "]";
      const json& entry = (*found)[i];
      if (!entry.is_string() || !is_capture(entry.get<std::string>()))
        return complain(path, "is no capture of this job: " + shown(entry));
      held_out.insert(entry.get<std::string>());
    }
  }

  void complain(const std::string& path, const std::string& what) {
    if (complaint_.empty()) complaint_ = "options." + path + ": " + what;
  }
  /// What was not asked for by any of the functions above.
  void refuse_others() {
    for (const auto& [key, value] : given_.items())
      if (!known_.contains(key)) complain(key.substr(0, 64), "no such option of a sheet's fit");
  }
  const std::string& complaint() const { return complaint_; }

 private:
  static std::string shown(const json& value) {
    return value.dump(-1, ' ', false, json::error_handler_t::replace).substr(0, 80);
  }
  const json* member(const char* key) {
    known_.insert(key);
    const auto found = given_.find(key);
    return found == given_.end() || found->is_null() ? nullptr : &*found;
  }
  bool is_capture(const std::string& id) const {
    return std::find(captures_.begin(), captures_.end(), id) != captures_.end();
  }
  template <class T, std::size_t N>
  std::optional<T> word_at(const std::string& path, const json& value, const Word<T> (&words)[N]) {
    std::string all;
    for (const Word<T>& word : words) {
      if (value.is_string() && value.get_ref<const std::string&>() == word.word) return word.value;
      all += (all.empty() ? "" : ", ") + std::string(word.word);
    }
    complain(path, "must be one of " + all + ", not " + shown(value));
    return std::nullopt;
  }
  template <class Take>
  void by_capture(const char* key, const Take& take) {
    const json* found = member(key);
    if (found == nullptr) return;
    if (!found->is_object()) return complain(key, "must be an object with captures as its keys");
    for (const auto& [id, value] : found->items()) {
      const std::string path = std::string(key) + "." + id.substr(0, 64);
      if (!is_capture(id)) return complain(path, "is no capture of this job");
      take(path, id, value);
    }
  }

  const json& given_;
  const std::vector<std::string>& captures_;
  std::set<std::string> known_;
  std::string complaint_;
};

/// What only all keys together say.
void check_roles(const SheetFitOptions& options, const std::vector<std::string>& captures,
                 OptionReader& reader) {
  bool is_any_fitted = false;
  for (const std::string& id : captures) {
    if (options.held_out.contains(id)) continue;
    if (options.staged && !options.roles.contains(id))
      reader.complain("roles", "capture " + id.substr(0, 12) +
                                   " has none; a staged fit needs to know what each is for");
    is_any_fitted |= !options.is_held_out(id);
  }
  if (!is_any_fitted) reader.complain("held_out", "no capture is left to fit to");
}

}  // namespace

Role SheetFitOptions::role_of(const std::string& capture) const {
  const auto found = roles.find(capture);
  return found == roles.end() ? Role::evaluation : found->second;
}

bool SheetFitOptions::is_held_out(const std::string& capture) const {
  if (held_out.contains(capture)) return true;
  const auto found = roles.find(capture);
  return found != roles.end() && found->second == Role::evaluation;
}

const char* role_name(Role role) {
  for (const Word<Role>& word : kRoles)
    if (word.value == role) return word.word;
  return "";
}

const char* convex_word(ConvexWay way) {
  for (const Word<ConvexWay>& word : kConvexWays)
    if (word.value == way) return word.word;
  return "";
}

Expected<SheetFitOptions> read_sheet_options(const json& given,
                                             const std::vector<std::string>& captures) {
  SheetFitOptions options;
  if (!given.is_null() && !given.is_object()) return bad_input("options: must be an object");
  const json none = json::object();
  OptionReader reader(given.is_null() ? none : given, captures);
  reader.whole("resolution", 3, 201, options.resolution);
  reader.word("grid", kGrids, options.has_graded_grid);
  reader.whole("points", 0, 1000000, options.points);
  reader.whole("frames", 0, 1000000, options.frames);
  reader.word("start", kStarts, options.first_guess);
  reader.flag("staged", options.staged);
  reader.whole("max_control_points", 1, 12, options.max_control_points);
  reader.word("knots", kKnots, options.knots_from_data);
  reader.flag("keep_points", options.keep_points);
  reader.word("channels", kChannels, options.channels);
  reader.roles(options.roles);
  reader.held_out(options.held_out);
  reader.weights(options.weights);
  reader.word("robust", kLosses, options.loss.kind);
  options.loss.scale = options.loss.kind == Loss::cauchy ? kCauchy : kHuber;
  reader.flag("profiles", options.profiles);
  reader.whole("starts", 0, 1000, options.starts);
  reader.whole("seed", 0, 1000000000, options.seed);
  reader.word("convex", kConvexWays, options.convex);
  reader.whole("samples", 0, 16, options.samples);
  reader.flag("limits", options.limits);
  if (options.staged) options.hold_unseen = HoldUnseen::stand_in;
  reader.word_or_number("hold_unseen", kHoldUnseen, HoldUnseen::value, options.hold_unseen,
                        options.held_at);
  reader.flag("without_grid_error", options.without_grid_error);
  reader.positive("sigma_m", options.sigma_m);
  reader.positive("sigma_N", options.sigma_N);
  reader.refuse_others();
  if (given.is_object() && given.contains("seed") && options.starts == 0)
    reader.complain("seed", "there are no starts that it would choose");
  if (options.keep_points && options.staged)
    reader.complain("keep_points", "only of a fit of all curves at once: stages begin with one");
  if (reader.complaint().empty()) check_roles(options, captures, reader);
  if (!reader.complaint().empty()) return bad_input(reader.complaint());
  return options;
}

json options_json(const SheetFitOptions& options) {
  json roles = json::object();
  for (const auto& [id, role] : options.roles) roles[id] = role_name(role);
  const auto word = [](const auto& words, const auto& value) {
    return std::find_if(std::begin(words), std::end(words),
                        [&](const auto& entry) { return entry.value == value; })
        ->word;
  };
  json all = {{"resolution", options.resolution},
              {"grid", word(kGrids, options.has_graded_grid)},
              {"points", options.points},
              {"frames", options.frames},
              {"start", word(kStarts, options.first_guess)},
              {"staged", options.staged},
              {"max_control_points", options.max_control_points},
              {"knots", word(kKnots, options.knots_from_data)},
              {"keep_points", options.keep_points},
              {"channels", word(kChannels, options.channels)},
              {"roles", roles},
              {"held_out", options.held_out},
              {"weights", options.weights},
              {"robust", word(kLosses, options.loss.kind)},
              {"profiles", options.profiles},
              {"starts", options.starts},
              {"convex", convex_word(options.convex)},
              {"samples", options.samples},
              {"limits", options.limits},
              {"hold_unseen", options.hold_unseen == HoldUnseen::value
                                  ? json(options.held_at)
                                  : json(word(kHoldUnseen, options.hold_unseen))},
              {"without_grid_error", options.without_grid_error}};
  if (options.starts > 0) all["seed"] = options.seed;
  if (options.sigma_m > 0.0) all["sigma_m"] = options.sigma_m;
  if (options.sigma_N > 0.0) all["sigma_N"] = options.sigma_N;
  return all;
}

}  // namespace tenter::jobs
