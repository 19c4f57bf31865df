// Loops over independent rows on all cores. Results never depend on the number of threads.
#pragma once
#include <cstddef>
#include <functional>

namespace togishi {

/// Calls body(begin, end) for disjoint ranges that cover [0, count), each of at most `grain` items.
/// The first exception that a range throws is rethrown here after all threads have ended.
/// threads: 0 takes as many as the machine has.
void parallel_for(std::size_t count, std::size_t grain,
                  const std::function<void(std::size_t begin, std::size_t end)>& body,
                  unsigned threads = 0);

}  // namespace togishi
