// SPDX-License-Identifier: MIT
#pragma once

#include <exception>
#include <jampack/core/array.hpp>

namespace jampack {

/// How many threads a computation may use. Results never depend on it: work is cut by the scene, and
/// whatever is summed is summed in the order of the scene.
struct Threads {
  int count = 1;
};

/// Calls work(i) once for every i in [0, n). Each call may write only to what belongs to i. The first
/// exception in order of i is rethrown after all calls have ended.
template <class Work>
void parallel_for(Threads threads, Index n, Work&& work) {
#ifdef _OPENMP
  if (threads.count > 1 && n > 1) {
    Array<std::exception_ptr> failures(n);
#pragma omp parallel for schedule(dynamic, 1) num_threads(threads.count)
    for (Index i = 0; i < n; ++i) {
      try {
        work(i);
      } catch (...) {
        failures[i] = std::current_exception();
      }
    }
    for (const auto& failure : failures)
      if (failure) std::rethrow_exception(failure);
    return;
  }
#else
  (void)threads;
#endif
  for (Index i = 0; i < n; ++i) work(i);
}

}  // namespace jampack
