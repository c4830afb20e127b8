// SPDX-License-Identifier: GPL-3.0-or-later
// A measured twin as the rig would have captured it: the file that fits through the command line
// and the server are proved on.
//
// Vertices are the places that are seen. Where those are nodes of a grid, the capture has the whole
// grid as its mesh, and what no channel sees (under clips) is missing; else they are points without
// triangles. Each force channel is a cord; the table is a support; blocks are branches. It is
// labelled synthetic.
//
//   const auto twin = same_mesh_twin(fabric, protocol, {.nodes = 25});
//   write_capture(capture_of(fabric, protocol, twin->sequence), "twin.h5");
//
// estimation::sequence_from_capture makes the same sequence of it again.
#pragma once

#include "common/capture/capture.h"
#include "server/estimation/sequences/sequence.h"
#include "tests/twin/fabrics/protocols.h"

namespace tenter::twin {

/// `sequence` is of this fabric and protocol, with measured values.
capture::Capture capture_of(const Fabric& fabric, const Protocol& protocol,
                            const estimation::Sequence& sequence);

}  // namespace tenter::twin
