// SPDX-License-Identifier: Apache-2.0
#include "common/capture/strips/strip_profiles.h"

#include <cmath>

#include "common/capture/text_checks.h"

namespace tenter::capture {

namespace {

constexpr std::size_t kFewestPoints = 12;  // of which a smooth curve can be made

struct StripChannels {
  const Channel* x = nullptr;
  const Channel* y = nullptr;
  const Channel* radius = nullptr;
  const Channel* length = nullptr;
  const Channel* sense = nullptr;
};

Expected<const Channel*> channel_of(const Capture& capture, const char* name, Quantity quantity,
                                    const char* words) {
  const Channel* channel = capture.find(name);
  if (channel && (channel->quantity != quantity || channel->may_be_missing))
    return bad_input(std::string("channel ") + quoted(name) + " of strips must be " + words +
                     " without missing values");
  return channel;
}

Expected<StripChannels> strip_channels(const Capture& capture) {
  StripChannels channels;
  for (const Channel& channel : capture.channels) {
    if (channel.quantity != Quantity::position) continue;
    const Channel*& place = channel.coordinate == 'x' ? channels.x : channels.y;
    if (place != nullptr || channel.coordinate == 'z')
      return bad_input("strips have two positions, x and y, of one point name; channel " +
                       quoted(channel.name) + " is another one");
    place = &channel;
  }
  if (!channels.x || !channels.y || channels.x->point != channels.y->point)
    return bad_input("strips need two positions, x and y, of one point name");
  for (const auto& [name, quantity, words, place] :
       {std::tuple{"radius", Quantity::length, "a length", &StripChannels::radius},
        {"length", Quantity::length, "a length", &StripChannels::length},
        {"sense", Quantity::other, "of quantity other", &StripChannels::sense}}) {
    const auto found = channel_of(capture, name, quantity, words);
    if (!found) return tl::unexpected(found.error());
    channels.*place = *found;
  }
  if (!channels.length && !capture.specimen.length_m)
    return bad_input(
        "strips need a channel \"length\", or specimen.length where all have the same");
  return channels;
}

/// What a run's channel says, the same in all of its frames.
Expected<double> constant(const Channel* channel, std::size_t begin, std::size_t end,
                          double otherwise, const std::string& name) {
  if (!channel) return otherwise;
  for (std::size_t i = begin; i < end; ++i)
    if (channel->values[i] != channel->values[begin] || !std::isfinite(channel->values[i]))
      return bad_input(name + ": its " + channel->name + " changes from " +
                       std::to_string(channel->values[begin]) + " to " +
                       std::to_string(channel->values[i]) + "; a run is one strip");
  return channel->values[begin];
}

double way_along(const std::vector<std::array<double, 2>>& points) {
  double way = 0.0;
  for (std::size_t i = 1; i < points.size(); ++i)
    way += std::hypot(points[i][0] - points[i - 1][0], points[i][1] - points[i - 1][1]);
  return way;
}

std::string millimetres(double metres) {
  return std::to_string(1e3 * metres) + " mm";
}

Expected<void> check_strip(const StripProfile& strip, double sigma_m, const std::string& name) {
  if (!(strip.length_m > 0.0)) return bad_input(name + ": its length must be above zero");
  if (!(strip.radius_m >= 0.0))
    return bad_input(name + ": the radius of its cylinder must not be negative");
  if (strip.points_m.size() < kFewestPoints)
    return bad_input(name + " has " + std::to_string(strip.points_m.size()) + " points; " +
                     std::to_string(kFewestPoints) + " are needed");
  // noise makes the way longer than the strip, few points make it shorter by a little
  const double way = way_along(strip.points_m);
  const double noise = 4.0 * sigma_m * static_cast<double>(strip.points_m.size());
  if (way < 0.8 * strip.length_m)
    return bad_input(name + ": its points are " + millimetres(way) + " long where its length is " +
                     millimetres(strip.length_m) + ": a wrong unit, scale or strip?");
  if (way > 2.0 * strip.length_m + noise)
    return bad_input(name + ": the way along its points is " + millimetres(way) +
                     " where its length is " + millimetres(strip.length_m) +
                     ": are they in order from the clamp to the free end?");
  return {};
}

}  // namespace

double strip_point_sigma(const Capture& capture) {
  for (const Channel& channel : capture.channels)
    if (channel.quantity == Quantity::position) return channel.sigma;
  return 0.0;
}

Expected<std::vector<StripProfile>> strip_profiles(const Capture& capture) {
  const auto channels = strip_channels(capture);
  if (!channels) return tl::unexpected(channels.error());
  if (!capture.specimen.area_density_kg_m2)
    return bad_input(
        "strips need specimen.area_density: without the weight that bends them nothing is known "
        "of their stiffness");
  std::vector<StripProfile> strips;
  for (std::size_t begin = 0; begin < capture.frame_count();) {
    std::size_t end = begin + 1;
    while (end < capture.frame_count() && capture.run[end] == capture.run[begin]) ++end;
    const std::string name =
        "strip of run " +
        std::to_string(capture.runs[static_cast<std::size_t>(capture.run[begin])].number);
    StripProfile strip;
    strip.first_frame = begin;
    for (std::size_t i = begin; i < end; ++i)
      strip.points_m.push_back({channels->x->values[i], channels->y->values[i]});
    const auto length =
        constant(channels->length, begin, end, capture.specimen.length_m.value_or(0.0), name);
    if (!length) return tl::unexpected(length.error());
    const auto radius = constant(channels->radius, begin, end, 0.0, name);
    if (!radius) return tl::unexpected(radius.error());
    const auto sense = constant(channels->sense, begin, end, 0.0, name);
    if (!sense) return tl::unexpected(sense.error());
    if (*sense != 0.0 && std::abs(*sense) != 1.0)
      return bad_input(name + ": its sense is " + std::to_string(*sense) + ", not 1, -1 or 0");
    strip.length_m = *length;
    strip.radius_m = *radius;
    strip.sense = static_cast<int>(*sense);
    if (auto ok = check_strip(strip, strip_point_sigma(capture), name); !ok)
      return tl::unexpected(ok.error());
    strips.push_back(std::move(strip));
    begin = end;
  }
  return strips;
}

}  // namespace tenter::capture
