#include "isopach/base/parallel.hpp"

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/task_arena.h>

namespace isopach {

void run_with_threads(int threads, const std::function<void()>& work) {
  if (threads <= 0) {
    work();
    return;
  }
  // The arena alone never grows past the machine's cores; the control lifts that, so that 7 threads mean 7 anywhere.
  oneapi::tbb::global_control control(oneapi::tbb::global_control::max_allowed_parallelism,
                                      static_cast<std::size_t>(threads));
  oneapi::tbb::task_arena arena(threads);
  arena.execute(work);
}

int thread_count() { return oneapi::tbb::this_task_arena::max_concurrency(); }

}  // namespace isopach
