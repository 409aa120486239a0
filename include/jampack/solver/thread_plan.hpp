// SPDX-License-Identifier: MIT
#pragma once

#ifdef _OPENMP
#include <omp.h>
#endif

#include <algorithm>
#include <jampack/core/parallel.hpp>
#include <jampack/solver/colouring.hpp>

namespace jampack {

/// Who visits which chunk, and before which classes threads must meet. Each thread has regions of its own, so
/// that their bodies stay in its cache, and meets the others only where it needs what they have changed.
struct ThreadPlan {
  Threads threads;
  Array<Index> thread;  ///< of each chunk
  Array<char> meet;     ///< before each class
};

inline ThreadPlan plan_threads(const Colouring& colouring, Threads threads) {
  const Index n_threads = std::max(1, threads.count), none = -1, several = -2;
  ThreadPlan plan{threads, Array<Index>(colouring.chunks.size(), Index{0}),
                  Array<char>(colouring.classes.size(), 0)};
  // Who has visited each region since the last meeting, and the last place for chunks of any region.
  Array<Index> visitor(colouring.n_regions + 1, none);
  const auto owner = [&](Index region) { return region * n_threads / colouring.n_regions; };
  for (Index k = 0; k < colouring.classes.size(); ++k) {
    const Colouring::Class& one = colouring.classes[k];
    const Index begin = colouring.chunks[one.first].first, size = colouring.chunks[one.last - 1].last - begin;
    Array<Index> load(n_threads, Index{0});
    for (Index c = one.first; c < one.last; ++c) {
      const auto& chunk = colouring.chunks[c];
      Index& thread = plan.thread[c];
      if (!one.shared) continue;
      if (chunk.region < 0) {
        // By its middle, so that all have about the same.
        thread = std::min((chunk.first + chunk.last - 2 * begin) * n_threads / (2 * size), n_threads - 1);
      } else {
        const Index a = owner(chunk.region), b = owner(chunk.other_region);
        thread = load[b] < load[a] ? b : a;
      }
      load[thread] += chunk.last - chunk.first;
    }
    const auto visits = [&](auto&& region_visited) {
      for (Index c = one.first; c < one.last; ++c) {
        const auto& chunk = colouring.chunks[c];
        if (chunk.region < 0)
          for (Index region = 0; region <= colouring.n_regions; ++region)
            region_visited(region, plan.thread[c]);
        else
          for (const Index region : {chunk.region, chunk.other_region, colouring.n_regions})
            if (region < colouring.n_regions || visitor[region] != none)
              region_visited(region, plan.thread[c]);
      }
    };
    visits([&](Index region, Index thread) {
      if (visitor[region] != none && visitor[region] != thread) plan.meet[k] = 1;
    });
    if (plan.meet[k] != 0) visitor.assign(visitor.size(), none);
    visits([&](Index region, Index thread) {
      visitor[region] = visitor[region] == none || visitor[region] == thread ? thread : several;
    });
  }
  return plan;
}

/// Calls visit(k) for every chunk, class by class; the chunks of a class that may be shared by several
/// threads at once. No visit may throw.
template <class Visit>
void for_each_chunk(const Colouring& colouring, const ThreadPlan& plan, const Visit& visit) {
  // One thread's part. Should there be fewer than were planned for, each has what several would have had.
  const auto work = [&](Index thread, Index n_threads) {
    for (Index k = 0; k < colouring.classes.size(); ++k) {
#ifdef _OPENMP
      if (plan.meet[k] != 0) {
#pragma omp barrier
      }
#endif
      for (Index c = colouring.classes[k].first; c < colouring.classes[k].last; ++c)
        if (plan.thread[c] % n_threads == thread) visit(c);
    }
  };
#ifdef _OPENMP
  if (plan.threads.count > 1) {
#pragma omp parallel num_threads(plan.threads.count)
    work(omp_get_thread_num(), omp_get_num_threads());
    return;
  }
#endif
  work(0, 1);
}

}  // namespace jampack
