// SPDX-License-Identifier: GPL-3.0-or-later
// The graph of a symmetric pattern with unknowns of equal neighbourhood taken together, and its
// fill-reducing orders. Used by the symbolic phase alone.
#pragma once

#include <mutex>
#include <vector>

#include "server/mechanics/sparse/symmetric_pattern.h"

namespace tenter::mechanics {

/// Vertex v stands for the unknowns members[member_start[v]] .. and is coupled to the vertices
/// adjacent[start[v]] .., both directions listed, itself not.
struct BlockGraph {
  std::vector<int> start, adjacent;
  std::vector<int> member_start, members;

  int size() const { return static_cast<int>(start.size()) - 1; }
  int weight(int v) const { return member_start[v + 1] - member_start[v]; }
};

BlockGraph block_graph(const SymmetricPattern& pattern);

/// order[new] = old vertex, by approximate minimum degree (AMD).
std::vector<int> minimum_degree_order(const BlockGraph& graph);

/// order[new] = old vertex, by nested dissection (METIS). Holds metis_mutex() and re-seeds the C
/// library's rand().
std::vector<int> nested_dissection_order(const BlockGraph& graph);

/// Held wherever METIS works: it draws from the C library's one generator, which it seeds itself.
std::mutex& metis_mutex();

}  // namespace tenter::mechanics
