// Where the numbers come from: processor, cores, memory, compiler, load. No names of hosts or people.
#pragma once
#include <string>

namespace isopach::bench {

[[nodiscard]] std::string machine_description();
[[nodiscard]] double machine_load();  ///< programs that want a core, mean of the last minute

}  // namespace isopach::bench
