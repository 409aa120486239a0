// SPDX-License-Identifier: MIT
#pragma once

#include <jampack/problem/block_sparse_delassus.hpp>

namespace jampack {

/// The rows of any Delassus operator as stored blocks, for saving a problem and for solvers that factorise.
/// An operator either visits its blocks (for_each_block), or makes them (blocks()), or is asked column by
/// column, which costs n_contacts^2 velocities.
template <DelassusOperator Delassus>
Array<DelassusBlock<Delassus::n_unknowns>> stored_blocks(const Delassus& delassus) {
  constexpr int N = Delassus::n_unknowns;
  using Block = Eigen::Matrix<double, N, N>;
  if constexpr (requires { delassus.blocks(); }) {
    return delassus.blocks();
  } else {
    Array<DelassusBlock<N>> blocks;
    if constexpr (requires { delassus.for_each_block(Index{}, [](Index, const Block&) {}); }) {
      for (Index c = 0; c < delassus.n_contacts(); ++c)
        delassus.for_each_block(c, [&](Index d, const Block& block) { blocks.push_back({c, d, block}); });
    } else {
      const Eigen::VectorXd zero = Eigen::VectorXd::Zero(N * delassus.n_contacts());
      Array<Block> column(delassus.n_contacts());
      for (Index d = 0; d < delassus.n_contacts(); ++d) {
        for (int j = 0; j < N; ++j) {
          auto motion = delassus.motion(zero);
          delassus.change(motion, d, ContactVector<N>::Unit(j));
          for (Index c = 0; c < delassus.n_contacts(); ++c)
            column[c].col(j) = delassus.velocity(motion, zero, c);
        }
        for (Index c = 0; c < delassus.n_contacts(); ++c)
          if (c == d || !column[c].isZero(0)) blocks.push_back({c, d, column[c]});
      }
    }
    return blocks;
  }
}

/// W as stored blocks: itself where it is that already, else a copy.
template <int N>
const BlockSparseDelassus<N>& as_block_sparse(const BlockSparseDelassus<N>& delassus) {
  return delassus;
}
template <DelassusOperator Delassus>
BlockSparseDelassus<Delassus::n_unknowns> as_block_sparse(const Delassus& delassus) {
  return {delassus.n_contacts(), stored_blocks(delassus)};
}

}  // namespace jampack
