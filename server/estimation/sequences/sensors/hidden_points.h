// SPDX-License-Identifier: GPL-3.0-or-later
// How far from a point is the next one that a frame did not see? What hides a point is seen by the
// patches of its neighbours too, and draws them towards the camera: all of a patch that lies on it,
// a part of one that it reaches into.
//
//   share at a distance d = 1 up to 3/4 of the reach, 0 from 5/4 on, straight between
//
// A point is hidden in a frame that measured no coordinate of it, unless it lies on nodes that are
// held or clamped there; so are the frame's hidden_m, which are no channels;
// what was misread is not. A patch's size is not
// known: the reach is counted in the sequence's spacing in the material.
//
// Pure; seen points x hidden ones.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "server/estimation/sequences/sequence.h"

namespace tenter::estimation {

/// Median distance to the nearest other place; 0 where there are fewer than two.
double spacing_m(const std::vector<Eigen::Vector2d>& places_m);

/// [frame][point], in spacings, to the nearest hidden point; infinite where none is hidden, or the
/// point itself is.
std::vector<std::vector<double>> hidden_distances(const Sequence& sequence);

/// What a point shows of the bias at a distance from what is hidden; both in spacings.
double drawn_share(double distance, double reach);

}  // namespace tenter::estimation
