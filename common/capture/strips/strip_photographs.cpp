// SPDX-License-Identifier: Apache-2.0
#include "common/capture/strips/strip_photographs.h"

#include <array>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>
#include <vector>

#include "common/base/sha256.h"
#include "common/base/text_file.h"
#include "common/capture/csv/csv_table.h"
#include "common/capture/csv/description_parts.h"
#include "common/capture/strict_json.h"
#include "common/capture/strips/strip_profiles.h"
#include "common/capture/validate.h"
#include "common/photograph/strip_centre_line.h"

namespace tenter::capture {

namespace {

struct PhotographSpec {
  std::string file;
  photograph::StripView view;
  std::optional<double> length_m;  ///< none: as long as it looks
  double radius_m = 0.0;
  int sense = 0;
};

struct PhotographsDescription {
  Capture head;
  double sigma_m = 0.0;
  std::vector<PhotographSpec> photographs;
};

/// A list of `count` numbers, or a defect.
std::vector<double> numbers_of(JsonObject& object, const std::string& key, std::size_t count) {
  const nlohmann::json* value = object.raw(key);
  std::vector<double> numbers;
  if (value && value->is_array() && value->size() == count)
    for (const nlohmann::json& entry : *value)
      if (entry.is_number() && std::isfinite(entry.get<double>()))
        numbers.push_back(entry.get<double>());
  if (numbers.size() != count) {
    object.defect().note(object.path_of(key),
                         value ? "must be a list of " + std::to_string(count) + " numbers"
                               : std::string("is missing"));
    numbers.assign(count, 0.0);
  }
  return numbers;
}

int sense_of(JsonObject& object) {
  const std::string word = object.text_or("sense", "as_seen");
  if (word != "positive" && word != "negative" && word != "as_seen")
    object.defect().note(object.path_of("sense"), "must be \"positive\" or \"negative\"");
  return word == "positive" ? 1 : (word == "negative" ? -1 : 0);
}

PhotographSpec read_photograph(JsonObject& object, std::optional<double> usual_scale_m) {
  PhotographSpec spec;
  spec.file = object.text("file");
  const std::optional<double> scale = object.maybe_measure("pixel", "m");
  spec.view.metres_per_pixel = scale.value_or(usual_scale_m.value_or(0.0));
  if (!scale && !usual_scale_m)
    object.defect().note(object.path_of("pixel"),
                         "is missing, and so is the size of a pixel of all photographs");
  else if (!(spec.view.metres_per_pixel > 0.0))
    object.defect().note(object.path_of("pixel"), "must be above zero");
  const std::vector<double> clamp = numbers_of(object, "clamp", 2);
  spec.view.clamp_x = clamp[0];
  spec.view.clamp_y = clamp[1];
  if (object.has("region")) {
    const std::vector<double> box = numbers_of(object, "region", 4);
    std::array<int, 4> region{};
    for (std::size_t i = 0; i < region.size(); ++i)
      region[i] = static_cast<int>(std::lround(std::fmax(-1.0, std::fmin(box[i], 1e6))));
    spec.view.region = region;
  }
  if (const std::optional<double> threshold = object.maybe_number("threshold")) {
    if (!(*threshold >= 1.0 && *threshold <= 255.0))
      object.defect().note(object.path_of("threshold"), "must be a grey level from 1 to 255");
    else
      spec.view.threshold = static_cast<int>(*threshold);
  }
  spec.length_m = object.maybe_measure("length", "m");
  if (spec.length_m && !(*spec.length_m > 0.0))
    object.defect().note(object.path_of("length"), "must be above zero");
  if (const std::optional<double> radius = object.maybe_measure("radius", "m")) {
    if (!(*radius > 0.0))
      object.defect().note(object.path_of("radius"),
                           "must be above zero; a strip that was never rolled has none");
    spec.radius_m = *radius;
  }
  spec.sense = sense_of(object);
  object.finish();
  return spec;
}

void read_photographs(JsonObject& root, PhotographsDescription& out) {
  if (const std::string schema = root.text_or("schema", "tenter.describe");
      schema != "tenter.describe")
    root.defect().note("schema", "is \"" + schema + "\", not \"tenter.describe\"");
  if (root.maybe_number("version").value_or(1.0) != 1.0) root.defect().note("version", "must be 1");
  Description parts;
  parts.head.kind = root.text("kind");
  parts.head.title = root.text("title");
  read_specimen(root.object("specimen"), parts.head.specimen);
  read_protocol(root.object("protocol"), parts);
  read_provenance(root.object("provenance"), parts);
  if (parts.head.protocol.phases.size() > 1)
    root.defect().note("protocol.phases", "are more than one, which strips do not have");
  out.head = parts.head;
  const std::optional<double> scale = root.maybe_measure("pixel", "m");
  out.sigma_m = root.maybe_measure("point_sigma", "m").value_or(0.0);
  for (JsonObject& object : root.objects("photographs"))
    out.photographs.push_back(read_photograph(object, scale));
  if (out.photographs.empty()) root.defect().note("photographs", "must list one or more");
  root.finish();
}

struct SeenStrip {
  std::vector<std::array<double, 2>> points_m;
  double length_m = 0.0;
};

Expected<SeenStrip> see(const PhotographSpec& spec, const std::string& path) {
  const auto image = photograph::read_png(path);
  if (!image) return tl::unexpected(image.error());
  auto line = photograph::strip_centre_line(*image, spec.view);
  if (!line) return fail(line.error().kind, path + ": " + line.error().message + ".");
  return SeenStrip{std::move(line->points_m), spec.length_m.value_or(line->length_m)};
}

Channel channel_named(const char* name, Quantity quantity, const char* unit) {
  Channel channel;
  channel.name = name;
  channel.quantity = quantity;
  channel.unit = channel.source_unit = unit;
  return channel;
}

std::string group_of(const PhotographSpec& spec) {
  const std::string sense = spec.sense > 0 ? ", positive" : (spec.sense < 0 ? ", negative" : "");
  return (spec.radius_m > 0.0 ? "radius " + csv_number(spec.radius_m) + " m" : "never rolled") +
         sense;
}

Capture capture_of(const PhotographsDescription& description,
                   const std::vector<SeenStrip>& strips) {
  Capture capture = description.head;
  if (capture.protocol.phases.empty())
    capture.protocol.phases.push_back({"profiles", "other", std::nullopt});
  std::vector<Channel> channels = {
      channel_named("x", Quantity::position, "m"), channel_named("y", Quantity::position, "m"),
      channel_named("radius", Quantity::length, "m"),
      channel_named("length", Quantity::length, "m"), channel_named("sense", Quantity::other, "1")};
  for (std::size_t c = 0; c < 2; ++c) {
    channels[c].point = "strip";
    channels[c].coordinate = c == 0 ? 'x' : 'y';
    channels[c].sigma = description.sigma_m;
  }
  std::map<std::string, int> sizes;
  for (const PhotographSpec& spec : description.photographs) ++sizes[group_of(spec)];
  for (std::size_t s = 0; s < strips.size(); ++s) {
    const PhotographSpec& spec = description.photographs[s];
    const std::string group = group_of(spec);
    capture.runs.push_back({static_cast<int>(s) + 1, sizes[group] > 1 ? group : ""});
    for (std::size_t i = 0; i < strips[s].points_m.size(); ++i) {
      capture.frame.push_back(static_cast<int>(i) + 1);
      capture.run.push_back(static_cast<int>(s));
      capture.phase.push_back(0);
      capture.branch.push_back(Branch::other);
      const std::array<double, 5> values = {strips[s].points_m[i][0], strips[s].points_m[i][1],
                                            spec.radius_m, strips[s].length_m,
                                            static_cast<double>(spec.sense)};
      for (std::size_t c = 0; c < values.size(); ++c) channels[c].values.push_back(values[c]);
    }
  }
  capture.channels = std::move(channels);
  return capture;
}

}  // namespace

bool describes_strip_photographs(const std::string& text) {
  const nlohmann::json document = nlohmann::json::parse(text, nullptr, false);
  return document.is_object() && document.value("kind", nlohmann::json()) == kStripsKind &&
         document.contains("photographs");
}

Expected<Capture> import_strip_photographs(const std::string& describe_path) {
  constexpr std::size_t kMaxJsonBytes = 16000000;
  const Expected<std::string> text = read_text_file(describe_path, kMaxJsonBytes);
  if (!text) return tl::unexpected(text.error());
  const Expected<nlohmann::json> document = parse_json(*text, describe_path);
  if (!document) return tl::unexpected(document.error());
  JsonDefect defect;
  JsonObject root(*document, "", defect);
  PhotographsDescription description;
  read_photographs(root, description);
  if (defect) return bad_input(describe_path + ": " + defect.sentence() + ".");
  std::vector<SeenStrip> strips;
  std::string sums, names;
  for (const PhotographSpec& spec : description.photographs) {
    const std::filesystem::path path =
        std::filesystem::path(describe_path).parent_path() / spec.file;
    auto strip = see(spec, path.string());
    if (!strip) return tl::unexpected(strip.error());
    strips.push_back(std::move(*strip));
    const Expected<std::string> sum = sha256_file(path);
    if (!sum) return tl::unexpected(sum.error());
    sums += *sum + "\n";
    names += (names.empty() ? "" : ", ") + spec.file;
  }
  Capture capture = capture_of(description, strips);
  if (capture.provenance.imported_from.empty()) {
    capture.provenance.imported_from = names;
    // of several photographs: of the list of their sums
    capture.provenance.imported_sha256 =
        strips.size() == 1 ? sums.substr(0, sums.size() - 1) : sha256_hex(sums);
  }
  if (auto ok = validate(capture); !ok)
    return fail(ok.error().kind, describe_path + ": " + ok.error().message + ".");
  return capture;
}

}  // namespace tenter::capture
