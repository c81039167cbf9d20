// balance: how much each node counts, so that the noise of all nodes counts alike.
//
// The noise of a node enters the equations twice: by its own residual, weighted with its own area, and by the residuals
// of the nodes of the other scan that lie over its facets. Where nodes are unevenly spread both vary from node to node,
// and a mean with uneven weights is noisier than it must be. The weights made here even out the sum of both.
#pragma once
#include "isopach/match/surface/patch.hpp"

namespace isopach {

/// Factors of the nodes' weights, `sides[s].balance`, from where the nodes are located (`views`: of the motion that
/// they are located at). Wanted: each node's own weight and its barycentric shares in the weights of the nodes over its
/// facets together are the mean of that sum over the patch. Of all weights those make the best linear estimate where
/// the noise of the nodes is equal (Gauss-Markov). Solved in part by steps of Richardson's and Lucy's iteration
/// [Richardson1972], [Lucy1974], which keeps weights positive and their sum. Nodes of weight 0 keep it.
/// Cost O(nodes). Test: tests/match/balance_test.cpp.
void balance(std::array<ResidualSide, 2>& sides, const std::array<View, 2>& views, std::size_t patch);

}  // namespace isopach
