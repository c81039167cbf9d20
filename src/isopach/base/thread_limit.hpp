// How many threads the system lets this process start.
#pragma once

namespace isopach {

/// The number of threads beside this one, up to `wanted`, that can run at once here: it starts them and lets them end.
/// Limits of processes and of address space count. oneTBB itself ends the program when a thread does not start. Cost:
/// some 20 µs a thread.
[[nodiscard]] int startable_threads(int wanted);

/// Threads that all cores can run, as far as this process may use them.
[[nodiscard]] int all_cores();

}  // namespace isopach
