// SPDX-License-Identifier: Apache-2.0
#include "common/capture/validate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "common/capture/sheet/sheet_validate.h"
#include "common/capture/strips/strip_profiles.h"
#include "common/capture/text_checks.h"
#include "common/capture/vocabulary.h"

namespace tenter::capture {

namespace {

constexpr std::size_t kMaxChannels = 10000;

const std::set<std::string>& reserved_names() {
  static const std::set<std::string> names = {"frame", "run", "phase", "branch", "time"};
  return names;
}

Expected<void> check_texts(const Capture& capture) {
  const Provenance& p = capture.provenance;
  const std::pair<const char*, const std::string*> texts[] = {
      {"title", &capture.title},
      {"specimen.name", &capture.specimen.name},
      {"specimen.material", &capture.specimen.material},
      {"protocol.name", &capture.protocol.name},
      {"protocol.description", &capture.protocol.description},
      {"provenance.source", &p.source},
      {"provenance.licence", &p.licence},
      {"provenance.authors", &p.authors},
      {"provenance.instrument", &p.instrument},
      {"provenance.notes", &p.notes},
      {"provenance.imported_from", &p.imported_from},
      {"provenance.imported_sha256", &p.imported_sha256}};
  for (const auto& [name, text] : texts) {
    const std::string trouble = trouble_in(*text);
    if (!trouble.empty()) return bad_input(std::string(name) + " " + trouble);
  }
  if (capture.kind != "homogeneous_strain" && capture.kind != "tracked_points" &&
      capture.kind != "deforming_sheet" && capture.kind != kStripsKind)
    return bad_input(
        "kind " + quoted(capture.kind) +
        " is not one of homogeneous_strain, tracked_points, deforming_sheet, strip_profiles");
  if (capture.sheet.has_value() != (capture.kind == "deforming_sheet"))
    return bad_input(capture.sheet ? "a capture of kind " + quoted(capture.kind) + " has no sheet"
                                   : "a capture of kind \"deforming_sheet\" needs a sheet");
  return {};
}

Expected<void> check_sizes(const Capture& capture) {
  const std::size_t n = capture.frame_count();
  if (n == 0) return bad_input("the capture has no frames");
  if (capture.runs.empty()) return bad_input("the capture has no runs");
  if (capture.protocol.phases.empty()) return bad_input("the protocol has no phases");
  const auto same = [n](const char* name, std::size_t size) -> Expected<void> {
    if (size == n) return {};
    return bad_input(std::string(name) + " has " + std::to_string(size) + " values for " +
                     std::to_string(n) + " frames");
  };
  if (auto ok = same("frame", capture.frame.size()); !ok) return ok;
  if (auto ok = same("phase", capture.phase.size()); !ok) return ok;
  if (auto ok = same("branch", capture.branch.size()); !ok) return ok;
  if (!capture.time_s.empty())
    if (auto ok = same("time", capture.time_s.size()); !ok) return ok;
  for (const Channel& channel : capture.channels) {
    if (auto ok = same(channel.name.c_str(), channel.values.size()); !ok) return ok;
    if (!channel.sigma_per_frame.empty())
      if (auto ok = same((channel.name + "_errors").c_str(), channel.sigma_per_frame.size()); !ok)
        return ok;
  }
  return {};
}

Expected<void> check_runs(const Capture& capture) {
  std::set<int> numbers;
  for (const Run& run : capture.runs) {
    if (!numbers.insert(run.number).second)
      return bad_input("run number " + std::to_string(run.number) + " appears twice");
    if (const std::string trouble = trouble_in(run.group); !trouble.empty())
      return bad_input("the group of run " + std::to_string(run.number) + " " + trouble);
  }
  const int runs = static_cast<int>(capture.runs.size());
  const int phases = static_cast<int>(capture.protocol.phases.size());
  for (std::size_t i = 0; i < capture.frame_count(); ++i) {
    const int run = capture.run[i];
    if (run < 0 || run >= runs)
      return bad_input("frame at position " + std::to_string(i) + " names run index " +
                       std::to_string(run) + " of " + std::to_string(runs));
    const int before = i == 0 ? -1 : capture.run[i - 1];
    if (run != before && run != before + 1)
      return bad_input("the frames of run " +
                       std::to_string(capture.runs[static_cast<std::size_t>(run)].number) +
                       " are not in one piece and in order");
    if (capture.phase[i] < 0 || capture.phase[i] >= phases)
      return bad_input(at_frame(capture, i) + " names phase index " +
                       std::to_string(capture.phase[i]) + " of " + std::to_string(phases));
  }
  if (capture.run.back() != runs - 1)
    return bad_input("run " + std::to_string(capture.runs.back().number) + " has no frames");
  return {};
}

Expected<void> check_order(const Capture& capture) {
  for (std::size_t i = 0; i < capture.frame_count(); ++i) {
    if (!capture.time_s.empty() && !std::isfinite(capture.time_s[i]))
      return bad_input("time is not a number at " + at_frame(capture, i));
    if (i == 0 || capture.run[i] != capture.run[i - 1]) continue;
    if (!capture.time_s.empty() && capture.time_s[i] <= capture.time_s[i - 1])
      return bad_input("time does not increase at " + at_frame(capture, i));
    if (capture.frame[i] <= capture.frame[i - 1])
      return bad_input("the frame number does not increase at " + at_frame(capture, i));
  }
  return {};
}

Expected<void> check_values(const Capture& capture, const Channel& channel) {
  for (std::size_t i = 0; i < channel.values.size(); ++i) {
    const double value = channel.values[i];
    if (std::isinf(value))
      return bad_input("channel " + quoted(channel.name) + " is infinite at " +
                       at_frame(capture, i));
    if (std::isnan(value) && !channel.may_be_missing)
      return bad_input("channel " + quoted(channel.name) + " has no value at " +
                       at_frame(capture, i) + " and does not declare missing values");
  }
  for (std::size_t i = 0; i < channel.sigma_per_frame.size(); ++i) {
    const double sigma = channel.sigma_per_frame[i];
    const bool missing = channel.may_be_missing && std::isnan(channel.values[i]);
    if (!(sigma >= 0.0 && std::isfinite(sigma)) && !(missing && std::isnan(sigma)))
      return bad_input("channel " + quoted(channel.name) +
                       " has a negative or unusable standard deviation at " + at_frame(capture, i));
  }
  return {};
}

Expected<void> check_channels(const Capture& capture) {
  if (capture.sheet && !capture.channels.empty())
    return bad_input("a deforming sheet has no channels, but here is " +
                     quoted(capture.channels.front().name));
  if (!capture.sheet && capture.channels.empty()) return bad_input("the capture has no channels");
  if (capture.channels.size() > kMaxChannels) return bad_input("the capture has too many channels");
  std::set<std::string> names;
  std::set<std::pair<std::string, char>> coordinates;
  for (const Channel& channel : capture.channels) {
    const std::string name = "channel " + quoted(channel.name);
    if (!well_formed(channel.name))
      return bad_input(name + ": a name has only letters, digits and \"_\"");
    if (reserved_names().count(channel.name) != 0 || channel.name.ends_with("_errors"))
      return bad_input(name + ": this name is reserved");
    if (!names.insert(channel.name).second) return bad_input(name + " appears twice");
    if (channel.quantity != Quantity::other && channel.unit != unit_of(channel.quantity))
      return bad_input(name + " has unit " + quoted(channel.unit) + "; a " +
                       to_word(channel.quantity) + " is kept in " +
                       quoted(unit_of(channel.quantity)));
    if (channel.quantity == Quantity::other && channel.unit.empty())
      return bad_input(name + " has no unit");
    for (const std::string* text :
         {&channel.unit, &channel.source_unit, &channel.description, &channel.point})
      if (const std::string trouble = trouble_in(*text); !trouble.empty())
        return bad_input(name + " has a text that " + trouble);
    if (!(channel.sigma >= 0.0 && std::isfinite(channel.sigma)))
      return bad_input(name + " has a negative or unusable sigma");
    if (!(channel.resolution >= 0.0 && std::isfinite(channel.resolution)))
      return bad_input(name + " has a negative or unusable resolution");
    if (channel.quantity == Quantity::position) {
      if (channel.point.empty() ||
          (channel.coordinate != 'x' && channel.coordinate != 'y' && channel.coordinate != 'z'))
        return bad_input(name + " is a position and must name its point and coordinate x, y or z");
      if (!coordinates.insert({channel.point, channel.coordinate}).second)
        return bad_input(name + ": coordinate " + std::string(1, channel.coordinate) +
                         " of point " + quoted(channel.point) + " appears twice");
    }
    if (auto ok = check_values(capture, channel); !ok) return ok;
  }
  return {};
}

Expected<void> check_specimen(const Specimen& specimen) {
  const std::pair<const char*, const std::optional<double>*> sizes[] = {
      {"length", &specimen.length_m},
      {"width", &specimen.width_m},
      {"width_y", &specimen.width_y_m},
      {"thickness", &specimen.thickness_m},
      {"cross_section", &specimen.cross_section_m2},
      {"mass", &specimen.mass_kg},
      {"area_density", &specimen.area_density_kg_m2}};
  for (const auto& [name, size] : sizes)
    if (size->has_value() && !(**size > 0.0 && std::isfinite(**size)))
      return bad_input("specimen." + std::string(name) + " must be positive, not " +
                       std::to_string(**size));
  if (!std::isfinite(specimen.axis_angle_rad))
    return bad_input("specimen.axis_angle is not a number");
  return {};
}

Expected<void> check_protocol(const Protocol& protocol) {
  const auto usable = [](const std::optional<double>& rate) {
    return !rate || (*rate > 0.0 && std::isfinite(*rate));
  };
  if (!usable(protocol.nominal_rate_per_s))
    return bad_input("protocol.nominal_rate_per_s must be positive");
  std::set<std::string> names;
  for (const Phase& phase : protocol.phases) {
    if (phase.name.empty()) return bad_input("a phase of the protocol has no name");
    if (const std::string trouble = trouble_in(phase.name); !trouble.empty())
      return bad_input("the name of a phase " + trouble);
    if (!names.insert(phase.name).second)
      return bad_input("phase " + quoted(phase.name) + " appears twice");
    const std::array<std::string, 5> kinds = {"ramp", "cycle", "hold", "step", "other"};
    if (std::find(kinds.begin(), kinds.end(), phase.kind) == kinds.end())
      return bad_input("phase " + quoted(phase.name) + " has kind " + quoted(phase.kind) +
                       ", not one of ramp, cycle, hold, step, other");
    if (!usable(phase.nominal_rate_per_s))
      return bad_input("the nominal rate of phase " + quoted(phase.name) + " must be positive");
  }
  return {};
}

bool has_point(const Capture& capture, const std::string& point) {
  return std::count_if(capture.channels.begin(), capture.channels.end(), [&](const Channel& c) {
           return c.quantity == Quantity::position && c.point == point;
         }) >= 2;
}

Expected<void> check_axis(const Capture& capture, const char* component, const AxisState& axis) {
  const std::string name = std::string("kinematics.") + component;
  const bool shear = component[1] == 'y';
  const bool measured =
      axis.role == AxisState::Role::prescribed || axis.role == AxisState::Role::observed;
  if (measured != (axis.source != AxisState::Source::none))
    return bad_input(
        name + (measured ? " is " + to_word(axis.role) + " and must name a channel or two points"
                         : " is " + to_word(axis.role) + " and must not name a channel or points"));
  if (axis.role == AxisState::Role::fixed &&
      !(std::isfinite(axis.fixed_value) && (shear || axis.fixed_value > 0.0)))
    return bad_input(name + " has an unusable fixed value");
  if (!measured) return {};

  bool needs_reference = axis.source == AxisState::Source::points;
  if (axis.source == AxisState::Source::points) {
    if (shear) return bad_input(name + " cannot come from the distance of two points");
    for (const std::string* point : {&axis.point_a, &axis.point_b})
      if (!has_point(capture, *point))
        return bad_input(name + " names point " + quoted(*point) +
                         ", which has no two position channels");
    if (axis.point_a == axis.point_b)
      return bad_input(name + " names point " + quoted(axis.point_a) + " twice");
  } else {
    const Channel* channel = capture.find(axis.channel);
    if (!channel)
      return bad_input(name + " names channel " + quoted(axis.channel) + ", which is not there");
    const Quantity q = channel->quantity;
    const bool fits = shear ? q == Quantity::shear
                            : q == Quantity::stretch || q == Quantity::strain ||
                                  q == Quantity::displacement || q == Quantity::length;
    if (!fits)
      return bad_input(name + " names channel " + quoted(axis.channel) + ", which measures " +
                       to_word(q) + (shear ? ", not shear" : ", not a stretch or length"));
    needs_reference = q == Quantity::displacement || q == Quantity::length;
    if (q == Quantity::displacement && axis.reference != AxisState::Reference::given)
      return bad_input(name + ": a displacement needs a reference length in metres");
  }
  if (needs_reference && axis.reference == AxisState::Reference::given &&
      !(axis.reference_length_m > 0.0 && std::isfinite(axis.reference_length_m)))
    return bad_input(name + " needs a positive reference length");
  return {};
}

Expected<void> check_stresses(const Capture& capture) {
  std::set<std::string> components;
  const Specimen& specimen = capture.specimen;
  for (const StressAssignment& stress : capture.stresses) {
    const std::string name = "stresses." + stress.component;
    if (stress.component != "x" && stress.component != "y" && stress.component != "xy")
      return bad_input(name + ": a component is x, y or xy");
    if (!components.insert(stress.component).second) return bad_input(name + " appears twice");
    const Channel* channel = capture.find(stress.channel);
    if (!channel)
      return bad_input(name + " names channel " + quoted(stress.channel) + ", which is not there");
    if (!is_force_like(channel->quantity))
      return bad_input(name + " names channel " + quoted(stress.channel) + ", which measures " +
                       to_word(channel->quantity) + ", not a force or stress");
    const bool width = specimen.width_m || (stress.component == "y" && specimen.width_y_m);
    if (channel->quantity == Quantity::force && !width && !specimen.cross_section_m2)
      return bad_input(name + ": the force " + quoted(stress.channel) +
                       " needs specimen.width or specimen.cross_section");
    if (channel->quantity == Quantity::stress && !specimen.thickness_m)
      return bad_input(name + ": the stress " + quoted(stress.channel) +
                       " needs specimen.thickness");
  }
  return {};
}

}  // namespace

Expected<void> validate(const Capture& capture) {
  if (auto ok = check_texts(capture); !ok) return ok;
  if (auto ok = check_sizes(capture); !ok) return ok;
  if (auto ok = check_runs(capture); !ok) return ok;
  if (auto ok = check_order(capture); !ok) return ok;
  if (auto ok = check_channels(capture); !ok) return ok;
  if (auto ok = check_specimen(capture.specimen); !ok) return ok;
  if (auto ok = check_protocol(capture.protocol); !ok) return ok;
  if (auto ok = check_axis(capture, "x", capture.kinematics.x); !ok) return ok;
  if (auto ok = check_axis(capture, "y", capture.kinematics.y); !ok) return ok;
  if (auto ok = check_axis(capture, "xy", capture.kinematics.xy); !ok) return ok;
  if (auto ok = check_stresses(capture); !ok) return ok;
  if (capture.kind == kStripsKind)
    if (const auto strips = strip_profiles(capture); !strips) return tl::unexpected(strips.error());
  return capture.sheet ? validate_sheet(capture) : Expected<void>();
}

}  // namespace tenter::capture
